"""The nouns: time spans, pieces of sound, shots, windows, events, checks and the timeline that holds them.

Conventions
    Time is an integer count of frames of the decoded track from its first frame; ranges are half-open.
    Every value is frozen. What becomes part of `timeline.json` is a msgspec struct, and the JSON Schema that
    the package ships is generated from these types (`schema`).
"""

from .scene import SceneEvidence
from .shot import FIRE, DecayEnd, EvenRow, Index, Ratio, Reflection, Shot, ShotEvidence
from .sound import Channels, Clip, HeardIn, MadeOf, RandomAccessSound, SoundFile, Span
from .timeline import (
    SCHEMA,
    ActuatorRef,
    Background,
    Budget,
    Check,
    Decision,
    DriveChoice,
    DriveInfo,
    DriveModel,
    Edits,
    Event,
    Origin,
    Phase,
    Quality,
    Rejection,
    Source,
    Timeline,
    Window,
    encode,
    schema,
)

__all__ = [
    "FIRE",
    "SCHEMA",
    "ActuatorRef",
    "Background",
    "Budget",
    "Channels",
    "Check",
    "Clip",
    "DecayEnd",
    "Decision",
    "DriveChoice",
    "DriveInfo",
    "DriveModel",
    "Edits",
    "EvenRow",
    "Event",
    "HeardIn",
    "Index",
    "MadeOf",
    "Origin",
    "Phase",
    "Quality",
    "RandomAccessSound",
    "Ratio",
    "Reflection",
    "Rejection",
    "SceneEvidence",
    "Shot",
    "ShotEvidence",
    "SoundFile",
    "Source",
    "Span",
    "Timeline",
    "Window",
    "encode",
    "schema",
]
