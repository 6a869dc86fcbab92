"""Rows about signals: a filter is linear, so that a power of two comes out as exactly that power of two."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Clip, DriveModel, Shot, Span
from ..render import DriveFilters, RenderedWindow, drive_filters, hear_window, plan_windows, render_window
from ..ruleset import DEFAULT_ACTUATOR, load_actuator, load_rules
from .bars import Bar, exact
from .stability_filters import sections_response

RATE_HZ = 48_000
MODELS: tuple[DriveModel, ...] = ("direct", "filter", "constrained")
_ONSET, _FRAMES = 14_400, 24_000

Samples = NDArray[np.float64]


def signal_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about signals; needs no files."""
    profile, _ = load_actuator(DEFAULT_ACTUATOR)
    filters = drive_filters(profile, RATE_HZ, "causal")
    yield from _scale_rows(filters)
    yield from _denormal_rows(filters)
    yield from _drive_rows(filters)
    yield from _impulse_rows(filters)
    (at_dc,) = sections_response(filters.compensator, np.zeros(1), RATE_HZ)
    yield Bar("compensator's gain at DC", float(abs(at_dc)), 1e-9)
    constant = dsp.run_filter(filters.compensator, np.ones(3 * RATE_HZ))
    yield Bar("compensator after 3 s of full-scale DC", float(np.max(np.abs(constant[-100:]))), 1e-9)
    yield from _offset_rows(filters)


def shot_film(*, frames: int = _FRAMES, onset: int = _ONSET, scale: float = 1.0, rate_hz: int = RATE_HZ) -> Samples:
    """Return a blast with its tail in digital silence, shape (frames,)."""
    since_s = np.arange(max(frames - onset, 0)) / rate_hz
    tail = np.random.default_rng(1).standard_normal(len(since_s)) * np.exp(-since_s / 0.05)
    blast = (1.0 - since_s / 1e-3) * np.exp(-since_s / 1e-3)
    film = np.zeros(frames)
    film[onset:] = scale * (0.8 * blast + 0.1 * tail)
    return film


def shot_at(onset: int, length: int) -> Shot:
    """Return a shot that begins at a sample and has decayed after so many."""
    span = Span(onset, onset + length)
    return Shot(onset=onset, confidence=1.0, peak_dbfs=0.0, snr_db=60.0, blast=span, reflections=(), span=span)


def drive_of(
    film: NDArray[np.floating], onset: int, model: DriveModel, filters: DriveFilters, *, length: int = 4_800
) -> Samples:
    """Return the drive of a film's only shot, over the whole film; 0 outside its window."""
    tier = load_rules("standard").tier
    shot = shot_at(onset, length)
    (planned,) = plan_windows([shot], frames=len(film), rate_hz=filters.rate_hz, rules=tier.windows)
    done: RenderedWindow = render_window(
        hear_window(Clip(film[:, None], filters.rate_hz), planned, filters=filters, rules=tier.render),
        [shot],
        model=model,
        reason="study",
        background="mute",
    )
    drive = np.zeros(len(film))
    drive[done.clip.start : done.clip.span.stop] = done.clip.driving
    return drive


def _offset_rows(filters: DriveFilters) -> Iterator[Bar]:
    """Yield what a constant under a film changes of its drive, later in it than the filters take to settle."""
    film = shot_film(frames=2 * RATE_HZ, onset=RATE_HZ, scale=0.1)
    for model in ("filter", "constrained"):
        off, plain = (drive_of(each, RATE_HZ, model, filters) for each in (film + 0.9, film))
        yield Bar(f"{model} drive over 0.9 of DC beside the one over none", float(np.max(np.abs(off - plain))), 1e-9)


