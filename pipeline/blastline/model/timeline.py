"""What `timeline.json` holds, from the source to the whole; its JSON Schema is generated from these types."""

from inspect import cleandoc
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from .shot import Azimuth, Index, Ratio, Reflection
from .sound import SPAN_KEYS, HeardIn, MadeOf, Span

SCHEMA: Final = "blastline.timeline/1"

DriveModel = Literal["direct", "filter", "constrained"]
DriveChoice = Literal["auto", "direct", "filter", "constrained"]
Quality = Literal["draft", "standard", "reference"]
Phase = Literal["causal", "zero"]
Background = Literal["mute", "direct"]
Origin = Literal["found", "moved", "added"]
Question = Literal["verifier", "reflections", "window"]


class Source(msgspec.Struct, frozen=True):
    """The track that was read.

    `has_picture` tells a film from sound alone. `start_timecode` and `frame_rate` are None where the file has none.
    `stream` counts the sound streams from 0; several were joined, each as a channel.
    `start_offset_s` is how much later than the picture the first sample plays. `warnings` say what the reader had to
    mend (damage, NaN, a missing tail), and where fewer shots are found.
    """

    name: str
    sha256: str
    sample_rate_hz: Annotated[int, Meta(ge=1)]
    frames: Index
    channels: Annotated[int, Meta(ge=1)]
    start_timecode: str | None = None
    frame_rate: str | None = None
    start_offset_s: float = 0.0
    stream: Index | Annotated[tuple[Index, ...], Meta(min_length=2)] = 0
    mix: str = "mains"
    has_picture: bool = False
    warnings: tuple[str, ...] = ()


class Window(msgspec.Struct, frozen=True, order=True, rename=SPAN_KEYS):
    """The range in which the drive follows the film, with the lengths of its cross-fades inside it."""

    start: Index
    stop: Index
    fade_in_samples: Index
    fade_out_samples: Index

    @property
    def span(self) -> Span:
        """Return the range of samples, fades included."""
        return Span(self.start, self.stop)

    @property
    def fits_fades(self) -> bool:
        """Return whether there is room inside for both fades."""
        return self.fade_in_samples + self.fade_out_samples <= self.stop - self.start


class ActuatorRef(msgspec.Struct, frozen=True):
    """Which actuator profile the drive was made for."""

    name: str
    digest: str


class DriveInfo(msgspec.Struct, frozen=True):
    """How an event's drive was made and what it is predicted to do.

    `peak` is against the actuator's limit. `perceived_gain_db` is the level of the predicted perceived vibration
    against that of direct conversion. `fidelity` is the correlation of the predicted perceived vibration with
    the sound in the band of vibration. Of a constrained drive, `solver_steps` says what it took, and `explained` which
    share of the energy that was to be felt it makes felt; None for other models. `evidence` is what the choice of the
    model was made from. `made_of` is what became the drive. `raised_db` is how much louder than in the film its sound
    was taken: the gain of the event and the level of the timeline.
    """

    model: DriveModel
    reason: str
    peak: float
    perceived_gain_db: float
    fidelity: float
    solver_steps: Index | None = None
    explained: float | None = None
    evidence: dict[str, float] = {}
    made_of: MadeOf = "mains"
    raised_db: float = 0.0


class Decision(msgspec.Struct, frozen=True):
    """What was decided for an event by what it requires, why, and the measured evidence."""

    about: Question
    choice: str
    reason: str
    evidence: dict[str, float]


