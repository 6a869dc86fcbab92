"""The product's story, told by composing the stages; the only room that knows them all.

film -> find shots -> plan windows -> choose a model for each -> render -> write -> check what was written -> report
"""

from .actuators import actuator_table, fit_actuator, identify_actuator, usable_actuator
from .bode_plots import draw_bode
from .budget import Allowance, allowance, choose_quality
from .checking import check
from .conforming import Conformed, conform
from .export_rows import export_rows
from .exporting import export
from .fitting import FitOptions, MadeProfile
from .listening import detect
from .names import DRIVE
from .options import RenderOptions, told_options
from .rendering import render, require_place
from .rulefiles import check_rules
from .synthesis import synthesise
from .verdicts import told_count, told_failures, told_faintness, told_passes, told_unmeasured

__all__ = [
    "DRIVE",
    "Allowance",
    "Conformed",
    "FitOptions",
    "MadeProfile",
    "RenderOptions",
    "actuator_table",
    "allowance",
    "check",
    "check_rules",
    "choose_quality",
    "conform",
    "detect",
    "draw_bode",
    "export",
    "export_rows",
    "fit_actuator",
    "identify_actuator",
    "render",
    "require_place",
    "synthesise",
    "told_count",
    "told_failures",
    "told_faintness",
    "told_options",
    "told_passes",
    "told_unmeasured",
    "usable_actuator",
]
