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


def event_figure(sound: EventSound) -> str:
    """Return the picture of a shot as an SVG element."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    settings: Any = {
        **figure_settings(sound.event.id),
        "font.size": 8.5,
        "axes.facecolor": "none",
        "path.simplify_threshold": 0.2,
    }
    with mpl.rc_context(settings):
        figure = Figure(figsize=(_WIDTH_IN, _HEIGHT_IN), facecolor="none")
        canvas: Any = FigureCanvasSVG(figure)
        grid: Any = figure.subplots(4, 3, gridspec_kw={"width_ratios": [3.0, 2.2, 2.0]})
        figure.subplots_adjust(left=0.058, right=0.99, top=0.955, bottom=0.07, wspace=0.2, hspace=0.3)
        _draw(grid, sound)
        text = io.StringIO()
        canvas.print_svg(text, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _as_inline(text.getvalue(), sound)


def _draw(grid: Any, sound: EventSound) -> None:
    level = 1.08 * max(1e-9, *(float(np.abs(s).max()) for s in (sound.audio, sound.felt_drive)))
    rows = [
        ("Heard: the sound, and its band of vibration", [("audio", sound.audio), ("band", sound.target)], level),
        ("Felt if the sound went straight to the seat", [("band", sound.target), ("direct", sound.felt_direct)], level),
        ("Drive, with the actuator's limit", [("drive", sound.drive)], 1.12),
        ("Felt with this drive", [("band", sound.target), ("felt", sound.felt_drive)], level),
    ]
    reference = float(np.max(_spectrum(sound, sound.target)))
    for number, (title, curves, limit) in enumerate(rows):
        whole, attack, spectrum = grid[number]
        whole.set_title(title, loc="left", fontsize=9, fontweight="bold", pad=3)
        for axes, columns in ((whole, _COLUMNS_WHOLE), (attack, _COLUMNS_ATTACK)):
            _shade(axes, sound)
            axes.set_ylim(-limit, limit)
            axes.set_xlim(sound.times_ms[0], sound.times_ms[-1])
            if number < len(rows) - 1:
                axes.tick_params(labelbottom=False)
            if axes is attack:
                axes.set_xlim(max(_ATTACK_MS[0], sound.times_ms[0]), min(_ATTACK_MS[1], sound.times_ms[-1]))
            for name, samples in curves:
                _curve(axes, sound, samples, name, columns)
        for name, samples in curves:
            level_db = _spectrum(sound, samples) - (
                float(np.max(_spectrum(sound, samples))) if name == "drive" else reference
            )
            spectrum.semilogx(_centres(), level_db, color=SERIES[name], lw=1.1)
        spectrum.set_xlim(*_SPECTRUM_HZ)
        spectrum.set_ylim(*_SPECTRUM_DB)
        spectrum.set_yticks([-60, -40, -20, 0])
        spectrum.set_xticks([10, 100, 1000], ["10", "100", "1k"])
        spectrum.minorticks_off()
        spectrum.tick_params(labelbottom=number == len(rows) - 1)
        spectrum.grid(color=INK["grid"], lw=0.5)
        if number == 2:
            for axes in (whole, attack):
                axes.axhline(1.0, color=SERIES["limit"], lw=0.8, ls=(0, (4, 2)))
                axes.axhline(-1.0, color=SERIES["limit"], lw=0.8, ls=(0, (4, 2)))
    grid[0][1].set_title("The first 20 ms", loc="left", fontsize=9, color=INK["soft"], pad=3)
    grid[0][2].set_title("Spectrum, dB", loc="left", fontsize=9, color=INK["soft"], pad=3)
    grid[3][0].set_xlabel("ms from the onset", labelpad=2)
    grid[3][1].set_xlabel("ms from the onset", labelpad=2)
    grid[3][2].set_xlabel("Hz", labelpad=2)


def _curve(axes: Any, sound: EventSound, samples: Samples, name: str, columns: int) -> None:
    first, last = axes.get_xlim()
    times_ms = sound.times_ms
    inside = slice(int(np.searchsorted(times_ms, first)), int(np.searchsorted(times_ms, last, side="right")))
    index, values = envelope(samples[inside], columns)
    axes.plot(times_ms[inside][index.astype(np.int64)], values, color=SERIES[name], lw=0.9, solid_joinstyle="round")


def _shade(axes: Any, sound: EventSound) -> None:
    """Colour what belongs to blast and reflections, and draw the window's weight as a wedge below the curves."""
    event, rate_hz = sound.event, sound.rate_hz

    def at_ms(sample: int) -> float:
        return (sample - event.onset_sample) * 1000.0 / rate_hz

    axes.axvspan(at_ms(event.blast.start), at_ms(event.blast.stop), color=SERIES["blast"], alpha=0.22, lw=0)
    for echo in event.reflections:
        axes.axvspan(at_ms(echo.start), at_ms(echo.stop), color=SERIES["reflection"], alpha=0.2, lw=0)
    window = event.window
    corners = (
        window.start,
        window.start + window.fade_in_samples,
        window.stop - window.fade_out_samples,
        window.stop,
    )
    axes.fill_between(
        [at_ms(c) for c in corners],
        [0, 0.06, 0.06, 0],
        transform=axes.get_xaxis_transform(),
        color=SERIES["window"],
        lw=0,
    )
    for onset in sound.other_onsets:
        axes.axvline(at_ms(onset), color=SERIES["blast"], lw=0.8, ls=(0, (1, 2)))


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
    svg = re.sub(r"font: ([^;\"]*?)'sans-serif'[^;\"]*", r"font: \1inherit", svg)
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
