"""What a synthetic sound is known to contain, to the sample."""

from typing import Literal

import msgspec

from ..model import Reflection, Span


class TrueReflection(Reflection, frozen=True):
    """A reflection that is there, and whether it is heard: `margin_db` is how far it stands out (see `audible`)."""

    audible: bool = False
    margin_db: float | None = None


class ShotTruth(msgspec.Struct, frozen=True):
    """A shot of the scene.

    `onset_sample` is the first sample of the blast's rise. `start_sample` is the first sample of anything the shot
    makes: earlier only where a bullet's shock or the weapon's mechanics are heard first. `accept_samples` are other
    places that may be called the onset (the shock of the bullet). `blast` ends where blast wave, gas jet and second
    pulse have fallen to -20 dB of their peak for good. `peak_dbfs` is the shot's own peak within 50 ms of the onset,
    `snr_db` that peak over the rms of everything but the shots of its own burst in the 200 ms before the onset.
    `azimuth_deg` is where it comes from, where the scene says.
    A second pulse that comes when the first has died is listed with the reflections: it sounds like one. In a scene,
    each reflection tells whether it is heard, and `heard_blast` how long the blast is.
    """

    onset_sample: int
    onset_s: float
    start_sample: int
    weapon: str
    environment: str
    distance_m: float
    rise_ms: float
    snr_db: float
    peak_dbfs: float
    blast: Span
    reflections: tuple[TrueReflection, ...]
    accept_samples: tuple[int, ...] = ()
    burst: int | None = None
    shot_in_burst: int | None = None
    azimuth_deg: float | None = None
    heard_blast: Span | None = None


class NegativeTruth(msgspec.Struct, frozen=True):
    """A sound that is no shot, and where it starts; `explosion` is a shot to some, so it is scored neither way."""

    at_sample: int
    at_s: float
    kind: str
    peak_dbfs: float


class Truth(msgspec.Struct, frozen=True):
    """Everything that a scene contains: shots and hard negatives in order of time."""

    schema: Literal["blastline.truth/1"]
    scene: str
    rate_hz: int
    frames: int
    channels: int
    shots: tuple[ShotTruth, ...]
    negatives: tuple[NegativeTruth, ...]


def moved(shot: ShotTruth, by_samples: int, *, rate_hz: int) -> ShotTruth:
    """Return the shot, later by a number of samples."""
    echoes = tuple(
        msgspec.structs.replace(echo, start=max(0, echo.start + by_samples), stop=max(0, echo.stop + by_samples))
        for echo in shot.reflections
    )
    onset = shot.onset_sample + by_samples
    return msgspec.structs.replace(
        shot,
        onset_sample=onset,
        onset_s=onset / rate_hz,
        start_sample=max(0, shot.start_sample + by_samples),
        blast=Span(shot.blast.start + by_samples, shot.blast.stop + by_samples),
        reflections=echoes,
        accept_samples=tuple(at + by_samples for at in shot.accept_samples if at + by_samples >= 0),
    )


def encode_truth(truth: Truth) -> bytes:
    """Return the truth as indented JSON, ending in a newline."""
    return msgspec.json.format(msgspec.json.encode(truth), indent=1) + b"\n"


def decode_truth(data: bytes) -> Truth:
    """Return the truth that JSON holds."""
    return msgspec.json.decode(data, type=Truth)
