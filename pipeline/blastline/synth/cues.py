"""What a scene's items become: one cue for each sound, named after what it is and when."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..units import samples_from_s
from .apart import MARGIN_DB, told_apart
from .chance import between, generator
from .scene import NegativeItem, Scene, ShotItem
from .voices import Voice, draw_voice


@dataclass(frozen=True)
class Cue:
    """A sound of the scene: the item it belongs to, where its onset lies, and its place in a burst.

    `family` is what the shots of a burst draw together under (weapon, place, polarity); `name` is the shot's own.
    `first` is the onset of the burst's first shot: the weapon is as loud throughout.
    """

    item: ShotItem | NegativeItem
    onset: int
    family: str
    name: str
    first: int
    burst: int | None = None
    shot_in_burst: int | None = None


def cues(scene: Scene) -> Iterator[Cue]:
    """Yield every sound of the scene, each shot of a burst on its own; what would start after the end is left out."""
    for burst, item in enumerate(scene.shots):
        yield from (cue for cue in _shots(scene, item, burst) if cue.onset < scene.frames)
    for negative in scene.negatives:
        family = f"negative/{negative.kind}/{negative.at_s:.6f}"
        onset = samples_from_s(negative.at_s, scene.rate_hz)
        yield Cue(negative, onset, family, family, first=onset)


def voice_of(scene: Scene, item: ShotItem, family: str) -> Voice:
    """Return the weapon that a shot's item describes; what it leaves out is drawn, and a burst's shots stay apart."""
    voice = draw_voice(
        generator(scene.seed, family),
        item.weapon,
        environment=item.environment,
        distance_m=item.distance_m,
        clean=item.recording == "clean",
    )
    voice = replace(
        voice,
        rise_ms=voice.rise_ms if item.rise_ms is None else item.rise_ms,
        positive_ms=voice.positive_ms if item.positive_ms is None else item.positive_ms,
    )
    if item.burst is None:
        return voice
    rng = generator(scene.seed, "apart", family)
    return told_apart(rng, voice, spacing_s=60.0 / item.burst.rpm, margin_db=between(rng, MARGIN_DB))


def _shots(scene: Scene, item: ShotItem, burst: int) -> Iterator[Cue]:
    family = f"shot/{item.weapon}/{item.environment}/{item.at_s:.6f}"
    first = samples_from_s(item.at_s, scene.rate_hz)
    if item.burst is None:
        yield Cue(item, first, family, f"{family}/0", first=first)
        return
    rng = generator(scene.seed, "rhythm", family)
    spacing_s = 60.0 / item.burst.rpm
    for number in range(item.burst.shots):
        late = item.burst.jitter * float(rng.uniform(-1.0, 1.0)) if number else 0.0
        onset = first + samples_from_s((number + late) * spacing_s, scene.rate_hz)
        yield Cue(item, onset, family, f"{family}/{number}", first, burst, number)
