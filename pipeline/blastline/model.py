"""The nouns: time spans, pieces of sound, shots, windows, events, checks and the timeline that holds them.

Conventions
    Time is an integer count of frames of the decoded track from its first frame; ranges are half-open.
    Every value is frozen. What becomes part of `timeline.json` is a msgspec struct, and the JSON Schema that
    the package ships is generated from these types (`schema`).
"""

from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta
from numpy.typing import NDArray

SCHEMA: Final = "blastline.timeline/1"

DriveModel = Literal["direct", "filter", "constrained"]
DriveChoice = Literal["auto", "direct", "filter", "constrained"]
Quality = Literal["draft", "standard", "reference"]
Phase = Literal["causal", "zero"]
Background = Literal["mute", "direct"]
Origin = Literal["found", "moved", "added"]

Index = Annotated[int, Meta(ge=0)]
Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]

_SPAN_KEYS = {"start": "start_sample", "stop": "stop_sample"}


class Span(msgspec.Struct, frozen=True, order=True, rename=_SPAN_KEYS):
    """A half-open range of samples, ordered by its start.

    >>> Span(0, 10) & Span(4, 20)
    Span(start=4, stop=10)
    >>> Span(0, 10) | Span(14, 20)
    Span(start=0, stop=20)
    """

    start: int
    stop: int

    def __post_init__(self) -> None:
        """Refuse a range that runs backwards."""
        if self.stop < self.start:
            raise ValueError(f"a span must not run backwards: {self.start} to {self.stop}")

    def __len__(self) -> int:
        """Return the number of samples inside."""
        return self.stop - self.start

    def __bool__(self) -> bool:
        """Return whether any sample lies inside."""
        return self.stop > self.start

    def __contains__(self, sample: int) -> bool:
        """Return whether a sample lies inside."""
        return self.start <= sample < self.stop

    def __and__(self, other: "Span") -> "Span":
        """Return what both cover; an empty span at the later start where they do not meet."""
        start = max(self.start, other.start)
        return Span(start, max(start, min(self.stop, other.stop)))

    def __or__(self, other: "Span") -> "Span":
        """Return the smallest span that covers both, with any gap between them."""
        return Span(min(self.start, other.start), max(self.stop, other.stop))


@dataclass(frozen=True, eq=False)
class Clip:
    """A piece of sound that knows its place in the film.

    `samples` is (frames, columns), floating point; `start` is the film's sample index of its first frame. A mixed
    soundtrack has one column, or two where the drive is made from other channels than detection listens to.
    """

    samples: NDArray[Any]
    rate_hz: int
    start: int = 0

    @property
    def span(self) -> Span:
        """Return the range of the film that the clip covers."""
        return Span(self.start, self.start + self.samples.shape[0])

    @property
    def heard(self) -> NDArray[Any]:
        """Return the column in which detection listens, shape (frames,)."""
        return self.samples[:, 0]

    @property
    def driving(self) -> NDArray[Any]:
        """Return the column that becomes the drive, shape (frames,); the heard one where there is only one."""
        return self.samples[:, -1]

    def cut(self, span: Span) -> "Clip":
        """Return the part inside `span`, which must lie within the clip."""
        if span.start < self.start or span.stop > self.span.stop:
            raise ValueError(f"{span} does not lie within {self.span}")
        return Clip(self.samples[span.start - self.start : span.stop - self.start], self.rate_hz, span.start)


class Source(msgspec.Struct, frozen=True):
    """The track that was read.

    `start_timecode` and `frame_rate` are None where the file has none. `start_offset_s` is how much later than the
    picture the first sample plays. `warnings` say what the reader had to mend (damage, NaN, a missing tail).
    """

    name: str
    sha256: str
    sample_rate_hz: Annotated[int, Meta(ge=1)]
    frames: Index
    channels: Annotated[int, Meta(ge=1)]
    start_timecode: str | None = None
    frame_rate: str | None = None
    start_offset_s: float = 0.0
    stream: Index = 0
    mix: str = "mains"
    warnings: tuple[str, ...] = ()


class Reflection(msgspec.Struct, frozen=True, rename=_SPAN_KEYS):
    """A discrete echo of a blast: its span, how much later it starts and how strong it is against the blast."""

    start: Index
    stop: Index
    delay_ms: float
    level_db: float

    @property
    def span(self) -> Span:
        """Return the range of samples."""
        return Span(self.start, self.stop)


class Window(msgspec.Struct, frozen=True, order=True, rename=_SPAN_KEYS):
    """The range in which the drive follows the film, with the lengths of its cross-fades inside it."""

    start: Index
    stop: Index
    fade_in_samples: Index
    fade_out_samples: Index

    @property
    def span(self) -> Span:
        """Return the range of samples, fades included."""
        return Span(self.start, self.stop)


class ActuatorRef(msgspec.Struct, frozen=True):
    """Which actuator profile the drive was made for."""

    name: str
    digest: str


class DriveInfo(msgspec.Struct, frozen=True):
    """How an event's drive was made and what it is predicted to do.

    `peak` is against the actuator's limit. `perceived_gain_db` is the level of the predicted perceived vibration
    against that of direct conversion. `fidelity` is the correlation of the predicted perceived vibration with
    the sound in the band of vibration. Of a constrained drive, `solver_steps` says what it took, and `explained` which
    share of the energy that was to be felt it makes felt; None for other models.
    """

    model: DriveModel
    reason: str
    peak: float
    perceived_gain_db: float
    fidelity: float
    solver_steps: Index | None = None
    explained: float | None = None


class Shot(msgspec.Struct, frozen=True):
    """A gunshot as detection found it; `span` runs from the onset to where its decay has ended."""

    onset: Index
    confidence: Ratio
    peak_dbfs: float
    snr_db: float
    blast: Span
    reflections: tuple[Reflection, ...]
    span: Span
    burst: int | None = None
    shot_in_burst: int | None = None


class Event(msgspec.Struct, frozen=True):
    """A gunshot in the timeline, with its window and its drive. `burst` is None for a single shot.

    `origin` says whether detection put its onset where it is or somebody who edited the timeline. `gain_db` is how much
    stronger than usual the drive was asked to be.
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


@dataclass(frozen=True)
class SceneEvidence:
    """What the cheap drive models would do in a window, measured before one is chosen.

    `direct_level_db` is the level of the perceived vibration under direct conversion against the target, the sound in
    the band; `direct_fidelity` their correlation; `filter_peak` the compensator's peak against the actuator's limit.
    """

    direct_level_db: float
    direct_fidelity: float
    filter_peak: float


class Edits(msgspec.Struct, frozen=True):
    """What somebody changed by hand: the file that says so, how many events it changed in which way, and remarks.

    `changed` ones kept their onset, but not their window, gain or confidence.
    """

    file: str
    kept: Index
    moved: Index
    changed: Index
    added: Index
    deleted: Index
    notes: tuple[str, ...] = ()


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


def schema() -> dict[str, Any]:
    """Return the JSON Schema of `timeline.json`, generated from the types above."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **msgspec.json.schema(Timeline)}


def encode(timeline: Timeline) -> bytes:
    """Return the timeline as indented JSON, ending in a newline.

    Raises msgspec.ValidationError for a timeline that could not be read back, such as one that holds a NaN.
    """
    compact = msgspec.json.encode(timeline)
    msgspec.json.decode(compact, type=Timeline)
    return msgspec.json.format(compact, indent=1) + b"\n"
