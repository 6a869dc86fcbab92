"""What a film will cost on this machine: a sample of it goes through the real stages, timed by the CPU.

    film ──► excerpts here and there ──► one short file ──► listen ──► render ──► check ──► report

What a tier takes is then a fixed amount, so much for each second of film, so much for each shot, and for each picture.
"""

import gc
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import process_time

import msgspec

from ..detect import Detection, audio_around, find_shots, shot_at, verifier_of
from ..model import Quality, Shot
from ..progress import Progress, no_note, no_progress
from ..render import plan_windows
from ..report import OverviewMeter
from ..ruleset import Rules
from ..soundtrack import Soundtrack, open_soundtrack
from . import names
from .checking import checked
from .costs import AfterDetection, FilmCost, LinearCost, SharedCosts
from .driving import open_drive, write_drive_of
from .listening import HeardFilm, Mark, event_id, listen
from .options import RenderOptions, Setup, set_up
from .rendering import driven_timeline, write_formats, write_report_of
from .sampling import FilmSample, room_for_samples, sample_film, shorter_sample

FEW_SHOTS, FEW_PICTURES = 6, 3
"""About so many shots of the sample are rendered in each tier, from all over it, and so many pictures drawn.

The longer a window, the longer its picture takes: those nearest to the mean length stand for all.
"""

TIMED_TIMES = 2
"""So often what is found is found again: the first time takes a tenth more, or half where others use the machine."""


