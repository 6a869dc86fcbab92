"""Films whose shots tests render, and what their checks say."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from blastline import run
from blastline.model import Timeline
from blastline.run import RenderOptions

Samples = NDArray[np.float64]
RATE_HZ = 48_000


def film(path: Path, onsets: Sequence[int], peaks: Sequence[float], *, decay_s: float = 0.05, seed: int = 1) -> Path:
    """Write blasts with noisy decays, as 24-bit sound."""
    rng = np.random.default_rng(seed)
    samples = 1e-5 * rng.standard_normal(70_000)
    for onset, peak in zip(onsets, peaks, strict=True):
        t = np.arange(min(samples.size - onset, round(0.4 * RATE_HZ))) / RATE_HZ
        blast = (1.0 - t / 0.002) * np.exp(-t / 0.002)
        samples[onset : onset + t.size] += peak * (blast + 0.2 * rng.standard_normal(t.size) * np.exp(-t / decay_s))
    soundfile.write(path, np.clip(samples, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


def rendered(path: Path, onsets: Sequence[int], options: RenderOptions, gains_db: Sequence[float] = ()) -> Timeline:
    """Render shots at given onsets, each as much softer or louder as asked, beside their film."""
    edited = path.with_suffix(".csv")
    rows = zip(onsets, gains_db or [0.0] * len(onsets), strict=True)
    edited.write_text("onset_sample,gain_db\n" + "".join(f"{onset},{gain}\n" for onset, gain in rows))
    return run.render(path, path.parent / "out", replace(options, timeline=edited))


def failures(made: Timeline) -> list[tuple[str, str | None, float | None]]:
    return [(check.name, check.event, check.measured) for check in made.checks if not check.passed]


def with_booms(path: Path, onsets: Sequence[int], boom_hz: float, *, peak: float) -> Path:
    """Put a tone that dies away under each shot of a film, clipped where it is too much."""
    samples, _ = soundfile.read(path)
    for onset in onsets:
        t = np.arange(samples.size - onset) / RATE_HZ
        samples[onset:] += peak * np.sin(2.0 * np.pi * boom_hz * t) * np.exp(-t / 0.1)
    soundfile.write(path, np.clip(samples, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


def pole_of(resonance_hz: float, q: float) -> complex:
    """Return the upper pole of a resonance, in rad/s."""
    return 2.0 * math.pi * resonance_hz * complex(-0.5 / q, math.sqrt(1.0 - 0.25 / q**2))


def seat(
    path: Path,
    resonance_hz: float,
    q: float,
    up_to_hz: float = 1000.0,
    *,
    gain: float | None = None,
    zeros_rad_s: Sequence[float] = (-20.0,),
) -> str:
    """Write the profile of a seat that rings at one frequency, and is felt up to another, and return its name."""
    pole = pole_of(resonance_hz, q)
    path.write_text(
        f"""schema = 1
name = "seat"
source = "a test"
lowpass = {{ source = "where the skin feels", corner_hz = {up_to_hz}, order = 4 }}
highpass = {{ source = "as the built-in one", corner_hz = 5.0, order = 1 }}
[response]
source = "a resonance"
gain = {abs(pole) / q**0.5 if gain is None else gain}
zeros_rad_s = {[[zero, 0.0] for zero in zeros_rad_s]}
poles_rad_s = [[{pole.real}, {pole.imag}], [{pole.real}, {-pole.imag}]]
""",
        encoding="utf-8",
    )
    return str(path)
