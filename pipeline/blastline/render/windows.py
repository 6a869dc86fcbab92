"""Where the drive follows the film: one window around each shot, and one around shots whose windows meet.

     fade in   guard     onset ..... end of the sound   fade out
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


@dataclass(frozen=True)
class _OwnWindow:
    """The window that a shot would have alone, and the shot's place among the film's."""

    window: Window
    shot: Shot
    index: int


def plan_windows(
    shots: Sequence[Shot],
    *,
    frames: int,
    rate_hz: int,
    rules: WindowRules,
    given: Mapping[int, Window] = MappingProxyType({}),
) -> tuple[PlannedWindow, ...]:
    """Return the windows of a film's shots: sorted, disjoint, not touching, inside [0, frames).

    The fade-in is over `guard_ms` before the onset, the fade-out begins where the shot's decay and its reflections are
    over. Windows that touch or overlap become one. At the ends of the film a fade shrinks to the room there is: a shot
    on frame 0 has full weight at once. `given` are windows, by the shot's index, that are settled already. Raises
    ValueError for a shot that begins outside the film.
    """
    own: list[_OwnWindow] = []
    for index, shot in enumerate(shots):
        if not 0 <= shot.onset < frames:
            raise ValueError(f"shot {index} begins at sample {shot.onset}, outside the film's {frames} frames")
        sounding = Span(shot.onset, min(_over_at(shot), frames))
        window = given.get(index) or _around(sounding, frames=frames, rate_hz=rate_hz, rules=rules)
        own.append(_OwnWindow(window, shot, index))
    own.sort(key=lambda each: (each.window.start, each.shot.onset, each.index))
    return tuple(_joined(group) for group in _meeting(own))


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
    sounding = Span(shot.onset, min(_over_at(shot), frames))
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


def _meeting(own: Sequence[_OwnWindow]) -> Iterator[Sequence[_OwnWindow]]:
    """Yield the runs of windows, ascending by their starts, that touch or overlap."""
    first, stop = 0, own[0].window.stop if own else 0
    for place, each in enumerate(own):
        if each.window.start > stop:
            yield own[first:place]
            first = place
        stop = max(stop, each.window.stop)
    if own:
        yield own[first:]


def _joined(group: Sequence[_OwnWindow]) -> PlannedWindow:
    """Return windows that meet as one; no fade reaches into an onset.

    A fade-out that somebody has set may begin while a later shot sounds: it takes at most half of the room after that.
    """
    window, shot = group[0].window, group[0].shot
    first = latest = shot.onset
    sounding = _over_at(shot)
    for other in group[1:]:
        first, latest = min(first, other.shot.onset), max(latest, other.shot.onset)
        sounding = max(sounding, _over_at(other.shot))
        last = max(window, other.window, key=lambda w: (w.stop, -w.fade_out_samples))
        window = Window(
            window.start,
            last.stop,
            min(window.fade_in_samples, first - window.start),
            min(last.fade_out_samples, max(last.stop - sounding, (last.stop - latest) // 2)),
        )
    in_time = sorted(group, key=lambda each: (each.shot.onset, each.index))
    return PlannedWindow(window, tuple(each.index for each in in_time))


def _over_at(shot: Shot) -> int:
    """Return the sample at which a shot is over; one that has no length sounds on its onset."""
    return max(shot.span.stop, shot.onset + 1)


def _around(sounding: Span, *, frames: int, rate_hz: int, rules: WindowRules) -> Window:
    """Return the window around what sounds; both its ends move one way with theirs, so joining first is the same."""
    whole = max(0, sounding.start - samples_from_ms(rules.guard_ms, rate_hz))
    start = max(0, whole - samples_from_ms(rules.fade_in_ms, rate_hz))
    stop = min(frames, sounding.stop + samples_from_ms(rules.fade_out_ms, rate_hz))
    return Window(start, stop, whole - start, stop - sounding.stop)
