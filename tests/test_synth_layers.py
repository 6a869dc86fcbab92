"""The layers of a designed shot: a roar that is held stays up and dulls, a ring has one pitch."""

import numpy as np
from numpy.typing import NDArray

from blastline.synth.designed import hiss
from blastline.synth.layers import body_layer, crack_layer, draw_layers, held_roar, subsonic_swing

RATE_HZ = 48_000


def chances(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def power_in(samples: NDArray[np.float64], low_hz: float, high_hz: float) -> float:
    power = np.square(np.abs(np.fft.rfft(samples)))
    hz = np.fft.rfftfreq(samples.size, 1 / RATE_HZ)
    return float(power[(hz >= low_hz) & (hz < high_hz)].sum() / power.sum())


def loud_ms(samples: NDArray[np.float64]) -> float:
    """Return how long the power over 5 ms stays within 10 dB of its most."""
    power = np.convolve(np.square(samples), np.ones(RATE_HZ // 200), "same")
    return float(np.sum(power > 0.1 * power.max())) * 1000 / RATE_HZ


def test_a_roar_is_held_far_longer_than_a_body_sounds() -> None:
    held = [loud_ms(held_roar(chances(seed), chances(seed), RATE_HZ)) for seed in range(60)]
    bodies = [loud_ms(body_layer(chances(seed), chances(seed), RATE_HZ)) for seed in range(60)]
    assert np.median(held) > 3.0 * np.median(bodies)
    assert max(held) < 800.0


def test_what_is_high_in_a_roar_dies_first() -> None:
    duller = []
    for seed in range(60):
        roar = held_roar(chances(seed), chances(seed), RATE_HZ)
        third = roar.size // 3
        first, last = (power_in(part, 4_000.0, 20_000.0) for part in (roar[:third], roar[-third:]))
        duller.append(last < first)
    assert np.mean(duller) > 0.85


def test_one_crack_in_twelve_rings_at_one_pitch() -> None:
    """Half of the power of what rings lies within an octave and a half around its strongest frequency."""
    ringing = 0
    for seed in range(240):
        crack = crack_layer(chances(seed), chances(seed + 1), RATE_HZ)
        spectrum = np.square(np.abs(np.fft.rfft(crack)))
        pitch_hz = float(np.fft.rfftfreq(crack.size, 1 / RATE_HZ)[spectrum.argmax()])
        ringing += power_in(crack, 0.8 * pitch_hz, 1.25 * pitch_hz) > 0.7
    assert 5 < ringing < 40


def test_a_dry_round_is_a_crack_alone() -> None:
    rounds = [draw_layers(chances(seed), chances(seed + 1), RATE_HZ, dry=1.0) for seed in range(20)]
    assert all(len(layers) == 1 for layers in rounds)
    assert max(loud_ms(layers[0][1]) for layers in rounds) < 100.0
    wet = [len(draw_layers(chances(seed), chances(seed + 1), RATE_HZ, dry=0.0)) for seed in range(40)]
    assert np.mean(wet) > 2.0


def test_a_swing_is_beneath_what_is_heard() -> None:
    for seed in range(20):
        assert power_in(subsonic_swing(chances(seed), RATE_HZ), 0.0, 120.0) > 0.9


def test_a_hiss_has_no_blow() -> None:
    low = [power_in(hiss(chances(seed), RATE_HZ), 0.0, 100.0) for seed in range(40)]
    assert np.median(low) < 0.01