def _scale_rows(filters: DriveFilters) -> Iterator[Bar]:
    film = np.random.default_rng(2).uniform(-1.0, 1.0, RATE_HZ // 2)
    for name, sections in (("compensator", filters.compensator), ("felt", filters.felt), ("band", filters.band)):
        once = dsp.run_filter(sections, film)
        for power, amplitude in ((-100, "1e-30"), (100, "1e30")):
            scaled = dsp.run_filter(sections, np.ldexp(film, power))
            yield exact(f"{name} at {amplitude}: bits that differ", np.count_nonzero(scaled != np.ldexp(once, power)))


def _denormal_rows(filters: DriveFilters) -> Iterator[Bar]:
    """Yield what denormal input and a filter left to itself cost against noise, and that both end in silence."""
    noise = np.random.default_rng(3).uniform(-1.0, 1.0, 10 * RATE_HZ)
    ringing = np.zeros(len(noise))
    ringing[0] = 1.0
    for name, sections in (("compensator", filters.compensator), ("felt", filters.felt)):
        usual = _seconds(sections, noise)
        for kind, samples in (("denormal input", noise * 1e-310), ("10 s of silence after an impulse", ringing)):
            yield Bar(f"{name}, {kind}: time against noise", _seconds(sections, samples) / usual, 2.0)
        yield exact(f"{name} on denormals: not silent", np.count_nonzero(dsp.run_filter(sections, noise * 1e-310)))
    left = dsp.run_filter(filters.felt, ringing)[-RATE_HZ:]
    yield exact("felt, 9 s after an impulse: not silent", np.count_nonzero(left))


def _seconds(sections: Samples, samples: Samples) -> float:
    """Return the least processor time of three."""
    costs = []
    for _ in range(3):
        start = time.process_time()
        dsp.run_filter(sections, samples)
        costs.append(time.process_time() - start)
    return max(min(costs), 1e-6)


def _drive_rows(filters: DriveFilters) -> Iterator[Bar]:
    square = np.where(np.arange(_FRAMES) // 40 % 2 == 0, 1.0, -1.0)
    cases = {
        "1e-30": shot_film(scale=1e-30),
        "1e30": shot_film(scale=1e30),
        "a denormal": shot_film(scale=1e-310),
        "full-scale square": square,
        "DC": np.ones(_FRAMES),
    }
    for model in MODELS:
        for name, film in cases.items():
            drive = drive_of(film, _ONSET, model, filters)
            peak = float(np.max(np.abs(drive))) if np.all(np.isfinite(drive)) else np.inf
            yield Bar(f"{model} drive, {name}: peak", peak, 1.0, "of the limit")
        silent = drive_of(np.zeros(_FRAMES), _ONSET, model, filters)
        yield exact(f"{model} drive of digital silence: not zero", np.count_nonzero(silent))


def _impulse_rows(filters: DriveFilters) -> Iterator[Bar]:
    frames = 5_000
    first, last = np.zeros(frames), np.zeros(frames)
    first[0] = last[-1] = 1.0
    early, late = (dsp.run_filter(filters.compensator, film) for film in (first, last))
    wrong = np.count_nonzero(late[:-1]) + int(late[-1] != early[0])
    yield exact("impulse at the last frame: not the first sample of its response", wrong)
    response = dsp.run_filter(filters.felt, first)[: len(filters.impulse)]
    wrong = np.count_nonzero(response != filters.impulse[:frames])
    yield exact("impulse at frame 0: not the impulse response", wrong)
    for model in MODELS:
        for name, onset in (("frame 0", 0), ("the last frame", frames - 1)):
            film = np.zeros(frames)
            film[onset] = 1.0
            drive = drive_of(film, onset, model, filters)
            early_drive = np.flatnonzero(drive)[:1]
            lead = onset - int(early_drive[0]) if len(early_drive) else -1
            yield Bar(f"{model} drive, impulse at {name}: starts early by", lead, 48.0, "samples")
            peak = float(np.max(np.abs(drive)))
            yield Bar(f"{model} drive, impulse at {name}: peak", peak, 0.01, "of the limit", "above")
