"""Where the drive follows the film: one window around each shot, and one around shots whose windows meet.

     fade in   guard     onset ......... end of decay   fade out
0 ───╱────────|─────────|▇▇▆▅▄▃▂▂▁▁▁▁▁▁▁▁|──────────────╲─── 0
     window.start                                window.stop
"""

from collections.abc import Sequence
from dataclasses import dataclass

from ..model import Shot, Span, Window
from ..ruleset import WindowRules
from ..units import samples_from_ms


@dataclass(frozen=True)
class PlannedWindow:
    """A window of the drive and the indices, in order, of the shots that it renders."""

    window: Window
    shots: tuple[int, ...]

    @property
    def core(self) -> Span:
        """Return the part of the window at full weight, between its fades."""
        return Span(self.window.start + self.window.fade_in_samples, self.window.stop - self.window.fade_out_samples)


def plan_windows(shots: Sequence[Shot], *, frames: int, rate_hz: int, rules: WindowRules) -> tuple[PlannedWindow, ...]:
    """Return the windows of a film's shots: sorted, disjoint, not touching, inside [0, frames).

    The fade-in is over `guard_ms` before the onset, the fade-out begins where the decay has ended. Windows that touch
    or overlap become one. At the ends of the film a fade shrinks to the room there is: a shot on frame 0 has full
    weight at once. Raises ValueError for a shot that begins outside the film.
    """
    spans: list[tuple[Span, tuple[int, ...]]] = []
    reach = 0  # up to where the windows so far reach
    for index in sorted(range(len(shots)), key=lambda i: (shots[i].onset, i)):
        shot = shots[index]
        if not 0 <= shot.onset < frames:
            raise ValueError(f"shot {index} begins at sample {shot.onset}, outside the film's {frames} frames")
        sounding = Span(shot.onset, min(max(shot.span.stop, shot.onset + 1), frames))
        window = _around(sounding, frames=frames, rate_hz=rate_hz, rules=rules)
        if spans and window.start <= reach:
            together, members = spans[-1]
            spans[-1] = (together | sounding, (*members, index))
        else:
            spans.append((sounding, (index,)))
        reach = max(reach, window.stop)
    return tuple(
        PlannedWindow(_around(span, frames=frames, rate_hz=rate_hz, rules=rules), members) for span, members in spans
    )


def _around(sounding: Span, *, frames: int, rate_hz: int, rules: WindowRules) -> Window:
    """Return the window around what sounds; both its ends move one way with theirs, so joining first is the same."""
    whole = max(0, sounding.start - samples_from_ms(rules.guard_ms, rate_hz))
    start = max(0, whole - samples_from_ms(rules.fade_in_ms, rate_hz))
    stop = min(frames, sounding.stop + samples_from_ms(rules.fade_out_ms, rate_hz))
    return Window(start, stop, whole - start, stop - sounding.stop)
