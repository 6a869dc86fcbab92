"""What a film will cost on this machine: a sample of it goes through the real stages, timed by the CPU.

    film ──► stretches here and there ──► one short file ──► listen ──► render ──► check ──► report

What a tier takes is then a fixed amount, so much for each second of film, so much for each shot, and for each picture.
"""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time

import msgspec

from ..detect import Detection, audio_around, find_shots, load_verifier, shot_at
from ..model import Clip, Quality, Shot
from ..render import plan_windows
from ..report import MOST_PICTURES, OverviewMeter
from ..ruleset import Rules, rules_path
from ..soundtrack import Soundtrack, open_soundtrack
from . import names
from .checking import checked
from .driving import write_drive_of
from .listening import BLOCK, Listened, Mark, assemble, event_id, listen
from .options import RenderOptions, Setup, set_up
from .progress import Progress, no_note, no_progress
from .rendering import write_formats, write_report_of
from .sampling import TIMED_FRAMES, Sampled, sampled

FEW_WINDOWS, FEW_PICTURES = 4, 2
"""So many windows of the sample are rendered, from all over it, and so many pictures drawn."""


@dataclass(frozen=True)
class FilmCost:
    """The CPU seconds of a tier: fixed, per second of film, per shot, per picture of the report; and how many shots."""

    fixed_s: float
    per_second: float
    per_shot: float = 0.0
    per_picture: float = 0.0
    shots_per_s: float = 0.0

    def of(self, film_s: float) -> float:
        """Return the CPU seconds for a film of so many seconds."""
        shots = self.shots_per_s * film_s
        pictures = min(shots, MOST_PICTURES)
        return self.fixed_s + self.per_second * film_s + self.per_shot * shots + self.per_picture * pictures


@dataclass(frozen=True)
class _After:
    """The CPU seconds of what follows detection: the drive and its checks, and the report."""

    made_s: float
    report_s: float


@dataclass(frozen=True, eq=False)
class _Known:
    """What is the same for all tiers: what is heard, and the CPU seconds of a film without shots and of a picture."""

    heard: Listened
    empty: _After
    picture_s: float