class Gauge:
    """Predicts what each tier takes for one film."""

    def __init__(self, sample: FilmSample, track: Soundtrack, options: RenderOptions, *, drives: bool) -> None:
        """Take over the sample and its open track; `drives` says whether there will be a drive."""
        self._sample, self._track, self._options, self._drives = sample, track, options, drives
        self._meter = OverviewMeter(track.rate_hz) if drives and options.report else None
        self._known: SharedCosts | None = None

    @property
    def film_s(self) -> float:
        """Return how long the film is, in seconds."""
        return self._sample.film_s

    def cost(self, quality: Quality) -> FilmCost:
        """Return what a tier takes; the first call also measures what is the same for all of them."""
        sample, setup = self._sample, set_up(replace(self._options, quality=quality), no_progress)
        if self._known is None:
            self._known = self._same_for_all(setup)
            _spare_from_collection()
        known = self._known
        cost = FilmCost(sample.hash_s, self._detection_per_s(setup.rules) + sample.decode_per_s)
        if not self._drives:
            return cost
        drives = self._drives_of(known, setup)
        return replace(
            cost,
            fixed_s=cost.fixed_s + known.empty.report_s + known.axes_s + drives.fixed_s,
            per_second=cost.per_second + known.empty.made_s / sample.seconds,
            per_shot=drives.each_s,
            per_picture=known.picture_s,
            shots_per_s=max(_audible(known.heard, setup.rules), 0.5) / sample.seconds,
        )

    def _drives_of(self, known: SharedCosts, setup: Setup) -> LinearCost:
        """Return what a drive and its checks take as soon as there is any shot, and what each shot adds to that.

        A few are rendered: a drive takes so much for each second of window, and all in the sample tell how long
        windows are; the checks take so much for each shot.
        """
        shots = self._shots(known.heard, setup.rules, FEW_SHOTS)
        few, one = (with_shots(known.heard, some, setup.rules) for some in (shots, shots[:1]))
        self._after(few, setup, report=False)  # what is imported, or worked out once for a tier
        first, last = (self._after(each, setup, report=False) for each in (one, few))
        longer_s, others = _windows_s(few) - _windows_s(one), len(shots) - 1
        if longer_s <= 0.0:  # a single shot, or all in the window of the first
            return LinearCost(0.0, max(0.0, last.made_s - known.empty.made_s) / len(shots))
        drive_per_s = max(0.0, last.drive_s - first.drive_s) / longer_s
        check_s = max(0.0, last.checks_s - first.checks_s) / others
        once_s = first.made_s - known.empty.made_s - drive_per_s * _windows_s(one) - check_s
        windows_per_shot_s = _windows_s(known.heard) / len(known.heard.found.shots)
        return LinearCost(max(0.0, once_s), check_s + drive_per_s * windows_per_shot_s)

    def _same_for_all(self, setup: Setup) -> SharedCosts:
        """Return what is heard in the whole sample, and what a film without shots and a picture take.

        Whatever has to be imported is imported by then.
        """
        heard, report = listen(self._track, setup.rules, no_progress, self._meter), self._meter is not None
        if not self._drives:
            return SharedCosts(heard, AfterDetection(0.0, 0.0, 0.0), 0.0, 0.0)
        some = with_shots(heard, self._typical(heard, setup.rules), setup.rules)
        self._after(with_shots(heard, some.found.shots[:1], setup.rules), setup, report=report)
        _spare_from_collection()
        empty = self._after(with_shots(heard, (), setup.rules), setup, report=report)
        if not report:
            return SharedCosts(heard, empty, 0.0, 0.0)
        first_s, all_s = (
            self._after(with_shots(heard, shots, setup.rules), setup, report=True).report_s
            for shots in (some.found.shots[:1], some.found.shots)
        )
        others = len(some.found.shots) - 1
        picture_s = max(0.0, all_s - first_s) / others if others else max(0.0, first_s - empty.report_s)
        return SharedCosts(heard, empty, max(0.0, first_s - empty.report_s - picture_s), picture_s)

    def _detection_per_s(self, rules: Rules) -> float:
        """Return what finding the shots takes in each second of film; the verifier, once read, is there for the run."""
        verifier = verifier_of(rules.tier, rules.overlay)
        timed = shorter_sample(self._track, self._sample.stride, sides=rules.tier.channels.sides)
        rate_hz = self._track.rate_hz
        heard_s: list[float] = []
        for _ in range(TIMED_TIMES):
            began = process_time()
            blocks = timed if self._meter is None else OverviewMeter(rate_hz).watch(timed)
            find_shots(blocks, rate_hz=rate_hz, tier=rules.tier, verifier=verifier)
            heard_s.append(process_time() - began)
        return min(heard_s) / (timed[-1].span.stop / rate_hz)

    def _shots(self, heard: HeardFilm, rules: Rules, most: int) -> Sequence[Shot]:
        """Return the first shots of windows from all over the sample, `most` or a few more; else its loudest moment.

        A window may hold hundreds: none is rendered with more than `most` of its shots.
        """
        windows = heard.windows
        if windows:
            chosen: list[int] = []
            for planned in windows[:: -(-len(windows) // most)]:
                chosen += planned.shots[:most] if len(chosen) < most else ()
            return [heard.found.shots[index] for index in chosen]
        at, rate_hz = self._sample.loudest, self._track.rate_hz
        sound = self._track.read(audio_around(at, frames=heard.source.frames, rate_hz=rate_hz, tier=rules.tier))
        return [shot_at(at, sound, confidence=1.0, tier=rules.tier)]

    def _typical(self, heard: HeardFilm, rules: Rules) -> Sequence[Shot]:
        """Return the first shots of the windows whose lengths are nearest to the mean, `FEW_PICTURES` of them."""
        if not heard.windows:
            return self._shots(heard, rules, 1)
        mean = sum(len(planned.window.span) for planned in heard.windows) / len(heard.windows)
        nearest = sorted(heard.windows, key=lambda planned: abs(len(planned.window.span) - mean))
        return [heard.found.shots[index] for index in sorted(each.shots[0] for each in nearest[:FEW_PICTURES])]

    def _after(self, heard: HeardFilm, setup: Setup, *, report: bool) -> AfterDetection:
        """Do all that follows detection and return what it took."""
        with tempfile.TemporaryDirectory(prefix="blastline-") as place:
            folder, began = Path(place), process_time()
            drives = write_drive_of(heard, folder / names.DRIVE, setup)
            driven = process_time()
            source = msgspec.structs.replace(self._sample.source, frames=heard.source.frames)
            timeline = driven_timeline(replace(heard, source=source), drives, setup)
            with open_drive(folder / names.DRIVE) as drive:
                profile, read, track = setup.profile, setup.rules, self._track
                timeline = checked(timeline, track, drive, profile=profile, rules=read, progress=no_progress)
                written = write_formats(timeline, folder, drive, setup, no_note)
                made = process_time()
                if report and self._meter is not None:
                    meter = self._meter
                    write_report_of(timeline, folder, written, track=track, drive=drive, meter=meter, setup=setup)
            return AfterDetection(driven - began, made - driven, process_time() - made)


@contextmanager
def open_gauge(
    film: Path, options: RenderOptions, *, drives: bool, progress: Progress = no_progress
) -> Iterator[Gauge]:
    """Sample a film and yield what predicts its cost.

    Raises SoundtrackError for a film that cannot be read, or whose length nothing tells, OutputError where the folder
    for temporary files has no room for the sample.
    """
    progress("measuring", 0, None)
    with room_for_samples() as folder:
        with open_soundtrack(film, stream=options.stream, mix=options.mix, timebase=options.timebase) as track:
            sample = sample_film(film, track, folder / "sample.wav", counted=drives)
        try:
            with open_soundtrack(sample.path) as heard:
                yield Gauge(sample, heard, options, drives=drives)
        finally:
            gc.unfreeze()


def _spare_from_collection() -> None:
    """Keep what is there now, imports and what pictures left behind, out of the next collections of garbage.

    To look through all of it takes as long as two pictures, and happens once in twenty: wherever it fell among the few
    that are timed, it would stand for all.
    """
    gc.freeze()


def _audible(heard: HeardFilm, rules: Rules) -> int:
    """Return how many of the shots a tier can find: those of the sides only where it listens to them."""
    return sum(rules.tier.channels.sides or shot.heard_in == "mains" for shot in heard.found.shots)


def _windows_s(heard: HeardFilm) -> float:
    """Return how long all windows are together, in seconds."""
    return sum(len(planned.window.span) for planned in heard.windows) / heard.source.sample_rate_hz


def with_shots(heard: HeardFilm, shots: Sequence[Shot], rules: Rules) -> HeardFilm:
    """Return what was heard as if these shots had been found in it."""
    source = heard.source
    windows = plan_windows(shots, frames=source.frames, rate_hz=source.sample_rate_hz, rules=rules.tier.windows)
    marks = tuple(Mark(event_id(index)) for index in range(len(shots)))
    return replace(heard, found=Detection(tuple(shots), ()), windows=windows, marks=marks)
