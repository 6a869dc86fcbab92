"""What was missed and what was taken for a shot, one by one, with what the detector says of it and how it sounds."""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import Span
from ..soundtrack import open_soundtrack
from ..units import samples_from_s
from .cases import Case
from .cost import Heard
from .sound_files import write_sound
from .tally import SCORED_MS, TIMED_MS, matched

EXCERPT_BEFORE_S, EXCERPT_AFTER_S = 0.5, 1.0
EVENTS, EXCERPTS = "events.csv", ("missed-*.wav", "false-*.wav")
_NEAR_MS = 20.0
_LONGEST_STEM, _LONGEST_STEM_BYTES = 80, 200
"""Letters and bytes of a film's name in that of an excerpt: file names end at 255 bytes, and a letter may have four."""


class ScoredEvent(msgspec.Struct, frozen=True):
    """A missed shot or a false event: where it is, and its level over what is around it, in dB, where that is known.

    `probability` is the detector's own, `reason` why it refused a shot or how far the false event is from one.
    """

    film: str
    kind: Literal["missed", "false"]
    at_s: float
    level_db: float | None
    probability: float | None
    reason: str


def scored_events(case: Case, heard: Heard) -> tuple[ScoredEvent, ...]:
    """Return what a film's detection got wrong at 10 ms, in order of time."""
    ms = 1000.0 / heard.rate_hz
    found_ms = np.array([shot.onset for shot in heard.detection.shots], np.float64) * ms
    pairs = matched(case, found_ms, SCORED_MS)
    used, hit = {found for found, _ in pairs}, {shot for _, shot in pairs}
    events = [*_missed(case, heard, np.delete(found_ms, sorted(used)), hit), *_false(case, heard, found_ms, used)]
    return tuple(sorted(events, key=lambda event: event.at_s))


def write_events(folder: Path, films: Sequence[tuple[Path, Sequence[ScoredEvent]]]) -> None:
    """Write a table of what was missed and what was false into a folder, and what is heard there, one WAV each.

    Raises OutputError where the disk refuses.
    """
    with (folder / EVENTS).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*ScoredEvent.__struct_fields__, "excerpt"])
        number = 0
        for path, events in films:
            names = []
            for event in events:
                number += 1
                names.append(f"{event.kind}-{number:04d}-{_stem(event.film)}-{event.at_s:.3f}s.wav")
                row = msgspec.structs.astuple(event)
                table.writerow([*("" if cell is None else cell for cell in row), names[-1]])
            if events:
                _write_excerpts(folder, names, path, [event.at_s for event in events])


def excerpt(samples: NDArray[np.float32], at: int, *, start: int, rate_hz: int) -> NDArray[np.float32]:
    """Return 1.5 s of a stretch that begins at sample `start` of its film, with sample `at` of the film 0.5 s in.

    Where the stretch does not reach there is silence.
    """
    before, after = samples_from_s(EXCERPT_BEFORE_S, rate_hz), samples_from_s(EXCERPT_AFTER_S, rate_hz)
    cut = np.zeros(before + after, np.float32)
    first = at - before - start
    inside = samples[max(0, first) : max(0, first + cut.size)]
    cut[max(0, -first) : max(0, -first) + inside.size] = inside
    return cut


def _stem(film: str) -> str:
    """Return the end of a film's name, as much of it as fits into that of an excerpt."""
    end = re.sub(r"[^\w.-]+", "_", film)[-_LONGEST_STEM:]
    return end.encode()[-_LONGEST_STEM_BYTES:].decode(errors="ignore")


def _missed(case: Case, heard: Heard, unused_ms: NDArray[np.float64], hit: set[int]) -> Iterator[ScoredEvent]:
    refused = heard.detection.rejections
    refused_ms = np.array([each.at_sample for each in refused], np.float64) * (1000.0 / heard.rate_hz)
    for shot, at_ms in enumerate(case.true_ms.tolist()):
        if shot in hit:
            continue
        level_db = float(case.snr_db[shot])
        late_ms = _nearest(unused_ms, at_ms, TIMED_MS)
        away_ms = _nearest(refused_ms, at_ms, _NEAR_MS)
        probability, reason = None, "no candidate that the screen let pass, or hardly a probability"
        if late_ms is not None:
            reason = f"found {late_ms:+.1f} ms away"
        elif away_ms is not None:
            rejection = refused[int(np.abs(refused_ms - at_ms).argmin())]
            probability, reason = rejection.evidence.get("probability"), rejection.reason
        known_db = None if np.isnan(level_db) else round(level_db, 2)
        yield ScoredEvent(case.name, "missed", round(at_ms / 1000.0, 6), known_db, probability, reason)


def _false(case: Case, heard: Heard, found_ms: NDArray[np.float64], used: set[int]) -> Iterator[ScoredEvent]:
    forgiven_ms = np.array([*case.forgiven_ms, *(at for others in case.alternatives_ms for at in others)], np.float64)
    for index, shot in enumerate(heard.detection.shots):
        at_ms = float(found_ms[index])
        if index in used or _nearest(forgiven_ms, at_ms, SCORED_MS) is not None:
            continue
        away_ms = _nearest(case.true_ms, at_ms, TIMED_MS)
        reason = "no shot near" if away_ms is None else f"a shot is {away_ms:+.1f} ms away"
        level_db = round(shot.snr_db, 2)
        yield ScoredEvent(case.name, "false", round(at_ms / 1000.0, 6), level_db, shot.confidence, reason)


def _nearest(times_ms: NDArray[np.float64], at_ms: float, within_ms: float) -> float | None:
    """Return how much later than `at_ms` the nearest of some times is; None where none is within reach."""
    if not times_ms.size:
        return None
    away_ms = float((times_ms - at_ms)[np.abs(times_ms - at_ms).argmin()])
    return away_ms if abs(away_ms) <= within_ms else None


def _write_excerpts(folder: Path, names: Sequence[str], path: Path, at_s: Sequence[float]) -> None:
    with open_soundtrack(path) as track:
        frames = sum(len(clip.span) for clip in track.blocks())
        rate_hz = track.rate_hz
        for name, second in zip(names, at_s, strict=True):
            at = samples_from_s(second, rate_hz)
            start = max(0, at - samples_from_s(EXCERPT_BEFORE_S, rate_hz))
            stop = min(frames, at + samples_from_s(EXCERPT_AFTER_S, rate_hz))
            heard = np.asarray(track.read(Span(start, stop)).heard, np.float32)
            cut = excerpt(heard, at, start=start, rate_hz=rate_hz)
            write_sound(folder / name, cut, rate_hz)
