"""Seats with a slow resonance, as bass shakers have one: the limit must not make them ring with what nobody hears."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.model import Quality
from blastline.run import RenderOptions
from checked_films import RATE_HZ, Samples, failures

SEAT = """
schema = 1
source = "made for a test"
name = "slow"
[response]
source = "15 Hz with a Q of 5: it rings for longer than a window that was cut short"
gain = 4000.0
zeros_rad_s = [[-70.0, 0.0], [-600.0, 0.0]]
poles_rad_s = [[-400.0, 0.0], [-170.0, 0.0], [-9.5, 95.0], [-9.5, -95.0]]
[lowpass]
source = "made for a test"
corner_hz = 1000.0
order = 3
[highpass]
source = "made for a test"
corner_hz = 1.8
order = 2
"""
ONSET, STOP = 20_000, 20_000 + 30 * RATE_HZ // 1000


def unlike(drive: Samples, sound: Samples, core: slice) -> float:
    """Return the energy by which what is felt is not the sound in the band, as a share of that of the sound."""
    size = 2**18
    s = 2j * np.pi * np.fft.rfftfreq(size, 1.0 / RATE_HZ)
    low, high = 2.0 * np.pi * 1000.0, 2.0 * np.pi * 1.8
    band = low**3 / ((s + low) * (s**2 + low * s + low**2)) * s**2 / (s**2 + np.sqrt(2.0) * high * s + high**2)
    seat = 4000.0 * (s + 70.0) * (s + 600.0) / ((s + 400.0) * (s + 170.0) * ((s + 9.5) ** 2 + 95.0**2))
    felt = np.fft.irfft(seat * np.fft.rfft(drive, size))[core]
    wanted = np.fft.irfft(band * np.fft.rfft(sound, size))[core]
    return float(np.sum((felt - wanted) ** 2) / np.sum(wanted**2))


@pytest.mark.parametrize("quality", ["draft", "standard"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_solved_drive_is_felt_more_like_the_sound_than_rest_and_than_the_sound_itself(
    tmp_path: Path, quality: Quality, seed: int
) -> None:
    """The clipped compensator makes such a seat ring at 15 Hz: a drive that may ring on like that was felt so."""
    seat, path = tmp_path / "seat.toml", tmp_path / "film.wav"
    seat.write_text(SEAT)
    soundfile.write(path, 1e-3 * np.random.default_rng(seed).standard_normal(70_000), RATE_HZ, subtype="PCM_24")
    path.with_suffix(".csv").write_text(f"onset_sample,window_stop_sample\n{ONSET},{STOP}\n")
    options = RenderOptions(report=False, drive="constrained", quality=quality, actuator=str(seat))
    made = run.render(path, tmp_path / "out", replace(options, timeline=path.with_suffix(".csv")))
    assert failures(made) == []
    drive, sound = (soundfile.read(file)[0] for file in (tmp_path / "out" / "drive.wav", path))
    (event,) = made.events
    core = slice(ONSET, event.window.stop - event.window.fade_out_samples)
    itself = np.zeros(len(sound))
    itself[core] = sound[core]
    assert unlike(drive, sound, core) < 0.2
    assert unlike(itself, sound, core) > 0.9
