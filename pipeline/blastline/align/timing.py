"""Whether the drive as a whole is displaced or runs at another speed, from where it holds each shot."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..model import Event
from .comparison import Comparison
from .found import likeness_limit, locate, sharp
from .hearing import Part
from .lags import ShotLag, line_through, line_through_exact
from .shots import ShotFigures, measure
from .sounds import TimeMap
from .whole_drive import moving_spans

_PROBES = 24
"""Shots, spread over the film, that are looked for one by one in a drive that seems displaced."""

_WIDE_MS = 4000.0
"""How far from its expected place a probe is looked for."""

_STILL_MS = 10.0
"""A drive at rest for this long has left its window."""

_SCALES = (0.5, 2.0)
"""No drive runs slower or faster than this beside its film: what points to less or more is another film's."""


@dataclass(frozen=True)
class Timing:
    """Where the drive holds the film: its line, which shots it was fitted to, and each shot's figures.

    `time_map` is the fitted line, None where no shot was found; `exact` says that the actuator's limit has no part in
    it. The figures were taken with the drive read from `read`. `lags` are in samples against what was intended, None
    where a shot was not found. `found` counts those that were and are comparable.
    """

    time_map: TimeMap | None
    exact: bool
    read: TimeMap
    figures: tuple[ShotFigures | None, ...]
    lags: tuple[float | None, ...]
    found: int


def time_film(shared: Comparison, events: Sequence[Event], parts: Sequence[Part], comparable: Sequence[bool]) -> Timing:
    """Return where the drive holds every shot; only `comparable` ones say where it is as a whole.

    First each shot is searched for around its own place. Where fewer than half are found there, the drive is taken
    to be displaced, and is read again from where it seems to be.
    """
    timing = _measure_all(shared, events, parts, comparable, TimeMap())
    asked = sum(comparable)
    if 2 * timing.found >= asked:
        return timing
    for guess in _guesses(shared, events, parts, comparable):
        elsewhere = _measure_all(shared, events, parts, comparable, _whole(guess, events))
        if elsewhere.found > max(timing.found, asked // 2):
            return elsewhere
    return timing


def _whole(guess: TimeMap, events: Sequence[Event]) -> TimeMap:
    """Return a displacement by whole samples where the speed is right: it is read without interpolation."""
    drift = guess.lag(events[-1].onset_sample) - guess.lag(events[0].onset_sample)
    return TimeMap(1.0, round(guess.lag(events[0].onset_sample))) if abs(drift) < 1.0 else guess


def _measure_all(
    shared: Comparison, events: Sequence[Event], parts: Sequence[Part], comparable: Sequence[bool], read: TimeMap
) -> Timing:
    """Return the timing with the drive read from one place; the line goes through exact lags where there are enough.

    Of shots that cannot be compared, what they have to do is told by their own place.
    """
    figures = tuple(
        measure(shared, event, part, time_map=read, in_place=not compared)
        for event, part, compared in zip(events, parts, comparable, strict=True)
    )
    lags: list[float | None] = []
    found: list[ShotLag] = []
    exact: list[ShotLag] = []
    for event, figure, compared in zip(events, figures, comparable, strict=True):
        if figure is None or abs(figure.match.correlation) < likeness_limit(shared, event):
            lags.append(None)
            continue
        lag = read.lag(event.onset_sample) + figure.match.lag * read.scale
        lags.append(lag)
        if compared:
            found.append(ShotLag(event.onset_sample, lag))
        if compared and figure.uncertainty <= sharp(shared, event):
            exact.append(found[-1])
    line = line_through_exact(exact, found, bend=shared.bend)
    is_exact = line is not None
    if line is None and found:
        line = line_through(found)
    return Timing(line, is_exact, read, figures, tuple(lags), len(found))


def _guesses(
    shared: Comparison, events: Sequence[Event], parts: Sequence[Part], comparable: Sequence[bool]
) -> list[TimeMap]:
    """Return where a displaced drive may lie: by the pattern of its windows, and by its shots one after the other."""
    guesses = []
    if shared.background == "mute":
        pattern = _by_windows(shared, events)
        guesses += [pattern] if pattern else []
    indices = [index for index, compared in enumerate(comparable) if compared]
    probes = _by_probes(shared, [events[index] for index in indices], [parts[index] for index in indices])
    guesses += [probes] if probes else []
    slowest, fastest = _SCALES
    return [guess for guess in guesses if slowest <= guess.scale <= fastest]


def _by_windows(shared: Comparison, events: Sequence[Event]) -> TimeMap | None:
    """Return the line through the starts of the drive's movements, where there are as many as windows."""
    ratio = shared.rate_hz / shared.drive.rate_hz
    still = shared.samples(_STILL_MS)
    moving = moving_spans(shared.drive.pieces(), still=round(still / ratio))
    windows = sorted({event.window.span for event in events})
    merged = [windows[0].start] + [b.start for a, b in pairwise(windows) if b.start - a.stop >= still]
    if len(moving) != len(merged):
        return None
    starts = zip(merged, moving, strict=True)
    return line_through([ShotLag(start, span.start * ratio - start) for start, span in starts])


def _by_probes(shared: Comparison, events: Sequence[Event], parts: Sequence[Part]) -> TimeMap | None:
    """Return the line through shots found one after the other, each expected where the earlier ones point."""
    chosen = np.unique(np.linspace(0, len(events) - 1, min(_PROBES, len(events))).round().astype(int))
    found: list[ShotLag] = []
    for index in chosen:
        onset = events[index].onset_sample
        expected = round(line_through(found).lag(onset)) if found else 0
        match = locate(
            shared, events[index], parts[index], time_map=TimeMap(1.0, expected), search=shared.samples(_WIDE_MS)
        )
        if abs(match.correlation) >= likeness_limit(shared, events[index]):
            found.append(ShotLag(onset, expected + match.lag))
    return line_through(found) if len(found) > len(chosen) // 2 else None
