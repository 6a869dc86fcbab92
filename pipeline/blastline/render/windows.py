"""Where the drive follows the film: one window around each shot, and one around shots whose windows meet.

     fade in   guard     onset ......... end of decay   fade out
0 ───╱────────|─────────|▇▇▆▅▄▃▂▂▁▁▁▁▁▁▁▁|──────────────╲─── 0
     window.start                                window.stop
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from ..model import Shot, Span, Window
from ..ruleset import WindowRules
from ..units import samples_from_ms


@dataclass(frozen=True)
class PlannedWindow:
    """A window of the drive and the indices, in order, of the shots that it renders.

    `gains` are the onset of each shot with how much stronger than usual it is wanted, in dB; empty where none is.
    """

    window: Window
    shots: tuple[int, ...]
    gains: tuple[tuple[int, float], ...] = ()

    @property
    def core(self) -> Span:
        """Return the part of the window at full weight, between its fades."""
        return Span(self.window.start + self.window.fade_in_samples, self.window.stop - self.window.fade_out_samples)


def plan_windows(
    shots: Sequence[Shot],
    *,
    frames: int,
    rate_hz: int,
    rules: WindowRules,
    given: Mapping[int, Window] = MappingProxyType({}),
) -> tuple[PlannedWindow, ...]:
    """Return the windows of a film's shots: sorted, disjoint, not touching, inside [0, frames).

    The fade-in is over `guard_ms` before the onset, the fade-out begins where the decay has ended. Windows that touch
    or overlap become one. At the ends of the film a fade shrinks to the room there is: a shot on frame 0 has full
    weight at once. `given` are windows, by the shot's index, that are settled already. Raises ValueError for a shot
    that begins outside the film.
    """
    own: list[tuple[Window, int]] = []
    for index, shot in enumerate(shots):
        if not 0 <= shot.onset < frames:
            raise ValueError(f"shot {index} begins at sample {shot.onset}, outside the film's {frames} frames")
        sounding = Span(shot.onset, min(max(shot.span.stop, shot.onset + 1), frames))
        own.append((given.get(index) or _around(sounding, frames=frames, rate_hz=rate_hz, rules=rules), index))
    own.sort(key=lambda one: (one[0].start, shots[one[1]].onset, one[1]))
    return tuple(_joined(group, shots) for group in _meeting(own))


def with_gains(
    windows: Sequence[PlannedWindow], shots: Sequence[Shot], gains_db: Sequence[float]
) -> tuple[PlannedWindow, ...]:
    """Return the windows with the gains of their shots; `gains_db` is by the shot's index."""
    return tuple(
        replace(planned, gains=tuple((shots[index].onset, gains_db[index]) for index in planned.shots))
        if any(gains_db[index] for index in planned.shots)
        else planned
        for planned in windows
    )


def window_between(
    shot: Shot, *, start: int | None, stop: int | None, frames: int, rate_hz: int, rules: WindowRules
) -> Window:
    """Return a shot's window with ends that somebody has set; one that is None is where it would be planned.

    The fades are inside and shrink to the room there is before the onset, and to half of it after: the attack is the
    shot, and a window shorter than a fade keeps it. Raises ValueError where the onset is not inside.
    """
    sounding = Span(shot.onset, min(max(shot.span.stop, shot.onset + 1), frames))
    own = _around(sounding, frames=frames, rate_hz=rate_hz, rules=rules)
    begin, end = own.start if start is None else start, own.stop if stop is None else stop
    if not begin <= shot.onset < end <= frames:
        raise ValueError(f"a window from {begin} to {end} does not hold the onset at {shot.onset}")
    fade_in = own.fade_in_samples
    if start is not None:
        whole = max(0, shot.onset - samples_from_ms(rules.guard_ms, rate_hz))
        fade_in = max(0, min(samples_from_ms(rules.fade_in_ms, rate_hz), whole - begin))
    fade_out = own.fade_out_samples
    if stop is not None:
        fade_out = min(samples_from_ms(rules.fade_out_ms, rate_hz), (end - shot.onset) // 2)
    return Window(begin, end, fade_in, fade_out)


def _meeting(own: Sequence[tuple[Window, int]]) -> Iterator[Sequence[tuple[Window, int]]]:
    """Yield the runs of windows, ascending by their starts, that touch or overlap."""
    first, stop = 0, own[0][0].stop if own else 0
    for place, (window, _) in enumerate(own):
        if window.start > stop:
            yield own[first:place]
            first = place
        stop = max(stop, window.stop)
    if own:
        yield own[first:]


def _joined(group: Sequence[tuple[Window, int]], shots: Sequence[Shot]) -> PlannedWindow:
    """Return windows that meet, each with its shot's index, as one; no fade reaches into an onset.

    A fade-out that somebody has set may begin while a later shot sounds: it takes at most half of the room after that.
    """
    (window, index), *others = group
    first = latest = shots[index].onset
    sounding = shots[index].span.stop
    for other, index in others:
        shot = shots[index]
        first, latest, sounding = min(first, shot.onset), max(latest, shot.onset), max(sounding, shot.span.stop)
        last = max(window, other, key=lambda w: (w.stop, -w.fade_out_samples))
        window = Window(
            window.start,
            last.stop,
            min(window.fade_in_samples, first - window.start),
            min(last.fade_out_samples, max(last.stop - sounding, (last.stop - latest) // 2)),
        )
    return PlannedWindow(window, tuple(sorted((index for _, index in group), key=lambda i: (shots[i].onset, i))))


def _around(sounding: Span, *, frames: int, rate_hz: int, rules: WindowRules) -> Window:
    """Return the window around what sounds; both its ends move one way with theirs, so joining first is the same."""
    whole = max(0, sounding.start - samples_from_ms(rules.guard_ms, rate_hz))
    start = max(0, whole - samples_from_ms(rules.fade_in_ms, rate_hz))
    stop = min(frames, sounding.stop + samples_from_ms(rules.fade_out_ms, rate_hz))
    return Window(start, stop, whole - start, stop - sounding.stop)
