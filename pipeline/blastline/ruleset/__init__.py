"""Rules as data: what a user may tune, read from TOML into frozen, range-checked values.

`tables` and `row_tables` hold a struct for each table of a tier and of `scenes.toml`; other rule files have a module
each. `files` finds, merges and reads them, `checking` reads a whole folder, `toml_text` writes them.
"""

from .aligning import AlignRules
from .checking import check_rules
from .columns import FREQUENCY, Columns, read_columns
from .conforming import ConformRules
from .files import (
    Rules,
    actuator_names,
    convert,
    load_actuator,
    load_conform,
    load_haptics,
    load_measuring,
    load_rules,
    rules_path,
    verifier_path,
)
from .haptics import HapticRules
from .measuring import FitRules, IdentifyRules, MeasuringRules, PerceptionCurve
from .perceptions import load_perception, perception_names
from .profiles import (
    DEFAULT_ACTUATOR,
    SLOWEST_RAD_S,
    ActuatorProfile,
    HighPass,
    LowPass,
    Response,
    check_name,
    check_stable,
)
from .row_tables import BeatRules, BurstRules, RowRules
from .tables import (
    LARGEST_LEVEL_DB,
    LONGEST_DECAY_MS,
    ChannelRules,
    OnsetRules,
    QualityRules,
    RenderRules,
    ScanRules,
    SceneRules,
    SegmentRules,
    VerifyRules,
    WindowRules,
)
from .toml_text import toml_lines

__all__ = [
    "DEFAULT_ACTUATOR",
    "FREQUENCY",
    "LARGEST_LEVEL_DB",
    "LONGEST_DECAY_MS",
    "SLOWEST_RAD_S",
    "ActuatorProfile",
    "AlignRules",
    "BeatRules",
    "BurstRules",
    "ChannelRules",
    "Columns",
    "ConformRules",
    "FitRules",
    "HapticRules",
    "HighPass",
    "IdentifyRules",
    "LowPass",
    "MeasuringRules",
    "OnsetRules",
    "PerceptionCurve",
    "QualityRules",
    "RenderRules",
    "Response",
    "RowRules",
    "Rules",
    "ScanRules",
    "SceneRules",
    "SegmentRules",
    "VerifyRules",
    "WindowRules",
    "actuator_names",
    "check_name",
    "check_rules",
    "check_stable",
    "convert",
    "load_actuator",
    "load_conform",
    "load_haptics",
    "load_measuring",
    "load_perception",
    "load_rules",
    "perception_names",
    "read_columns",
    "rules_path",
    "toml_lines",
    "verifier_path",
]
