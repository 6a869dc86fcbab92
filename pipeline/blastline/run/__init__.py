"""The product's story, told by composing the stages; the only room that knows them all.

film -> find shots -> plan windows -> choose a model for each -> render -> write -> check what was written -> report
"""

from .actuators import actuator_table
from .checking import check
from .exports import exports
from .files import export, synthesise
from .listening import detect
from .progress import Progress, no_progress
from .rendering import RenderOptions, render

__all__ = [
    "Progress",
    "RenderOptions",
    "actuator_table",
    "check",
    "detect",
    "export",
    "exports",
    "no_progress",
    "render",
    "synthesise",
]
