"""The Pareto fronts as a picture: what detection costs against F1, what a drive costs against what it loses."""

import io
import math
from collections.abc import Collection, Sequence
from typing import Any

from ..report.style import INK, SERIES, figure_settings
from .pareto import ParetoStudy
from .peer_scores import PeerScore
from .rendering_sweep import BEST, RenderingSweep
from .settings import TIERS
from .tally import DetectionScore

_WIDTH_IN, _HEIGHT_IN = 10.4, 4.6
_TIER, _CHANGE, _OTHER = SERIES["felt"], SERIES["audio"], SERIES["direct"]
_LEAST = 1e-6
_TIMES = (1, 2, 5, 10, 20, 50, 100, 200, 500)
_SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
_SHARES = (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def front_svg(study: ParetoStudy) -> str:
    """Return the fronts of detection and, where it was measured, of rendering as SVG; the same text for one study."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    settings: Any = {**figure_settings("pareto"), "font.size": 9}
    panels = 1 if study.rendering is None else 2
    with mpl.rc_context(settings):
        figure = Figure(figsize=(_WIDTH_IN * panels / 2, _HEIGHT_IN), facecolor="white")
        canvas: Any = FigureCanvasSVG(figure)
        axes: Any = figure.subplots(1, panels, squeeze=False)[0]
        _draw_detection(axes[0], study)
        if study.rendering is not None:
            _draw_rendering(axes[1], study.rendering, study.rendering_on_front)
        figure.tight_layout(w_pad=3.0)
        text = io.StringIO()
        canvas.print_svg(text, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()) + "\n"


def _draw_detection(axes: Any, study: ParetoStudy) -> None:
    axes.set_title("Finding shots", loc="left", fontsize=10.5, fontweight="bold")
    axes.set_xscale("log")
    axes.set_xlabel("CPU time, times soundfile's read of the film")
    axes.set_ylabel("F1 at 10 ms")
    every: tuple[DetectionScore | PeerScore, ...] = (*study.detection, *study.peers)
    front = [each for each in every if each.name in study.on_front]
    _line(axes, sorted((each.cost.times_read, each.f1) for each in front))
    for score in study.detection:
        cost, sure = score.cost.times_read, score.intervals.f1
        _point(axes, score.name, cost, score.f1)
        if score.name in TIERS:
            axes.plot([cost] * 2, [sure.low, sure.high], color=_TIER, lw=1.0, alpha=0.6)
            # the middle tier's name below its interval: tiers may stand close
            above = score.name != "standard"
            _label(axes, score.name, (cost, sure.high if above else sure.low), (0, 3 if above else -11), align="center")
    for peer in study.peers:
        _point(axes, peer.name, peer.cost.times_read, peer.f1, colour=_OTHER)
        below = peer.f1 < _nearest_in_cost(peer, study.peers).f1
        _label(axes, peer.name, (peer.cost.times_read, peer.f1), (6, -12 if below else 4))
    axes.set_ylim(bottom=0.0, top=1.06)
    _ticks(axes.xaxis, _TIMES, "{:g}")
    axes.grid(color=INK["grid"], lw=0.6)


def _nearest_in_cost(peer: PeerScore, peers: Sequence[PeerScore]) -> PeerScore:
    """Return the other peer whose cost has the least ratio to a peer's, on whose side no name fits; itself if alone."""

    def apart(other: PeerScore) -> float:
        return abs(math.log(other.cost.times_read / peer.cost.times_read))

    return min((other for other in peers if other is not peer), key=apart, default=peer)


def _draw_rendering(axes: Any, rendering: RenderingSweep, on_front: Collection[str]) -> None:
    axes.set_title("Rendering weak shots", loc="left", fontsize=10.5, fontweight="bold")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_yaxis()
    axes.set_xlabel("CPU s per s of window")
    axes.set_ylabel("energy lost above the best drive there is")
    points = [point for point in rendering.points if point.name != BEST]
    front = [point for point in points if point.name in on_front]
    _line(axes, sorted((p.cpu_s_per_window_s, max(_LEAST, p.above_best)) for p in front))
    for point in points:
        conversion = point.name in ("direct", "clipped", "scaled")
        place = (point.cpu_s_per_window_s, max(_LEAST, point.above_best))
        _point(axes, point.name, *place, colour=_OTHER if conversion else None)
        if conversion or point.name in TIERS:
            _label(axes, point.name, place, (6, -12 if point.name == "direct" else 5))
    _ticks(axes.xaxis, _SECONDS, "{:g}")
    _ticks(axes.yaxis, _SHARES, "{:g} %", of=100.0)
    axes.grid(color=INK["grid"], lw=0.6)


def _ticks(axis: Any, places: Sequence[float], text: str, *, of: float = 1.0) -> None:
    """Label an axis at those of some places that it shows; `of` is what a place is multiplied by in its label."""
    from matplotlib.ticker import NullLocator

    low, high = sorted(axis.get_view_interval())
    shown = [place for place in places if low <= place <= high]
    axis.set_ticks(shown, [text.format(of * place) for place in shown])
    axis.set_minor_locator(NullLocator())


def _line(axes: Any, front: Sequence[tuple[float, float]]) -> None:
    """Draw the front as the stairs that they are: between two settings there is only the cheaper one."""
    if front:
        costs, values = zip(*front, strict=True)
        axes.step(costs, values, where="post", color=INK["faint"], lw=1.0, zorder=1)


def _point(axes: Any, name: str, cost: float, value: float, *, colour: str | None = None) -> None:
    tier = name in TIERS
    shade = colour or (_TIER if tier else _CHANGE)
    axes.plot([cost], [value], "o", ms=8 if tier else 5, color=shade, mec="white", mew=0.6, zorder=3 if tier else 2)


def _label(axes: Any, name: str, place: tuple[float, float], offset: tuple[int, int], *, align: str = "left") -> None:
    weight = "bold" if name in TIERS else "normal"
    axes.annotate(
        name, place, xytext=offset, textcoords="offset points", ha=align, fontsize=8.5, fontweight=weight, zorder=4
    )