class Gauge:
    """Predicts what each tier takes for one film."""

    def __init__(self, sample: Sampled, options: RenderOptions, *, drives: bool) -> None:
        """Take over the sample; `drives` says whether there will be a drive."""
        self._sample, self._options, self._drives = sample, options, drives
        self._report = drives and options.report
        self._known: _Known | None = None

    @property
    def film_s(self) -> float:
        """Return how long the film is, in seconds."""
        return self._sample.film_s

    def cost(self, quality: Quality) -> FilmCost:
        """Return what a tier takes; the first call also measures what is the same for all of them."""
        sample, setup = self._sample, set_up(replace(self._options, quality=quality), no_progress)
        if self._known is None:
            self._known = self._same_for_all(setup)
        known, (verifier_s, scan_per_s) = self._known, self._detecting(setup.rules)
        cost = FilmCost(verifier_s + sample.hash_s, scan_per_s + sample.decode_per_s)
        if not self._drives:
            return cost
        few = _with_shots(known.heard, self._some_shots(known.heard, setup.rules, FEW_WINDOWS), setup.rules)
        made_s = self._after(few, setup, report=False).made_s
        return replace(
            cost,
            fixed_s=cost.fixed_s + known.empty.report_s,
            per_second=cost.per_second + known.empty.made_s / sample.seconds,
            per_shot=max(0.0, made_s - known.empty.made_s) / len(few.found.shots),
            per_picture=known.picture_s,
            shots_per_s=max(len(known.heard.found.shots), 0.5) / sample.seconds,
        )

    def _same_for_all(self, setup: Setup) -> _Known:
        """Return what is heard in the whole sample, and what a film without shots and a picture take.

        Whatever has to be imported is imported by then.
        """
        with open_soundtrack(self._sample.path) as track:
            heard = listen(track, setup.rules, no_progress)
        if not self._drives:
            return _Known(heard, _After(0.0, 0.0), 0.0)
        none = _with_shots(heard, (), setup.rules)
        one = _with_shots(heard, self._some_shots(heard, setup.rules, 1)[:1], setup.rules)
        self._after(one, setup, report=False)
        empty = self._after(none, setup, report=self._report)
        if not self._report:
            return _Known(heard, empty, 0.0)
        self._after(one, setup, report=True)
        some = _with_shots(heard, self._some_shots(heard, setup.rules, FEW_PICTURES)[:FEW_PICTURES], setup.rules)
        pictures_s = max(0.0, self._after(some, setup, report=True).report_s - empty.report_s)
        return _Known(heard, empty, pictures_s / len(some.found.shots))

    def _detecting(self, rules: Rules) -> tuple[float, float]:
        """Return the CPU seconds of reading the verifier, and of finding the shots in a second of film."""
        path, networks = rules_path(f"verifier/{rules.tier.verify.model}", rules.overlay), rules.tier.verify.networks
        began = process_time()
        verifier = load_verifier(path, networks=networks)
        verifier_s = process_time() - began
        with open_soundtrack(self._sample.path) as track:
            timed = _every(self._sample.stride, track)
            meter = OverviewMeter(track.rate_hz)
            began = process_time()
            blocks = meter.watch(timed) if self._report else timed
            find_shots(blocks, rate_hz=track.rate_hz, tier=rules.tier, verifier=verifier)
            return verifier_s, (process_time() - began) / (timed[-1].span.stop / track.rate_hz)

    def _some_shots(self, heard: Listened, rules: Rules, most: int) -> Sequence[Shot]:
        """Return the shots of windows from all over the sample; its loudest moment where there is none."""
        if heard.windows:
            chosen = heard.windows[:: -(-len(heard.windows) // most)]
            return [heard.found.shots[index] for planned in chosen for index in planned.shots]
        at, rate_hz = self._sample.loudest, heard.source.sample_rate_hz
        with open_soundtrack(self._sample.path) as track:
            for _ in track.blocks(BLOCK):
                pass
            sound = track.cut(audio_around(at, frames=heard.source.frames, rate_hz=rate_hz, tier=rules.tier))
        return [shot_at(at, sound, confidence=1.0, tier=rules.tier)]

    def _after(self, heard: Listened, setup: Setup, *, report: bool) -> _After:
        """Do all that follows detection and return what it took."""
        sample = self._sample
        with (
            tempfile.TemporaryDirectory(prefix="blastline-") as made,
            open_soundtrack(sample.path) as track,
        ):
            meter = OverviewMeter(track.rate_hz)
            for _ in meter.watch(track.blocks(BLOCK)):
                pass
            folder, began = Path(made), process_time()
            heard = replace(heard, track=track)
            drives = write_drive_of(heard, folder / names.DRIVE, setup)
            source = msgspec.structs.replace(sample.source, frames=heard.source.frames)
            timeline = assemble(replace(heard, source=source), setup.rules, drives, setup.actuator)
            with open_soundtrack(folder / names.DRIVE) as drive:
                profile, align = setup.profile, setup.rules.align
                timeline = checked(timeline, track, drive, profile=profile, rules=align, progress=no_progress)
                written = write_formats(timeline, folder, drive, setup, no_note)
                made_s = process_time() - began
                if report:
                    write_report_of(timeline, folder, written, track=track, drive=drive, meter=meter, setup=setup)
                return _After(made_s, process_time() - began - made_s)


@contextmanager
def open_gauge(
    film: Path, options: RenderOptions, *, drives: bool, progress: Progress = no_progress
) -> Iterator[Gauge]:
    """Sample a film and yield what predicts its cost.

    Raises SoundtrackError for a film that cannot be read, or whose length nothing tells.
    """
    progress("measuring", 0, None)
    with tempfile.TemporaryDirectory(prefix="blastline-") as folder:
        with open_soundtrack(film, stream=options.stream, mix=options.mix, timebase=options.timebase) as track:
            sample = sampled(film, track, Path(folder) / "sample.wav", counted=drives)
        yield Gauge(sample, options, drives=drives)


def _every(stride: int, track: Soundtrack) -> list[Clip]:
    """Return every so manyth few seconds of a sample, as blocks that follow one another."""
    blocks: list[Clip] = []
    for block in track.blocks(BLOCK):
        if block.start // TIMED_FRAMES % stride == stride // 2:
            blocks.append(Clip(block.samples, block.rate_hz, blocks[-1].span.stop if blocks else 0))
    return blocks


def _with_shots(heard: Listened, shots: Sequence[Shot], rules: Rules) -> Listened:
    """Return what was heard as if these shots had been found in it."""
    source = heard.source
    windows = plan_windows(shots, frames=source.frames, rate_hz=source.sample_rate_hz, rules=rules.tier.windows)
    marks = tuple(Mark(event_id(index)) for index in range(len(shots)))
    return replace(heard, found=Detection(tuple(shots), ()), windows=windows, marks=marks)
