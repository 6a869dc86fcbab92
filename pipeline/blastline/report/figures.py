"""The picture of a shot, as Fig. 6 of the paper: what is heard, what direct conversion makes felt, the drive and what
it makes felt; each as the whole waveform, its attack, and its spectrum.

Drawn with matplotlib into SVG text. Colours leave as the page's own variables, so that one picture suits a light and a
dark screen, and letters stay letters.
"""

import io
import re
from typing import Any

import numpy as np

from .sounds import EventSound, Samples, envelope, spectrum_db
from .style import INK, SERIES, figure_settings

_WIDTH_IN, _HEIGHT_IN = 10.6, 6.2
_COLUMNS_WHOLE, _COLUMNS_ATTACK, _BANDS = 420, 260, 90
_ATTACK_MS = (-4.0, 22.0)
_SPECTRUM_HZ = (10.0, 4000.0)
_SPECTRUM_DB = (-60.0, 5.0)
_ROWS = (
    "Heard: the sound, and its band of vibration",
    "Felt if the sound went straight to the seat",
    "Drive, with the actuator's limit",
    "Felt with this drive",
)
_DRIVE = 2
_UNIT_BELOW = -0.2


class ShotPictures:
    """Draws shots, one after another, on one set of axes: making axes and their ticks takes longer than all curves."""

    def __init__(self) -> None:
        """Make the axes with all that is the same for every shot."""
        import matplotlib as mpl
        from matplotlib.backends.backend_svg import FigureCanvasSVG
        from matplotlib.figure import Figure

        with mpl.rc_context(_settings("axes")):
            figure = Figure(figsize=(_WIDTH_IN, _HEIGHT_IN), facecolor="none")
            self._canvas: Any = FigureCanvasSVG(figure)
            self._grid: Any = figure.subplots(4, 3, gridspec_kw={"width_ratios": [3.0, 2.2, 2.0]})
            figure.subplots_adjust(left=0.058, right=0.99, top=0.955, bottom=0.07, wspace=0.2, hspace=0.3)
            _label(self._grid)

    def drawn(self, sound: EventSound) -> str:
        """Return the picture of a shot as an SVG element."""
        import matplotlib as mpl

        with mpl.rc_context(_settings(sound.event.id)):
            curves = _draw(self._grid, sound)
            text = io.StringIO()
            self._canvas.print_svg(text, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
            for curve in curves:
                curve.remove()
        return _as_inline(text.getvalue(), sound)


def _settings(salt: str) -> Any:
    return {**figure_settings(salt), "font.size": 8.5, "axes.facecolor": "none", "path.simplify_threshold": 0.2}


def _label(grid: Any) -> None:
    """Write titles and scales; those whose place is given are not moved, for which all ticks would be measured."""
    for number, (whole, attack, spectrum) in enumerate(grid):
        last = number == len(_ROWS) - 1
        whole.set_title(_ROWS[number], loc="left", fontsize=9, fontweight="bold", pad=3, y=1.0)
        for axes in (whole, attack):
            axes.tick_params(labelbottom=last)
        attack.tick_params(labelleft=False)
        spectrum.set_xscale("log")
        spectrum.set_xlim(*_SPECTRUM_HZ)
        spectrum.set_ylim(*_SPECTRUM_DB)
        spectrum.set_yticks([-60, -40, -20, 0])
        spectrum.set_xticks([10, 100, 1000], ["10", "100", "1k"])
        spectrum.minorticks_off()
        spectrum.tick_params(labelbottom=last)
        spectrum.grid(color=INK["grid"], lw=0.5)
    for axes in grid[_DRIVE][:2]:
        for limit in (1.0, -1.0):
            axes.axhline(limit, color=SERIES["limit"], lw=0.8, ls=(0, (4, 2)), zorder=2.5)  # over the curves
    for axes, title in zip(grid[0][1:], ("The first 20 ms", "Spectrum, dB"), strict=True):
        axes.set_title(title, loc="left", fontsize=9, color=INK["soft"], pad=3, y=1.0)
    for axes, unit in zip(grid[-1], ("ms from the onset", "ms from the onset", "Hz"), strict=True):
        axes.set_xlabel(unit)
    for axis in (axis for axes in grid.flat for axis in (axes.xaxis, axes.yaxis)):
        axis.set_label_coords(0.5, _UNIT_BELOW)


def _draw(grid: Any, sound: EventSound) -> list[Any]:
    """Draw a shot and return what was drawn."""
    level = 1.08 * max(1e-9, *(float(np.abs(s).max()) for s in (sound.audio, sound.target, sound.felt_drive)))
    heard = _spectrum(sound, sound.target)
    rows = [
        ([("audio", sound.audio), ("band", sound.target)], level),
        ([("band", sound.target), ("direct", sound.felt_direct)], level),
        ([("drive", sound.drive)], 1.12),
        ([("band", sound.target), ("felt", sound.felt_drive)], level),
    ]
    drawn: list[Any] = []
    for (whole, attack, spectrum), (curves, limit) in zip(grid, rows, strict=True):
        first, last = sound.times_ms[0], sound.times_ms[-1] + 1000.0 / sound.rate_hz  # one sample has a width as well
        whole.set_xlim(first, last)
        attack.set_xlim(max(_ATTACK_MS[0], first), min(_ATTACK_MS[1], last))
        for axes, columns in ((whole, _COLUMNS_WHOLE), (attack, _COLUMNS_ATTACK)):
            axes.set_ylim(-limit, limit)
            drawn += _shade(axes, sound)
            drawn += [_curve(axes, sound, samples, name, columns) for name, samples in curves]
        for name, samples in curves:
            level_db = _spectrum(sound, samples)
            level_db -= np.max(level_db if name == "drive" else heard)
            drawn += spectrum.plot(_centres(), level_db, color=SERIES[name], lw=1.1)
    return drawn


def _curve(axes: Any, sound: EventSound, samples: Samples, name: str, columns: int) -> Any:
    first, last = axes.get_xlim()
    times_ms = sound.times_ms
    inside = slice(int(np.searchsorted(times_ms, first)), int(np.searchsorted(times_ms, last, side="right")))
    index, values = envelope(samples[inside], columns)
    inside_ms = times_ms[inside][index.astype(np.int64)]
    return axes.plot(inside_ms, values, color=SERIES[name], lw=0.9, solid_joinstyle="round")[0]


def _shade(axes: Any, sound: EventSound) -> list[Any]:
    """Colour what belongs to blast and reflections, and draw the window's weight as a wedge below the curves."""
    event, rate_hz = sound.event, sound.rate_hz

    def at_ms(sample: int) -> float:
        return (sample - event.onset_sample) * 1000.0 / rate_hz

    blast, echoes = event.blast, event.reflections
    parts = [(blast.start, blast.stop, "blast", 0.22), *((e.start, e.stop, "reflection", 0.2) for e in echoes)]
    drawn = [axes.axvspan(at_ms(a), at_ms(b), color=SERIES[name], alpha=tint, lw=0) for a, b, name, tint in parts]
    window = event.window
    corners = (
        window.start,
        window.start + window.fade_in_samples,
        window.stop - window.fade_out_samples,
        window.stop,
    )
    wedge = axes.fill_between(
        [at_ms(c) for c in corners],
        [0, 0.06, 0.06, 0],
        transform=axes.get_xaxis_transform(),
        color=SERIES["window"],
        lw=0,
    )
    others = [axes.axvline(at_ms(o), color=SERIES["blast"], lw=0.8, ls=(0, (1, 2))) for o in sound.other_onsets]
    return [*drawn, wedge, *others]


def _bands_hz() -> Samples:
    return np.asarray(np.geomspace(*_SPECTRUM_HZ, _BANDS + 1), dtype=np.float64)


def _centres() -> Samples:
    edges = _bands_hz()
    return np.asarray(np.sqrt(edges[1:] * edges[:-1]), dtype=np.float64)


def _spectrum(sound: EventSound, samples: Samples) -> Samples:
    return spectrum_db(samples, sound.rate_hz, _bands_hz())


def _as_inline(svg: str, sound: EventSound) -> str:
    """Return the SVG as part of a page: without its head, with the page's colours and font, and said in words."""
    svg = svg[svg.index("<svg") :]
    for name, colour in {**SERIES, **{f"ink-{name}": colour for name, colour in INK.items()}}.items():
        svg = svg.replace(colour, f"var(--{name})")
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # only what is referred to needs a name, and names are the page's
    svg = re.sub(r"<svg [^>]*?viewBox=\"([^\"]*)\"[^>]*>", r'<svg class="shot" viewBox="\1" role="img">', svg, count=1)
    return svg.replace(">", f"><title>{_in_words(sound)}</title>", 1)


def _in_words(sound: EventSound) -> str:
    direct, felt, target = (float(np.abs(s).max()) for s in (sound.felt_direct, sound.felt_drive, sound.target))
    return (
        f"Peak of the sound in the band of vibration {target:.3g}; felt by direct conversion {direct:.3g}; "
        f"felt with the drive {felt:.3g}; peak of the drive {float(np.abs(sound.drive).max()):.3g} of the limit"
    )
