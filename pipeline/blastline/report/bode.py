"""Bode plots of an actuator, like Figs. 2, 3 and 5 of the paper: the actuator as measured with its coherence, the
skin, both together with the model that was fitted, and the compensator.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..ruleset import ActuatorProfile
from ..units import levels_db
from .drawing import ready_to_draw
from .style import INK, SERIES, figure_settings

Values = NDArray[np.float64]

_SHOWN_HZ = (2.0, 4000.0)
_TICKS_HZ = {2: "2", 5: "5", 10: "10", 20: "20", 50: "50", 100: "100", 200: "200", 500: "500", 1000: "1k", 2000: "2k"}
_COLUMN_IN, _HEIGHT_IN, _LEFT_IN, _DPI = 3.7, 5.9, 0.78, 160
_ROOM_DB = 75.0


@dataclass(frozen=True, eq=False)
class BodeCurve:
    """A response over frequency, shape (rows,) each: level in dB, phase in degrees and coherence where they are known.

    What lies outside `band_hz` is drawn faintly.
    """

    frequencies_hz: Values
    level_db: Values
    phase_deg: Values | None = None
    coherence: Values | None = None
    band_hz: tuple[float, float] = (0.0, np.inf)


Draw = Callable[[Any, Any], None]
Columns = list[tuple[str, Draw]]


def write_bode(
    path: Path,
    profile: ActuatorProfile,
    *,
    actuator: BodeCurve | None = None,
    skin: BodeCurve | None = None,
    product: BodeCurve | None = None,
) -> None:
    """Write the Bode plots of a profile as a picture, in the format that the file's name asks for.

    `product`, actuator times skin, is drawn behind the model that was fitted to it. Without the curves the picture
    has what a profile holds: what is felt, and the compensator.
    """
    ready_to_draw(path.parent)
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns: Columns = []
    if actuator is not None:
        columns.append(("Actuator, as measured", _measured_column(actuator, "direct")))
    if skin is not None:
        columns.append(("Skin, $H_m = (1/T)^2$", _measured_column(skin, "reflection")))
    columns += [
        ("Felt, $H(s)$", _felt_column(profile, product)),
        ("Compensator", _compensator_column(profile)),
    ]
    settings: Any = {
        **figure_settings(profile.name),
        "font.size": 9,
        "legend.frameon": False,
        "legend.fontsize": 8,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
    }
    with mpl.rc_context(settings):
        figure = Figure(figsize=(_COLUMN_IN * len(columns), _HEIGHT_IN), facecolor="white", dpi=_DPI)
        FigureCanvasAgg(figure)
        _draw(figure, profile, columns, coherence=actuator if actuator and actuator.coherence is not None else None)
        metadata = {"Date": None} if path.suffix.lower() == ".svg" else None
        with warnings.catch_warnings():
            # letters that the font lacks are drawn as boxes, which the picture shows
            warnings.filterwarnings("ignore", message="Glyph .* missing from font", category=UserWarning)
            figure.savefig(path, metadata=metadata)


def _draw(figure: Any, profile: ActuatorProfile, columns: Columns, *, coherence: BodeCurve | None) -> None:
    width = _COLUMN_IN * len(columns)
    figure.text(_LEFT_IN / width, 0.953, profile.name, fontsize=13, fontweight="bold", parse_math=False)
    low_hz, high_hz = profile.highpass.corner_hz, profile.lowpass.corner_hz
    band = f"shaded: the band of the drive, {low_hz:g} to {high_hz:g} Hz"
    figure.text(_LEFT_IN / width, 0.918, band, fontsize=8.5, color=INK["soft"])
    grid = figure.add_gridspec(
        3,
        len(columns),
        height_ratios=[3.0, 1.25, 1.0],
        left=_LEFT_IN / width,
        right=1.0 - 0.15 / width,
        top=0.85,
        bottom=0.085,
        wspace=0.19,
        hspace=0.16,
    )
    for number, (title, draw) in enumerate(columns):
        split = number == 0 and coherence is not None
        level = figure.add_subplot(grid[0, number])
        phase = figure.add_subplot(grid[1, number] if split else grid[1:, number])
        level.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=6)
        draw(level, phase)
        lowest = phase
        if split and coherence is not None:
            lowest = figure.add_subplot(grid[2, number])
            _draw_coherence(lowest, coherence)
        for axes in {level, phase, lowest}:
            _frequency_axis(axes, profile, labelled=axes is lowest)
        if number == 0:
            level.set_ylabel("level, dB")
            phase.set_ylabel("phase, °")
            figure.align_ylabels([level, phase, lowest])
        _phase_axis(phase)


def _measured_column(curve: BodeCurve, colour: str) -> Draw:
    def draw(level: Any, phase: Any) -> None:
        _plot(level, curve, curve.level_db, colour)
        _limit(level, curve.level_db[_known(curve)])
        if curve.phase_deg is not None:
            known = _known(curve)
            phase.plot(curve.frequencies_hz[known], _folded(curve.phase_deg[known]), color=SERIES[colour], lw=1.2)

    return draw


def _felt_column(profile: ActuatorProfile, product: BodeCurve | None) -> Draw:
    frequencies_hz = np.geomspace(*_SHOWN_HZ, 1200)
    felt = dsp.felt_response(profile).at(frequencies_hz)

    def draw(level: Any, phase: Any) -> None:
        shown = levels_db(np.abs(felt))
        if product is not None:
            _plot(level, product, product.level_db, "audio", width=3.2, label="measured")
            shown = np.concatenate([shown, product.level_db[_known(product)]])
            if product.phase_deg is not None:
                known = _known(product)
                phase.plot(
                    product.frequencies_hz[known], _folded(product.phase_deg[known]), color=SERIES["audio"], lw=3.2
                )
        level.semilogx(frequencies_hz, levels_db(np.abs(felt)), color=SERIES["felt"], lw=1.5, label="model")
        phase.semilogx(frequencies_hz, np.degrees(np.unwrap(np.angle(felt))), color=SERIES["felt"], lw=1.5)
        _limit(level, shown)
        if product is not None:
            level.legend(loc="best", handlelength=1.6)

    return draw


def _compensator_column(profile: ActuatorProfile) -> Draw:
    frequencies_hz = np.geomspace(*_SHOWN_HZ, 1200)
    drive = dsp.compensator(profile).at(frequencies_hz)
    inverse = dsp.inverse(profile).at(frequencies_hz)

    def draw(level: Any, phase: Any) -> None:
        for response, colour, width, label in (
            (inverse, SERIES["window"], 3.2, "$C(s) = 1/H(s)$"),
            (drive, SERIES["drive"], 1.5, "with its band filters"),
        ):
            level.semilogx(frequencies_hz, levels_db(np.abs(response)), color=colour, lw=width, label=label)
            phase.semilogx(frequencies_hz, np.degrees(np.unwrap(np.angle(response))), color=colour, lw=width)
        _limit(level, levels_db(np.abs(drive)))
        level.legend(loc="best", handlelength=1.6)

    return draw


def _draw_coherence(axes: Any, curve: BodeCurve) -> None:
    assert curve.coherence is not None
    axes.fill_between(curve.frequencies_hz, curve.coherence, color=SERIES["window"], lw=0, alpha=0.8)
    axes.set_ylim(0.0, 1.05)
    axes.set_yticks([0.0, 0.5, 1.0], ["0", "0.5", "1"])
    axes.set_ylabel("coherence")


def _plot(axes: Any, curve: BodeCurve, values: Values, colour: str, *, width: float = 1.2, label: str = "") -> None:
    """Draw values faintly, and once more in full colour where they are well known."""
    known = _known(curve)
    axes.semilogx(curve.frequencies_hz, values, color=SERIES[colour], lw=0.7, alpha=0.35)
    axes.semilogx(curve.frequencies_hz[known], values[known], color=SERIES[colour], lw=width, label=label)


def _known(curve: BodeCurve) -> NDArray[np.bool_]:
    low_hz, high_hz = curve.band_hz
    return (curve.frequencies_hz >= low_hz) & (curve.frequencies_hz <= high_hz)


def _limit(axes: Any, levels: Values) -> None:
    """Show a little more than the levels, at most 75 dB from the highest down."""
    high = 5.0 * np.ceil((np.max(levels) + 2.0) / 5.0)
    low = 5.0 * np.floor((np.min(levels) - 2.0) / 5.0)
    axes.set_ylim(max(low, high - _ROOM_DB), high)


def _frequency_axis(axes: Any, profile: ActuatorProfile, *, labelled: bool) -> None:
    axes.set_xscale("log")
    axes.set_xlim(*_SHOWN_HZ)
    axes.set_xticks(list(_TICKS_HZ), list(_TICKS_HZ.values()))
    axes.minorticks_off()
    axes.tick_params(labelbottom=labelled)
    axes.grid(color=INK["grid"], lw=0.5)
    axes.set_axisbelow(True)
    axes.axvspan(profile.highpass.corner_hz, profile.lowpass.corner_hz, color=SERIES["window"], alpha=0.13, lw=0)
    if labelled:
        axes.set_xlabel("Hz", labelpad=2)


def _phase_axis(axes: Any) -> None:
    from matplotlib.ticker import MultipleLocator

    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(MultipleLocator(45.0 if high - low < 200.0 else 90.0 if high - low < 500.0 else 180.0))


def _folded(phase_deg: Values) -> Values:
    """Return phases without jumps, moved by whole turns to lie around 0."""
    whole = np.degrees(np.unwrap(np.radians(phase_deg)))
    return np.asarray(whole - 360.0 * np.round(np.median(whole) / 360.0), dtype=np.float64)