class Event(msgspec.Struct, frozen=True):
    """A gunshot in the timeline, with its window and its drive. `burst` is None for a single shot.

    `origin` says whether detection put its onset where it is or somebody who edited the timeline. `gain_db` is how much
    stronger than usual the drive was asked to be. `peak_dbfs` is of the waveform, between its samples too where the
    film's rate is not 48 kHz, less what was constant before it: that of a clipped one may be over 0. `heard_in` says
    whether it was found in the mains, or in what these hold beside their middle. `azimuth_deg` is where it comes from,
    0 in front, 90 on the right, 180 behind, None where nothing tells; `azimuth_focus` is 1 where one loudspeaker plays
    it, and less the wider it is spread. `decisions` say how closely it was looked at, and why.
    """

    id: str
    onset_sample: Index
    onset_s: float
    timecode: str
    confidence: Ratio
    burst: int | None
    shot_in_burst: int | None
    peak_dbfs: float
    snr_db: float
    blast: Span
    reflections: tuple[Reflection, ...]
    window: Window
    drive: DriveInfo | None = None
    origin: Origin = "found"
    gain_db: float = 0.0
    heard_in: HeardIn = "mains"
    azimuth_deg: Azimuth | None = None
    azimuth_focus: Ratio | None = None
    decisions: tuple[Decision, ...] = ()

    @property
    def made_of(self) -> MadeOf:
        """Return what became its drive; the mains where nothing is known of its making."""
        return "mains" if self.drive is None else self.drive.made_of


class Rejection(msgspec.Struct, frozen=True):
    """A candidate that was not taken for a shot, with the evidence, so that a missed shot can be explained."""

    at_sample: Index
    reason: str
    evidence: dict[str, float]


class Check(msgspec.Struct, frozen=True):
    """One alignment check: of one event, or of the film where `event` is None.

    `limit` is what `measured` had to stay within; None where the check is exact or not applicable.
    """

    name: str
    event: str | None
    passed: bool
    measured: float | None
    limit: float | None
    unit: str


class Edits(msgspec.Struct, frozen=True):
    """What somebody changed by hand: the file that says so, how many events it changed in which way, and remarks.

    `changed` ones kept their onset, but not their window, gain or confidence. `as_given` ones nobody can tell: without
    the original they may be what they were, or moved.
    """

    file: str
    kept: Index
    moved: Index
    changed: Index
    added: Index
    deleted: Index
    notes: tuple[str, ...] = ()
    as_given: Index = 0


class Budget(msgspec.Struct, frozen=True):
    """How the quality was chosen to keep to a budget of CPU time.

    `asked` is the budget in the user's words and `allowed_cpu_s` what it comes to for this film; `predicted_cpu_s` is
    what the qualities that were weighed would take, the choosing included; `note` tells it in one line.
    """

    asked: str
    allowed_cpu_s: float
    predicted_cpu_s: dict[Quality, float]
    note: str


class Timeline(msgspec.Struct, frozen=True):
    """The whole result: source, actuator, events in order, rejections and checks.

    `phase`, `background` and `level_db`, by which the sound was raised before it became a target, say how the drive was
    made, so that its file can be checked again later.
    """

    schema: Literal["blastline.timeline/1"]
    version: str
    quality: Quality
    rules_digest: str
    source: Source
    actuator: ActuatorRef | None
    events: tuple[Event, ...]
    rejections: tuple[Rejection, ...]
    checks: tuple[Check, ...]
    phase: Phase = "causal"
    background: Background = "mute"
    level_db: float = 0.0
    edits: Edits | None = None
    budget: Budget | None = None


def schema() -> dict[str, Any]:
    """Return the JSON Schema of `timeline.json`, generated from the types above."""
    made = {"$schema": "https://json-schema.org/draft/2020-12/schema", **msgspec.json.schema(Timeline)}
    for part in made["$defs"].values():  # Python 3.13 and later take the indentation off by themselves
        part["description"] = cleandoc(part["description"])
    return made


def encode(timeline: Timeline) -> bytes:
    """Return the timeline as indented JSON, ending in a newline, as it is when it has been read and is written again.

    Raises msgspec.ValidationError for a timeline that could not be read back, such as one that holds a NaN.
    """
    read = msgspec.json.decode(msgspec.json.encode(timeline), type=Timeline)  # a count where a number belongs: 0 is 0.0
    return msgspec.json.format(msgspec.json.encode(read), indent=1) + b"\n"
