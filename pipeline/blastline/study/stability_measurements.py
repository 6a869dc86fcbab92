"""Rows about measured actuators: what is fitted decays and keeps its bounds, what is no measurement is refused.

The references are the exact response that a table or a recording was made from, and the analogue formulas in 50 digits.
"""

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..actuator import (
    FitTarget,
    FittedResponse,
    analogue,
    fit,
    fit_target,
    fitted_profile,
    identify,
    read_measured,
    record,
)
from ..ruleset import MeasuringRules, load_measuring
from ..soundtrack import open_soundtrack
from ..units import db_from_gain, levels_db
from .bars import Bar, refused
from .sound_files import write_sound
from .stability_filters import analogue_response
from .stability_signals import RATE_HZ

Samples = NDArray[np.float64]

_BAR_DB = 0.5
_LENGTH_S = 6
_BEYOND = 10.0
_HEAD = "frequency_hz,gain_db"
_NO_MEASUREMENTS = {
    "an empty file": "",
    "a head without rows": f"{_HEAD}\n",
    "one frequency": f"{_HEAD}\n100,0\n",
    "the same frequency throughout": "\n".join([_HEAD, *["100,0"] * 20]),
    "frequencies that do not ascend": "\n".join([_HEAD, *(f"{f},0" for f in (20, 40, 80, 60, 120, 240, 480, 960, 99))]),
    "NaN": "\n".join([_HEAD, *(f"{f},{'nan' if f == 80 else 0}" for f in range(20, 400, 20))]),
    "infinity": "\n".join([_HEAD, *(f"{f},{'-inf' if f == 80 else 0}" for f in range(20, 400, 20))]),
    "a gain of 1e30 dB": "\n".join([_HEAD, *(f"{f},{1e30 if f == 80 else 0}" for f in range(20, 400, 20))]),
    "less than an octave": "\n".join([_HEAD, *(f"{f},0" for f in range(100, 190, 5))]),
}


