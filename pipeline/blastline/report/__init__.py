"""One page for people: did it work, where are the shots, what will be felt, and why should one believe it.

The page is a single HTML file that needs no network and no script: pictures are inside it, and the few lines of script
only sort and filter the table of shots.
"""

from .bode import BodeCurve, write_bode
from .choice import MAX_FIGURES
from .exports import ExportRow
from .overview import Overview, OverviewMeter
from .page import write_report
from .summary import asked_of
from .words import CHECKS, allowed, by_name, claim, is_decided, measured, typeset

__all__ = [
    "CHECKS",
    "MAX_FIGURES",
    "BodeCurve",
    "ExportRow",
    "Overview",
    "OverviewMeter",
    "allowed",
    "asked_of",
    "by_name",
    "claim",
    "is_decided",
    "measured",
    "typeset",
    "write_bode",
    "write_report",
]
