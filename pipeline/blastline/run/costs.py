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

from ..detect import Detection, audio_around, load_verifier, shot_at
from ..model import Quality, Shot
from ..render import plan_windows
from ..report import MOST_PICTURES, OverviewMeter
from ..ruleset import Rules, rules_path
from ..soundtrack import open_soundtrack
from . import names
from .checking import checked
from .driving import write_drive_of
from .listening import BLOCK, Listened, Mark, assemble, event_id, listen
from .options import RenderOptions, Setup, set_up
from .progress import Progress, no_note, no_progress
from .rendering import write_formats, write_report_of
from .sampling import Sampled, sampled

FEW_WINDOWS = 4
"""So many windows of the sample are rendered, from all over it."""


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


class Gauge:
    """Predicts what each tier takes for one film."""

    def __init__(self, sample: Sampled, options: RenderOptions, *, drives: bool) -> None:
        """Take over the sample; `drives` says whether there will be a drive."""
        self._sample, self._options, self._drives = sample, options, drives
        self._report = drives and options.report
        self._usual: tuple[_After, float] | None = None

    @property
    def film_s(self) -> float:
        """Return how long the film is, in seconds."""
        return self._sample.film_s

    def cost(self, quality: Quality) -> FilmCost:
        """Return what a tier takes; the first call also measures what is the same for all of them."""
        sample, setup = self._sample, set_up(replace(self._options, quality=quality), no_progress)
        if self._usual is None:
            self._usual = self._same_for_all(setup)
        empty, picture_s = self._usual
        verifier_s = _cpu_of_loading(setup.rules)
        heard, listen_s = self._listened(setup.rules)
        cost = FilmCost(
            verifier_s + sample.hash_s,
            max(0.0, listen_s - verifier_s) / sample.seconds + sample.decode_per_s,
            shots_per_s=max(len(heard.found.shots), 0.5) / sample.seconds,
        )
        if not self._drives:
            return cost
        few = _with_shots(heard, self._some_shots(heard, setup.rules, FEW_WINDOWS), setup.rules)
        made_s = self._after(few, setup, report=False).made_s
        return replace(
            cost,
            fixed_s=cost.fixed_s + empty.report_s,
            per_second=cost.per_second + empty.made_s / sample.seconds,
            per_shot=max(0.0, made_s - empty.made_s) / len(few.found.shots),
            per_picture=picture_s,
        )

    def _same_for_all(self, setup: Setup) -> tuple[_After, float]:
        """Return what a film without shots takes after the scan, and what a picture takes, once all is imported."""
        heard, _ = self._listened(setup.rules)
        if not self._drives:
            return _After(0.0, 0.0), 0.0
        none = _with_shots(heard, (), setup.rules)
        one = _with_shots(heard, self._some_shots(heard, setup.rules, 1)[:1], setup.rules)
        self._after(one, setup, report=self._report)
        empty = self._after(none, setup, report=self._report)
        if not self._report:
            return empty, 0.0
        return empty, max(0.0, self._after(one, setup, report=True).report_s - empty.report_s)

    def _listened(self, rules: Rules) -> tuple[Listened, float]:
        """Return what is heard in the sample and the CPU seconds it took, but for reading the sample."""
        with open_soundtrack(self._sample.path) as track:
            began = process_time()
            for _ in track.blocks(BLOCK):
                pass
            track.source()
            read_s = process_time() - began
        with open_soundtrack(self._sample.path) as track:
            meter = OverviewMeter(track.rate_hz) if self._report else None
            began = process_time()
            heard = listen(track, rules, no_progress, meter)
            return heard, process_time() - began - read_s

    def _some_shots(self, heard: Listened, rules: Rules, most: int) -> Sequence[Shot]:
        """Return the shots of windows from all over the sample; its loudest moment where there is none."""
        if heard.windows:
            chosen = heard.windows[:: -(-len(heard.windows) // most)]
            return [heard.found.shots[index] for planned in chosen for index in planned.shots]
        at, rate_hz = self._sample.loudest, heard.track.rate_hz
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
            sample = sampled(film, track, Path(folder) / "sample.wav")
        yield Gauge(sample, options, drives=drives)


def _with_shots(heard: Listened, shots: Sequence[Shot], rules: Rules) -> Listened:
    """Return what was heard as if these shots had been found in it."""
    source = heard.source
    windows = plan_windows(shots, frames=source.frames, rate_hz=source.sample_rate_hz, rules=rules.tier.windows)
    marks = tuple(Mark(event_id(index)) for index in range(len(shots)))
    return replace(heard, found=Detection(tuple(shots), ()), windows=windows, marks=marks)


def _cpu_of_loading(rules: Rules) -> float:
    """Return what reading the verifier takes."""
    began = process_time()
    load_verifier(rules_path(f"verifier/{rules.tier.verify.model}", rules.overlay), networks=rules.tier.verify.networks)
    return process_time() - began