def measurement_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about measurements; writes tables and recordings into the folder."""
    for number, (name, text) in enumerate(_NO_MEASUREMENTS.items()):
        path = folder / f"none-{number}.csv"
        path.write_text(text, encoding="utf-8")
        yield refused(f"measurement: {name}", partial(read_measured, path))
    yield from _fitted_rows(folder)
    yield from _recorded_rows(folder)


def _fitted_rows(folder: Path) -> Iterator[Bar]:
    """Yield what becomes of tables: one that is easy, and those whose plain inverse would be unstable or unbounded."""
    frequencies_hz = np.geomspace(5.0, 1500.0, 150)
    seat = levels_db(np.abs(_seat().at(frequencies_hz)))
    notched = seat - 120.0 * np.exp(-((np.log2(frequencies_hz / 150.0) / 0.05) ** 2))
    noise = np.random.default_rng(8).uniform(-20.0, 20.0, len(frequencies_hz))
    # the levels of a resonance that grows are those of one that decays: the phase alone would tell
    growing = dsp.Analogue(np.zeros(1, np.complex128), np.array([100.0 + 1800.0j, 100.0 - 1800.0j]), 1e3)
    tables = {
        "a seat": seat,
        "a notch of 120 dB": notched,
        "levels at random within 40 dB": noise,
        "a resonance that grows": levels_db(np.abs(growing.at(frequencies_hz))),
        "nothing but the same gain": np.zeros(len(frequencies_hz)),
    }
    for name, levels in tables.items():
        fitted = _fitted_table(folder / "table.csv", frequencies_hz, levels)
        if name in ("a seat", "a resonance that grows"):
            yield Bar(f"{name}, fitted: largest error", _error_db(fitted, frequencies_hz, levels), _BAR_DB, "dB")
        yield from _bound_rows(name, fitted)


def _fitted_table(path: Path, frequencies_hz: Samples, levels: Samples) -> FittedResponse:
    rows = (f"{frequency:.9g},{level:.9g}" for frequency, level in zip(frequencies_hz, levels, strict=True))
    path.write_text("\n".join([_HEAD, *rows]) + "\n", encoding="utf-8")
    rules = load_measuring().fit
    return fit(fit_target(read_measured(path), None, rules=rules, name=path.name), rules=rules, name=path.name)


def _bound_rows(name: str, fitted: FittedResponse) -> Iterator[Bar]:
    """Yield whether a fitted response and its inverse decay, and by how much the compensator gains at most."""
    rules = load_measuring().fit
    profile = fitted_profile(fitted, name="study", source="study", origin="study", rules=rules)
    felt = dsp.felt_response(profile)
    slowest = max(float(root.real) for root in (*felt.poles, *felt.zeros))
    yield Bar(f"{name}: real part of the slowest pole or zero", slowest, -1.0, "rad/s")
    low_hz, high_hz = fitted.target.band_hz
    wide = np.geomspace(low_hz / _BEYOND, high_hz * _BEYOND, 400)
    inside = np.geomspace(low_hz, high_hz, 400)
    gain = max(float(abs(value)) for value in analogue_response(dsp.compensator(profile), wide))
    gain *= max(float(abs(value)) for value in analogue_response(felt, inside))
    yield Bar(f"{name}: gain of the compensator", db_from_gain(gain), rules.largest_gain_db + 1.0, "dB")


def _recorded_rows(folder: Path) -> Iterator[Bar]:
    """Yield an actuator found from recordings, with NaN in one of them as well, and recordings that tell of none."""
    random, rules = np.random.default_rng(9), load_measuring()
    sent = random.normal(0.0, 0.1, _LENGTH_S * RATE_HZ)
    frequencies_hz = np.asarray(np.fft.rfftfreq(len(sent), 1.0 / RATE_HZ), dtype=np.float64)
    came = np.asarray(np.fft.irfft(np.fft.rfft(sent) * _seat().at(frequencies_hz), len(sent)), dtype=np.float64)
    broken = came.copy()
    broken[100_000:100_003] = np.nan
    inside = np.geomspace(20.0, 1000.0, 200)
    for name, response in (("recorded", came), ("recorded with NaN", broken)):
        target = _identified(folder / f"{name}.wav", sent, response, rules)
        fitted = fit(target, rules=rules.fit, name=name)
        error_db = _error_db(fitted, inside, levels_db(np.abs(_seat().at(inside))))
        yield Bar(f"a seat, {name} and fitted: largest error", error_db, _BAR_DB, "dB")
    tone = 0.1 * np.sin(2.0 * np.pi * 100.0 / RATE_HZ * np.arange(len(sent)))
    unknown: dict[str, tuple[Samples, Samples]] = {
        "silence was sent": (np.zeros(len(sent)), came),
        "silence came": (sent, np.zeros(len(sent))),
        "other noise came": (sent, random.normal(0.0, 0.1, len(sent))),
        "a single tone was sent": (tone, tone),
        "too short": (sent[: 2 * RATE_HZ], came[: 2 * RATE_HZ]),
    }
    for name, (one, other) in unknown.items():
        yield refused(f"recordings: {name}", partial(_identified, folder / "unknown.wav", one, other, rules))


def _identified(path: Path, sent: Samples, came: Samples, rules: MeasuringRules) -> FitTarget:
    """Return what would be fitted of an excitation and a response, written into two files."""
    other = path.with_name("sent.wav")
    for file, samples in ((other, sent), (path, came)):
        write_sound(file, samples, RATE_HZ, subtype="FLOAT")
    with open_soundtrack(other) as excitation, open_soundtrack(path) as response:
        found = identify(record(other.name, excitation), record(path.name, response), rules=rules.identify)
        return fit_target(found.measured, None, rules=rules.fit, name=path.name)


def _error_db(fitted: FittedResponse, frequencies_hz: Samples, levels: Samples) -> float:
    """Return by how much a fitted model is off at most from 20 to 1000 Hz."""
    inside = (frequencies_hz >= 20.0) & (frequencies_hz <= 1000.0)
    exactly = analogue_response(analogue(fitted.best.model), frequencies_hz[inside])
    found = levels_db(np.array([float(abs(value)) for value in exactly]))
    return float(np.max(np.abs(found - levels[inside])))


def _seat() -> dsp.Analogue:
    """Return a mass on a spring, resonance 292 Hz, above a first-order high-pass at 25 Hz."""
    natural, corner = 2.0 * math.pi * 292.0, 2.0 * math.pi * 25.0
    pole = natural * complex(-0.15, math.sqrt(1.0 - 0.15**2))
    return dsp.Analogue(np.zeros(1, np.complex128), np.array([pole, pole.conjugate(), -corner]), 0.5 * natural**2)
