"""A scene description: what happens when, in a TOML file, as frozen and range-checked values.

    schema = 1
    rate_hz = 48000
    duration_s = 60.0
    seed = 7

    [[beds]]                        [[shots]]                         [[negatives]]
    kind = "dialogue"               at_s = 12.5                       at_s = 20.0
    level_dbfs = -27.0              weapon = "pistol"                 kind = "door"
                                    environment = "indoors"           peak_dbfs = -12.0
                                    snr_db = 30.0

A shot or a negative has either `peak_dbfs`, or `snr_db`: its peak over the rms, in the 200 ms before it, of the beds
and, for a shot, the negatives; other shots do not count.
`[random]` adds as many more as it says, spread over the scene.
"""

from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ..errors import RuleError
from ..misfits import misfit
from ..ruleset.files import read_toml
from ..units import samples_from_s
from .beds import BedKind
from .negatives import NegativeKind
from .rooms import Environment
from .weapons import WeaponName

Layout = Literal["mono", "stereo", "5.1", "7.1"]
Seconds = Annotated[float, Meta(ge=0.0, le=86_400.0)]
LevelDb = Annotated[float, Meta(ge=-120.0, le=40.0)]
Peak = Annotated[float, Meta(ge=-100.0, le=0.0)]


class Item(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of a scene file: unknown and missing keys are errors."""


class BedItem(Item, frozen=True, kw_only=True):
    """A bed from `start_s` to `stop_s` (the end where None); its level is the rms of a channel that carries it.

    In surround sound that is one of the mains: ambience is 3 dB softer behind, music 9.
    """

    kind: BedKind
    level_dbfs: Annotated[float, Meta(ge=-120.0, le=-3.0)]
    start_s: Seconds = 0.0
    stop_s: Seconds | None = None
    fade_s: Seconds = 0.5


class BurstItem(Item, frozen=True, kw_only=True):
    """Automatic fire; each shot comes up to `jitter` of the spacing early or late."""

    shots: Annotated[int, Meta(ge=2, le=200)]
    rpm: Annotated[float, Meta(ge=20.0, le=1_500.0)]
    jitter: Annotated[float, Meta(ge=0.0, le=0.2)] = 0.04


class SoundItem(Item, frozen=True, kw_only=True):
    """Something that starts at `at_s`, with one of the two ways to say how loud.

    `azimuth_deg` is where it comes from, 0 in front and positive to the right; drawn where it is left out.
    """

    at_s: Seconds
    snr_db: LevelDb | None = None
    peak_dbfs: Peak | None = None
    azimuth_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] | None = None


class ShotItem(SoundItem, frozen=True, kw_only=True):
    """A shot, or with `burst` several; what is left out is drawn at random."""

    weapon: WeaponName
    environment: Environment
    distance_m: Annotated[float, Meta(ge=0.3, le=3_000.0)] | None = None
    rise_ms: Annotated[float, Meta(ge=0.0, le=5.0)] | None = None
    positive_ms: Annotated[float, Meta(ge=0.1, le=10.0)] | None = None
    recording: Literal["film", "clean"] = "film"
    burst: BurstItem | None = None


class NegativeItem(SoundItem, frozen=True, kw_only=True):
    """A sound that is no shot."""

    kind: NegativeKind


class RandomItems(Item, frozen=True, kw_only=True):
    """How many shots (a third of them in bursts) and negatives to spread over the scene, within which levels."""

    shots: Annotated[int, Meta(ge=0, le=5_000)] = 0
    negatives: Annotated[int, Meta(ge=0, le=20_000)] = 0
    shot_snr_db: tuple[LevelDb, LevelDb] = (8.0, 40.0)
    negative_snr_db: tuple[LevelDb, LevelDb] = (3.0, 38.0)
    spacing_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 0.3
    kinds: tuple[NegativeKind, ...] = ()


class Master(Item, frozen=True, kw_only=True):
    """The last link: a limiter without memory that bends above `knee_db` under its ceiling, and the file's bits.

    A sound whose `snr_db` asks for a peak more than `drive_db` over the ceiling is turned down to that, as a mixer
    would: what goes further only distorts.
    """

    ceiling_dbfs: Annotated[float, Meta(ge=-40.0, le=0.0)] = -1.0
    knee_db: Annotated[float, Meta(gt=0.0, le=40.0)] = 4.0
    drive_db: Annotated[float, Meta(ge=0.0, le=80.0)] = 3.0
    bits: Literal[16, 24] = 16
    dither: bool = True


class Scene(Item, frozen=True, kw_only=True):
    """The whole description."""

    schema: Literal[1]
    rate_hz: Annotated[int, Meta(ge=8_000, le=384_000)]
    duration_s: Annotated[float, Meta(gt=0.0, le=86_400.0)]
    seed: Annotated[int, Meta(ge=0)]
    name: str = "scene"
    layout: Layout = "mono"
    beds: tuple[BedItem, ...] = ()
    shots: tuple[ShotItem, ...] = ()
    negatives: tuple[NegativeItem, ...] = ()
    random: RandomItems | None = None
    master: Master = Master()

    @property
    def frames(self) -> int:
        """Return the length of the scene in frames."""
        return samples_from_s(self.duration_s, self.rate_hz)


def load_scene(path: Path) -> Scene:
    """Return the scene that a TOML file describes, named after the file.

    Raises RuleError naming the file, the key, its value and what was expected.
    """
    plain = read_toml(path)
    if "name" in plain:
        raise RuleError(f"{path}: name: no such key; a scene is named after its file")
    try:
        scene = msgspec.convert(plain, Scene)
    except msgspec.ValidationError as error:
        raise RuleError(f"{path}: {misfit(plain, error, Scene, null='')}") from error
    _check_times(scene, path)
    return msgspec.structs.replace(scene, name=path.stem)


def _check_times(scene: Scene, path: Path) -> None:
    for name, items in (("shots", scene.shots), ("negatives", scene.negatives)):
        for index, item in enumerate(items):
            where = f"{path}: {name}[{index}]"
            if (item.snr_db is None) == (item.peak_dbfs is None):
                raise RuleError(f"{where}: expected one of snr_db and peak_dbfs, not both and not neither")
            if samples_from_s(item.at_s, scene.rate_hz) >= scene.frames:
                wanted = f"less than duration_s = {scene.duration_s} by a sample or more"
                raise RuleError(f"{where}.at_s = {item.at_s}: expected {wanted}")
    if scene.frames < 1:
        raise RuleError(f"{path}: duration_s = {scene.duration_s}: expected at least a sample of {scene.rate_hz} Hz")
    for index, bed in enumerate(scene.beds):
        if bed.start_s >= scene.duration_s:
            where = f"{path}: beds[{index}].start_s = {bed.start_s}"
            raise RuleError(f"{where}: expected less than duration_s = {scene.duration_s}")
        if bed.stop_s is not None and bed.stop_s <= bed.start_s:
            raise RuleError(f"{path}: beds[{index}].stop_s = {bed.stop_s}: expected more than start_s = {bed.start_s}")
    if scene.random is not None:
        for key in ("shot_snr_db", "negative_snr_db"):
            low, high = getattr(scene.random, key)
            if low > high:
                raise RuleError(f"{path}: random.{key} = [{low}, {high}]: expected the lower level first")
