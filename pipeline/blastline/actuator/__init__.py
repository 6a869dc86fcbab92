"""The actuator and the skin as measured things.

excitation, response ─► identify ─► measured response ─┐
CSV ─────────────────────────────────► read_measured ──┴─► fit_target ─► fit ─► profile
thresholds ─► H_m = (1/T)^2 ───────────────────────────────────┘
"""

from .clipping import require_unclipped_excitation
from .fit import BandError, Fit, FittedResponse, fit, octave_errors
from .identify import Identified, identify
from .inverse import inversion_db, peak
from .measured import MeasuredResponse, doubts, doubts_of_order, measured_csv, read_measured, require_coherent
from .phase import ExcessPhase, excess_phase, minimum_phase
from .profile import fitted_profile, profile_text
from .rational import Model, analogue, level_db
from .recording import Recording, record
from .slip import require_running_along
from .target import FitTarget, fit_target
from .thresholds import sensitivity_db

__all__ = [
    "BandError",
    "ExcessPhase",
    "Fit",
    "FitTarget",
    "FittedResponse",
    "Identified",
    "MeasuredResponse",
    "Model",
    "Recording",
    "analogue",
    "doubts",
    "doubts_of_order",
    "excess_phase",
    "fit",
    "fit_target",
    "fitted_profile",
    "identify",
    "inversion_db",
    "level_db",
    "measured_csv",
    "minimum_phase",
    "octave_errors",
    "peak",
    "profile_text",
    "read_measured",
    "record",
    "require_coherent",
    "require_running_along",
    "require_unclipped_excitation",
    "sensitivity_db",
]
