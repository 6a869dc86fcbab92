"""A shot as detection finds it, and what that measured."""

import math
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from .sound import SPAN_KEYS, HeardIn, Span

DecayEnd = Literal["fallen", "background", "next sound", "longest", "last reflection"]
EvenRow = Literal["fire", "sustained fire", "no fire"]
FIRE: tuple[EvenRow, ...] = ("fire", "sustained fire")

Index = Annotated[int, Meta(ge=0)]
Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]
Azimuth = Annotated[float, Meta(ge=-180.0, le=180.0)]


class Reflection(msgspec.Struct, frozen=True, rename=SPAN_KEYS):
    """A discrete echo of a blast: its span, how much later it starts and how strong it is against the blast."""

    start: Index
    stop: Index
    delay_ms: float
    level_db: float

    @property
    def span(self) -> Span:
        """Return the range of samples."""
        return Span(self.start, self.stop)


class ShotEvidence(msgspec.Struct, frozen=True):
    """What detection measured of a shot before it decided how closely to look.

    `screen` is the probability by the screen alone and `networks` how many judged beside it; None and 0 where somebody
    else found the shot. No later stretch as long as the blast is louder than `echo_room_db` against it, in the
    sound's difference over a sample or a sixth of a millisecond; None where no reflections are looked for. `copies`
    counts what copies the blast, before later shots and their echoes were told from its reflections. A reflection
    softer than `drowned_db` is softer than what was usual before the shot.
    `decay_end` says what ended the decay. `backdrop` is what is heard just before (`detect.backdrop`); None where that
    is silence, or somebody else found the shot. `sound` are levels of the shot itself (`detect.backdrop`), `attack` is
    its beginning (`detect.copies`). `even_row` says of one of a row, as even as fire, that the row as a whole sounds
    like that, perhaps for longer than a burst, or, of a long one as fast as automatic fire, that it does not. `on_beat`
    says of what keeps the beat of music around it, `goes_on` of what goes on as loud as it begins, as after a cut to
    another scene.
    """

    screen: Ratio | None
    networks: Index
    echo_room_db: float | None
    decay_end: DecayEnd
    backdrop: int | None = None
    sound: tuple[int, ...] = ()
    attack: bytes = b""
    even_row: EvenRow | None = None
    on_beat: bool = False
    goes_on: bool = False
    copies: Index = 0
    drowned_db: float = -math.inf


class Shot(msgspec.Struct, frozen=True):
    """A gunshot as detection found it; `span` runs from the onset to where its decay and its reflections are over.

    Where it was heard and its azimuth are as in `Event`.
    """

    onset: Index
    confidence: Ratio
    peak_dbfs: float
    snr_db: float
    blast: Span
    reflections: tuple[Reflection, ...]
    span: Span
    burst: int | None = None
    shot_in_burst: int | None = None
    heard_in: HeardIn = "mains"
    azimuth_deg: Azimuth | None = None
    azimuth_focus: Ratio | None = None
    evidence: ShotEvidence | None = None
