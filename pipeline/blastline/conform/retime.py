"""The old film's events as shots of the new one: every span moved, scaled, and ended where its scene ends."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import Event, HeardIn, Reflection, Shot, Span
from ..units import SILENCE_DB, db_from_gain, samples_from_ms, samples_from_s
from .courses import Course
from .film import Film
from .place import Placed

_LOUDEST_WITHIN_MS = 50.0


@dataclass(frozen=True)
class Retimed:
    """A shot of the new film, and where its old window begins and ends there: none of its own ends later."""

    shot: Shot
    start: int
    stop: int


def retimed(event: Event, placed: Placed, courses: Sequence[Course], old: Film, new: Film) -> Retimed:
    """Return an event as a shot of the new film, of which its place tells the course.

    It sounds until its old window begins to fade out; its window ends with its scene at the latest. Its level is the
    old one and what the new film is louder; confidence and signal-to-noise ratio are those of the old film. It belongs
    to no burst yet.
    """
    onset = min(samples_from_s(placed.new_s, new.rate_hz), new.frames - 1)
    scale = courses[placed.course].segment.line.scale
    rate = scale * new.rate_hz / old.rate_hz
    begins_s, ends_s = _scene_s(event.onset_sample / old.rate_hz, placed.course, courses, old)
    stop = min(new.frames, onset + max(1, round((ends_s * old.rate_hz - event.onset_sample) * rate)))
    lead = max(0.0, event.onset_sample - max(event.window.start, begins_s * old.rate_hz)) * rate

    def moved(sample: int) -> int:
        return min(max(onset, onset + round((sample - event.onset_sample) * rate)), stop)

    begun = min(moved(event.blast.start), stop - 1)
    blast = Span(begun, max(begun + 1, moved(event.blast.stop)))
    shot = Shot(
        onset=onset,
        confidence=event.confidence,
        peak_dbfs=_level_dbfs(event, onset, old, new),
        snr_db=event.snr_db,
        blast=blast,
        reflections=tuple(
            Reflection(
                moved(each.start),
                moved(each.stop),
                each.delay_ms * scale,
                each.level_db,
            )
            for each in event.reflections
            if moved(each.start) < stop
        ),
        span=Span(onset, max(blast.stop, moved(event.window.stop - event.window.fade_out_samples))),
    )
    return Retimed(shot, max(0, onset - round(lead)), max(onset + 1, moved(event.window.stop)))


def _scene_s(onset_s: float, index: int, courses: Sequence[Course], old: Film) -> tuple[float, float]:
    """Return from when to when of the old film the scene of an event lasts that is on the course at an index.

    That is the course. But a shot may be heard beyond an end of it, where a scene was dubbed over: there nothing tells
    of an end but what comes next in either film.
    """
    own, segments = courses[index].segment, [each.segment for each in courses]
    begins_s, ends_s = own.start_s, own.stop_s
    if onset_s >= ends_s:
        nexts_s = [at_s for each in segments for at_s in (each.start_s, own.line.back(each.new_span_s[0]))]
        ends_s = min((at_s for at_s in nexts_s if at_s > onset_s), default=old.duration_s)
    if onset_s < begins_s:
        lasts_s = [at_s for each in segments for at_s in (each.stop_s, own.line.back(each.new_span_s[1]))]
        begins_s = max((at_s for at_s in lasts_s if at_s <= onset_s), default=0.0)
    return begins_s, ends_s


def _level_dbfs(event: Event, onset: int, old: Film, new: Film) -> float:
    before, after = _swing(old, event.onset_sample, event.heard_in), _swing(new, onset, event.heard_in)
    if before <= 0.0 or after <= 0.0:
        return event.peak_dbfs
    return max(SILENCE_DB, event.peak_dbfs + db_from_gain(after / before))


def _swing(film: Film, onset: int, mix: HeardIn) -> float:
    """Return how far a film swings, peak to peak, after an onset in a mix; 0 where the film does not have it."""
    near = Span(onset, onset + samples_from_ms(_LOUDEST_WITHIN_MS, film.rate_hz)) & Span(0, film.frames)
    if not near:
        return 0.0
    heard = film.read(near, sides=mix == "sides").heard_in(mix)
    return 0.0 if heard is None else float(np.ptp(heard))
