"""A frequency response as it was measured, and the CSV file that holds one."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..plurals import counted
from ..ruleset import FREQUENCY, Columns, read_columns
from ..units import gains_from_db, levels_db

Values = NDArray[np.float64]

_LEVEL_LIMIT_DB = 400.0
_FEWEST_ROWS = 8
_LEAST_OCTAVES = 1.0

_AT_ONCE_MS = 1.0
"""Two channels of one recorder begin together to well below this."""

_RATIO_SPAN = 10.0
_LEVEL_SPAN_DB = 6.0
"""A seat's gains differ by more than a factor of 10; levels that do all the same, within 6 dB of each other, may be
ratios."""


_HZ_FORM = ".8g"
"""How frequencies are written, the ends of the band as the rows: an end that is rounded otherwise than its own row
leaves that out."""


@dataclass(frozen=True, eq=False)
class MeasuredResponse:
    """An actuator's response at ascending frequencies, shape (rows,) each.

    `gain` is a plain ratio. `phase_rad` is without the phase of a delay of `delay_s`, which was found and taken out.
    `coherence` is the share of the response's power that comes from the excitation, `averages` the number of
    independent segments behind it. `band_hz` is where the response is known well. None means not measured.
    """

    frequencies_hz: Values
    gain: Values
    phase_rad: Values | None = None
    coherence: Values | None = None
    averages: float | None = None
    delay_s: float = 0.0
    band_hz: tuple[float, float] = (0.0, math.inf)

    @property
    def gain_db(self) -> Values:
        """Return the gain as a level."""
        return levels_db(self.gain)

    @property
    def error_db(self) -> Values:
        """Return the standard error of each gain in dB, 0 where the measurement does not tell.

        For H1, the variance of ln |H| is (1 - c) / (2 c n) with coherence c and n averages (Bendat and Piersol).
        """
        if self.coherence is None or self.averages is None:
            return np.zeros_like(self.gain)
        coherence = unbiased(self.coherence, self.averages)
        return np.asarray(standard_error_db(coherence, self.averages), dtype=np.float64)

    @property
    def noise_power(self) -> Values:
        """Return the mean square of the noise in each gain, 0 where the measurement does not tell."""
        if self.coherence is None or self.averages is None:
            return np.zeros_like(self.gain)
        share = np.maximum(self.coherence, 1e-9)
        return np.asarray(self.gain**2 * (1.0 - share) / (share * self.averages), dtype=np.float64)

    def within(self, low_hz: float, high_hz: float) -> "MeasuredResponse":
        """Return the rows inside the usable band that lie from `low_hz` to `high_hz`."""
        low_hz, high_hz = max(low_hz, self.band_hz[0]), min(high_hz, self.band_hz[1])
        keep = (self.frequencies_hz >= low_hz) & (self.frequencies_hz <= high_hz)

        def kept(values: Values | None) -> Values | None:
            return None if values is None else values[keep]

        return MeasuredResponse(
            self.frequencies_hz[keep],
            self.gain[keep],
            kept(self.phase_rad),
            kept(self.coherence),
            self.averages,
            self.delay_s,
            (low_hz, high_hz),
        )


def unbiased(coherence: Values, averages: float) -> Values:
    """Return coherence without what chance alone would give `averages` segments, 1 / averages."""
    return np.maximum((coherence - 1.0 / averages) / (1.0 - 1.0 / averages), 0.0)


def standard_error_db(coherence: Values, averages: float) -> Values:
    """Return the standard error of a gain in dB, from unbiased coherence; 0 where nothing is known becomes 100 dB."""
    share = np.maximum(coherence, 1e-6)
    return np.minimum(20.0 / math.log(10.0) * np.sqrt((1.0 - np.minimum(share, 1.0)) / (2.0 * share * averages)), 100.0)


def read_measured(path: Path) -> MeasuredResponse:
    """Read a response from a CSV file with the columns `frequency_hz, gain_db [, phase_deg] [, coherence]`.

    Notes before the table may give `# delay_s: ...`, `# averages: ...` and `# band_hz: LOW HIGH`, as `measured_csv`
    does. Raises RuleError with one line for a file that holds no measurement: empty, too few rows, not ascending, NaN,
    out of range, or less than an octave.
    """
    read = read_columns(path, needed=(FREQUENCY, "gain_db"), optional=("phase_deg", "coherence"))
    frequencies_hz, gain_db = read.values[FREQUENCY], read.values["gain_db"]
    rows = len(frequencies_hz)
    if rows < _FEWEST_ROWS:
        raise RuleError(f"{path}: holds {counted(rows, 'row')}; expected at least {_FEWEST_ROWS}")
    if math.log2(frequencies_hz[-1] / frequencies_hz[0]) < _LEAST_OCTAVES:
        span = f"{frequencies_hz[0]:g} to {frequencies_hz[-1]:g} Hz"
        raise RuleError(f"{path}: {FREQUENCY} runs from {span}; expected at least an octave")
    _require_within(path, read, "gain_db", -_LEVEL_LIMIT_DB, _LEVEL_LIMIT_DB)
    _require_within(path, read, "coherence", 0.0, 1.0)
    phase_deg = read.values.get("phase_deg")
    return MeasuredResponse(
        frequencies_hz,
        gains_from_db(gain_db),
        None if phase_deg is None else np.radians(phase_deg),
        read.values.get("coherence"),
        _note(path, read, "averages", least=2.0),
        _note(path, read, "delay_s", least=-math.inf) or 0.0,
        _band(path, read),
    )


def require_coherent(measured: MeasuredResponse, path: Path, *, least: float) -> None:
    """Raise RuleError for a table whose own coherence says that none of its gains was measured."""
    if measured.coherence is None:
        return
    known = measured.within(*measured.band_hz)
    assert known.coherence is not None
    highest = float(np.max(known.coherence, initial=0.0))
    if highest < least:
        low_hz, high_hz = known.band_hz
        raise RuleError(
            f"{path}: coherence = {highest:g} at most, from {low_hz:g} to {high_hz:g} Hz: nothing of the response is "
            f"known to follow the excitation; expected {least:g} or more, or a table without that column"
        )


def doubts(measured: MeasuredResponse, path: Path) -> tuple[str, ...]:
    """Return what looks wrong in a table, a line each, but may be right: levels that are more like plain ratios."""
    lowest_db, highest_db = float(np.min(measured.gain_db)), float(np.max(measured.gain_db))
    # what is 0 dB comes back from its gain as nearly 0
    if lowest_db < 1e-9 or highest_db < _RATIO_SPAN * lowest_db or highest_db - lowest_db > _LEVEL_SPAN_DB:
        return ()
    return (
        f"{path}: gain_db = {lowest_db:.3g} to {highest_db:.3g}: looks like plain ratios; expected levels, 20 log10 of "
        "the ratio (were they levels, this seat would be almost flat)",
    )


def doubts_of_order(measured: MeasuredResponse, excitation: Path, response: Path) -> tuple[str, ...]:
    """Return a line on a response that comes before its excitation: no seat is so quick, but recorders start apart."""
    early_ms = -1000.0 * measured.delay_s
    if early_ms <= _AT_ONCE_MS:
        return ()
    return (
        f"{response}: comes {early_ms:.3f} ms before {excitation.name}: expected it later where both were recorded at "
        "once; are --excitation and --response exchanged?",
    )


def measured_csv(measured: MeasuredResponse, source: str) -> str:
    """Return the text of a CSV file that `read_measured` reads."""
    low_hz, high_hz = measured.band_hz
    line = " ".join(source.splitlines())  # a file may be named over several
    band = f"{low_hz:{_HZ_FORM}} {high_hz:{_HZ_FORM}}"
    notes = {"source": line, "delay_s": f"{measured.delay_s:.9f}", "band_hz": band}
    if measured.averages is not None:
        notes["averages"] = f"{measured.averages:.6g}"
    columns = {FREQUENCY: (measured.frequencies_hz, _HZ_FORM), "gain_db": (measured.gain_db, ".4f")}
    if measured.phase_rad is not None:
        columns["phase_deg"] = (np.degrees(measured.phase_rad), ".3f")
    if measured.coherence is not None:
        columns["coherence"] = (measured.coherence, ".6f")
    lines = [*(f"# {key}: {value}" for key, value in notes.items()), ",".join(columns)]
    for row in zip(*(values for values, _ in columns.values()), strict=True):
        lines.append(",".join(f"{value:{form}}" for value, (_, form) in zip(row, columns.values(), strict=True)))
    return "\n".join(lines) + "\n"


def _require_within(path: Path, read: Columns, name: str, low: float, high: float) -> None:
    values = read.values.get(name, np.zeros(0))
    outside = np.flatnonzero((values < low) | (values > high))
    if len(outside):
        row = int(outside[0])
        where = f"{name} = {values[row]:g} at {read.values[FREQUENCY][row]:g} Hz"
        raise RuleError(f"{path}: {where}: expected {low:g} to {high:g}")


def _note(path: Path, read: Columns, key: str, *, least: float) -> float | None:
    text = read.notes.get(key)
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < least:
        raise RuleError(f"{path}: # {key}: {text!r}: expected a number" + (f" >= {least:g}" if least > 0.0 else ""))
    return value


def _band(path: Path, read: Columns) -> tuple[float, float]:
    """Return the usable band: what the notes say, else everything that was measured."""
    frequencies_hz = read.values[FREQUENCY]
    text = read.notes.get("band_hz")
    if text is None:
        return float(frequencies_hz[0]), float(frequencies_hz[-1])
    try:
        low_hz, high_hz = (float(part) for part in text.split())
    except ValueError:
        low_hz, high_hz = 0.0, 0.0
    if not 0.0 < low_hz < high_hz:
        raise RuleError(f"{path}: # band_hz: {text!r}: expected two ascending frequencies")
    if not np.any((frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)):
        table = f"{frequencies_hz[0]:g} to {frequencies_hz[-1]:g} Hz"
        raise RuleError(f"{path}: # band_hz: {text!r}: expected a band of the table, which runs from {table}")
    return low_hz, high_hz
