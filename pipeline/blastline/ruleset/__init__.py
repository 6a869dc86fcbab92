"""Rules as data: what a user may tune, read from TOML into frozen, range-checked values.

`tables` holds one struct for each table of a rule file, `files` finds, merges and reads them.
"""

from .files import Rules, actuator_names, check_rules, check_stable, load_actuator, load_rules, rules_path
from .tables import (
    ActuatorProfile,
    AlignRules,
    BurstRules,
    OnsetRules,
    QualityRules,
    RenderRules,
    ScanRules,
    SceneRules,
    SegmentRules,
    VerifyRules,
    WindowRules,
    to_builtins,
)

__all__ = [
    "ActuatorProfile",
    "AlignRules",
    "BurstRules",
    "OnsetRules",
    "QualityRules",
    "RenderRules",
    "Rules",
    "ScanRules",
    "SceneRules",
    "SegmentRules",
    "VerifyRules",
    "WindowRules",
    "actuator_names",
    "check_rules",
    "check_stable",
    "load_actuator",
    "load_rules",
    "rules_path",
    "to_builtins",
]
