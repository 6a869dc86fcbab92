"""What is told of a haptic file's precision is what a player makes of it, and no more than was allowed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blastline.export import HAPTIC_FORMATS, HapticTrack
from blastline.export.haptics.curve import Curve
from blastline.export.haptics.track import VibrationSegment
from haptic_films import RATE_HZ, Samples, event, film, played, track_of, write

SAMPLES = RATE_HZ + 480 * np.arange(41)
SCALES_HZ = {"ahap": (65.0, 300.0), "haptic": (30.0, 600.0), "hjif": (0.0, 1.0)}
"""What 0 and 1 of a format's frequency stand for, by docs/formats-haptic.md; HJIF tells Hz."""

every_format = pytest.mark.parametrize("name", tuple(HAPTIC_FORMATS))
either_sign = pytest.mark.parametrize("sign", [1.0, -1.0])


def vibrating(amplitudes: Samples, frequencies_hz: Samples) -> HapticTrack:
    """Return a track whose one segment has the given values 10 ms apart, from rest to rest."""
    track = track_of(film([event(RATE_HZ)], 2 * RATE_HZ), np.ones(2 * RATE_HZ))
    values = amplitudes.copy()
    values[[0, -1]] = 0.0
    return replace(
        track, pulses=(), segments=(VibrationSegment(Curve(SAMPLES, values), Curve(SAMPLES, frequencies_hz)),)
    )


def amplitude_off(track: HapticTrack, folder: Path, name: str) -> float:
    """Return how far what is played of a track of one segment is from its amplitude."""
    [segment] = track.segments
    found = played(track, folder, name).amplitude_at(SAMPLES / RATE_HZ)
    return float(np.max(np.abs(found - segment.amplitude.values)))


STEADY, TONE_HZ = np.full(41, 0.6), np.full(41, 90.0)
BUMPS = np.isin(np.arange(41), [10, 30]).astype(np.float64)
ALLOWED = vibrating(STEADY, TONE_HZ)


@every_format
def test_points_are_left_out_only_within_the_stated_error(tmp_path: Path, name: str) -> None:
    """A vibration near the limit that goes up and down by nearly twice that, as a player has it."""
    error = ALLOWED.amplitude_error
    track = vibrating(np.where(np.arange(41) % 2, 0.97 - 1.8 * error, 0.97), TONE_HZ)
    assert amplitude_off(track, tmp_path, name) <= error + 2e-4


@every_format
@either_sign
def test_the_error_that_is_told_is_that_of_what_is_played(tmp_path: Path, name: str, sign: float) -> None:
    """Dips, or bumps, of nearly the error that is allowed, each too small for a point of its own."""
    track = vibrating(STEADY + sign * 0.9 * ALLOWED.amplitude_error * BUMPS, TONE_HZ)
    off = amplitude_off(track, tmp_path / "played", name)
    assert off > 0.3 * track.amplitude_error
    assert write(track, tmp_path / "told", name).amplitude == pytest.approx(off, rel=0.05, abs=1e-4)


@every_format
@either_sign
def test_the_mistuning_that_is_told_is_that_of_what_is_played(tmp_path: Path, name: str, sign: float) -> None:
    tones_hz = TONE_HZ * (1.0 + sign * 0.9 * ALLOWED.frequency_error * BUMPS)
    track = vibrating(STEADY, tones_hz)
    low_hz, high_hz = SCALES_HZ[name]
    heard = played(track, tmp_path / "played", name).frequency_at(SAMPLES / RATE_HZ)
    off = float(np.max(np.abs((low_hz + (high_hz - low_hz) * heard) / tones_hz - 1.0)))
    assert off > 0.3 * track.frequency_error
    assert write(track, tmp_path / "told", name).frequency == pytest.approx(off, rel=0.05, abs=1e-3)
