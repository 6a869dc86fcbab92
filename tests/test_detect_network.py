"""Spectrograms and the networks that judge them: against independent transforms, and PyTorch where it is there."""

from fractions import Fraction
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import resample_poly

from blastline.detect.contrast import CONTRASTS, Contrasts, contrasts
from blastline.detect.network import (
    FEATURE_LIMIT,
    Layer,
    LayerFile,
    Network,
    NetworkFile,
    is_compatible,
    network_from,
    network_log_odds,
)
from blastline.detect.spectrogram import ATTACK, HIGHEST_DB, LOWEST_DB, NEAR, WIDE, Spectrograms, spectrograms

RATE_HZ = 48_000


def bang(rate_hz: int, at_s: float = 1.0, seconds: float = 2.0) -> NDArray[np.float32]:
    """Return a decaying burst of tones from 100 Hz to 7 kHz over faint ones: the same sound at every rate."""
    time = np.arange(round(seconds * rate_hz)) / rate_hz - at_s
    rng = np.random.default_rng(5)
    hz, phase = np.geomspace(100.0, 7_000.0, 60), rng.uniform(0.0, 6.28, 60)
    tones = np.sin(2.0 * np.pi * hz[:, None] * time + phase[:, None]).sum(axis=0) / 60.0
    return np.asarray(tones * (1e-3 + np.where(time >= 0.0, np.exp(-time / 0.05), 0.0)), np.float32)


def test_gain_changes_no_spectrogram_and_a_delay_moves_it() -> None:
    noise = 4e-3 * np.random.default_rng(6).standard_normal(2 * RATE_HZ)
    samples, onset = (bang(RATE_HZ) + noise).astype(np.float32), np.array([RATE_HZ])
    plain = spectrograms(samples, onset, RATE_HZ)
    for gain in (-1.0, 4.0, 0.5):
        louder = spectrograms(np.asarray(gain * samples, np.float32), onset, RATE_HZ)
        for one, two in ((louder.near, plain.near), (louder.wide, plain.wide)):  # down to where 16 bits end
            np.testing.assert_allclose(np.maximum(one, -45.0), np.maximum(two, -45.0), atol=0.1)
    later = spectrograms(np.concatenate([np.zeros(1_234, np.float32), samples]), onset + 1_234, RATE_HZ)
    assert np.array_equal(later.near, plain.near)
    assert np.array_equal(later.wide, plain.wide)


def test_a_faint_film_has_the_spectrograms_of_a_loud_one_down_to_silence() -> None:
    samples, onset = bang(RATE_HZ), np.array([RATE_HZ])
    plain = spectrograms(samples, onset, RATE_HZ)
    faint = spectrograms(np.float32(1e-2) * samples, onset, RATE_HZ, np.array([1e-2], np.float32))
    for one, two in ((faint.near, plain.near), (faint.wide, plain.wide)):
        np.testing.assert_allclose(one, two, atol=1e-3)


def test_a_frame_is_the_power_of_its_bands_against_the_attack() -> None:
    samples, onset = bang(RATE_HZ).astype(np.float64), RATE_HZ
    shown = spectrograms(samples.astype(np.float32), np.array([onset]), RATE_HZ)
    edges = np.geomspace(NEAR.low_hz, NEAR.high_hz, NEAR.bands + 2)

    def level_db(frame: int, band: int) -> float:
        start = onset + round((NEAR.start_ms + frame * NEAR.hop_ms) * 48)
        window = np.hanning(194)[1:-1]
        part = samples[start : start + 192]
        part = (part - np.average(part, weights=window)) * window
        hz = np.arange(129) * RATE_HZ / 256
        power = np.abs(np.exp(-2j * np.pi * hz[:, None] * np.arange(192) / RATE_HZ) @ part) ** 2
        weights = np.interp(hz, edges[band : band + 3], [0.0, 1.0, 0.0], left=0.0, right=0.0)
        return float(10.0 * np.log10(weights @ power / weights.sum()))

    expected = level_db(15, 14) - level_db(9, 12)
    assert shown.near[0, 15, 14] - shown.near[0, 9, 12] == pytest.approx(expected, abs=0.01)
    noise = 0.05 * np.random.default_rng(7).standard_normal(samples.size)  # so that no level is clipped
    full = spectrograms((samples + noise).astype(np.float32), np.array([onset]), RATE_HZ)
    assert full.near[0, ATTACK].mean(axis=1).max() == pytest.approx(0.0, abs=1e-3)


def test_a_constant_changes_no_spectrogram() -> None:
    noise = 4e-3 * np.random.default_rng(6).standard_normal(2 * RATE_HZ)
    samples = (bang(RATE_HZ) + noise).astype(np.float32)
    for onset in (RATE_HZ, 100, 2 * RATE_HZ - 100):  # in the middle, and where spectrograms reach beyond the ends
        plain, shifted = (
            spectrograms(each, np.array([onset]), RATE_HZ) for each in (samples, samples + np.float32(0.1))
        )
        np.testing.assert_allclose(plain.near, shifted.near, atol=0.1)
        np.testing.assert_allclose(plain.wide, shifted.wide, atol=0.1)


@pytest.mark.parametrize("rate_hz", [44_100, 96_000, 22_050])
def test_another_rate_gives_nearly_the_same_spectrogram(rate_hz: int) -> None:
    here = spectrograms(bang(RATE_HZ), np.array([RATE_HZ]), RATE_HZ)
    there = spectrograms(bang(rate_hz), np.array([rate_hz]), rate_hz)
    edges = np.geomspace(WIDE.low_hz, WIDE.high_hz, WIDE.bands + 2)
    audible = (edges[1:-1] > 300.0) & (edges[1:-1] < 5_000.0)
    attack = slice(14, 29)
    level = [each.wide[0, attack][:, audible] - each.wide[0, attack][:, audible].max() for each in (here, there)]
    assert np.median(np.abs(level[0] - level[1])) < 1.0


@pytest.mark.parametrize("rate_hz", [44_100, 96_000, 32_000])
def test_low_bands_hear_the_same_at_every_rate(rate_hz: int) -> None:
    noise = (0.02 * np.random.default_rng(8).standard_normal(2 * RATE_HZ)).astype(np.float64)
    onsets = np.arange(20_000, 80_000, 1_000)
    up, down = Fraction(rate_hz, RATE_HZ).as_integer_ratio()
    there = resample_poly(noise, up, down, window=("kaiser", 12.0)).astype(np.float32)
    shown = [
        spectrograms(samples, np.round(onsets * rate / RATE_HZ).astype(np.intp), rate).wide[:, :, :12]
        for samples, rate in ((noise.astype(np.float32), RATE_HZ), (there, rate_hz))
    ]
    levels = [each - each.mean(axis=(1, 2), keepdims=True) for each in shown]
    apart = np.sqrt(np.mean(np.square(levels[0] - levels[1]), axis=(0, 1)))
    assert apart.max() < 2.0  # another bin would be 7 dB off


def test_silence_and_the_ends_of_a_film_are_numbers() -> None:
    for samples in (np.zeros(100, np.float32), bang(RATE_HZ)[RATE_HZ : RATE_HZ + 50]):
        shown = spectrograms(samples, np.array([0, 10, samples.size - 1]), RATE_HZ)
        for spectrogram, layout in ((shown.near, NEAR), (shown.wide, WIDE)):
            assert spectrogram.shape == (3, layout.frames, layout.bands)
            assert LOWEST_DB <= spectrogram.min() <= spectrogram.max() <= HIGHEST_DB
    nothing = spectrograms(np.zeros(10, np.float32), np.zeros(0, np.intp), RATE_HZ)
    assert nothing.near.shape == (0, NEAR.frames, NEAR.bands)


def random_network(rng: np.random.Generator, features: int) -> Network:
    def convolutions(strides: tuple[int, ...]) -> tuple[Layer, ...]:
        channels = (CONTRASTS, 3, 4)
        return tuple(
            Layer(
                stride,
                rng.standard_normal((9 * channels[n], channels[n + 1])).astype(np.float32),
                rng.standard_normal(channels[n + 1]).astype(np.float32),
            )
            for n, stride in enumerate(strides)
        )

    values = 4 * (6 * 5 + 12 * 8) + features
    head = tuple(
        Layer(0, rng.standard_normal(shape).astype(np.float32) / 10.0, rng.standard_normal(shape[1]).astype(np.float32))
        for shape in ((values, 7), (7, 1))
    )
    means, spreads = rng.standard_normal(features), rng.uniform(0.5, 2.0, features)
    return Network(means, spreads, convolutions((2, 2)), convolutions((2, 2)), head)


def random_file(features: int) -> NetworkFile:
    def layer(stride: int, inputs: int, outputs: int) -> LayerFile:
        return LayerFile(stride, [[0.1] * outputs for _ in range(inputs)], [0.0] * outputs)

    convolutions = [layer(2, 9 * CONTRASTS, 3), layer(2, 27, 4)]
    values = 4 * (6 * 5 + 12 * 8) + features
    return NetworkFile(
        [0.0] * features, [1.0] * features, convolutions, convolutions, [layer(0, values, 7), layer(0, 7, 1)]
    )


def by_scipy(network: Network, rows: NDArray[np.float64], shown: Contrasts) -> list[float]:
    """Return the odds, worked out one candidate and one channel at a time."""
    from scipy.signal import correlate2d

    odds = []
    for index in range(rows.shape[0]):
        parts = []
        for spectrogram, layers in ((shown.near, network.near), (shown.wide, network.wide)):
            maps = list(np.moveaxis(spectrogram[index].astype(np.float64), -1, 0))
            for layer in layers:
                kernels = layer.weights.astype(np.float64).reshape(3, 3, len(maps), -1)
                maps = [
                    np.maximum(
                        sum(correlate2d(m, kernels[:, :, c, out], "same") for c, m in enumerate(maps))[
                            :: layer.stride, :: layer.stride
                        ]
                        + layer.biases[out],
                        0.0,
                    )
                    for out in range(kernels.shape[3])
                ]
            parts.append(np.stack(maps, axis=-1).ravel())
        known = np.clip((rows[index] - network.means) / network.spreads, -FEATURE_LIMIT, FEATURE_LIMIT)
        values = np.concatenate([*parts, known])
        for layer in network.head[:-1]:
            values = np.maximum(values @ layer.weights + layer.biases, 0.0)
        odds.append(float((values @ network.head[-1].weights + network.head[-1].biases)[0]))
    return odds


def some_contrasts(rng: np.random.Generator, count: int) -> Contrasts:
    near, wide = (rng.uniform(LOWEST_DB, HIGHEST_DB, (count, r.frames, r.bands)) for r in (NEAR, WIDE))
    return contrasts(Spectrograms(near.astype(np.float32), wide.astype(np.float32)))


def test_a_network_is_its_correlations_and_products() -> None:
    rng = np.random.default_rng(8)
    network, rows, shown = random_network(rng, 5), rng.standard_normal((4, 5)), some_contrasts(rng, 4)
    np.testing.assert_allclose(
        network_log_odds(network, rows, shown), by_scipy(network, rows, shown), rtol=2e-4, atol=2e-4
    )


def test_a_network_for_other_spectrograms_or_features_does_not_fit() -> None:
    network = random_file(5)
    assert is_compatible(network, 5)
    assert not is_compatible(network, 6)
    broken_parts: tuple[dict[str, Any], ...] = (
        {"wide": network.wide[:1]},
        {"near": []},
        {"head": network.head[:1]},
        {"spreads": network.spreads[:1]},
        {"near": [msgspec.structs.replace(network.near[0], stride=0), *network.near[1:]]},
        {"head": [msgspec.structs.replace(network.head[0], biases=[0.0]), *network.head[1:]]},
    )
    for broken in broken_parts:
        assert not is_compatible(msgspec.structs.replace(network, **broken), 5)


def test_candidates_are_judged_one_by_one() -> None:
    rng = np.random.default_rng(9)
    network, rows, shown = random_network(rng, 5), rng.standard_normal((6, 5)), some_contrasts(rng, 6)
    together = network_log_odds(network, rows, shown)
    alone = [
        network_log_odds(network, rows[n : n + 1], Contrasts(shown.near[n : n + 1], shown.wide[n : n + 1]))[0]
        for n in range(6)
    ]
    np.testing.assert_allclose(together, alone, rtol=1e-4, atol=1e-4)
    assert network_log_odds(network, rows[:0], Contrasts(shown.near[:0], shown.wide[:0])).shape == (0,)


@pytest.mark.parametrize("size", ["small", "large"])
def test_the_runtime_judges_as_pytorch_does(size: str) -> None:
    torch = pytest.importorskip("torch")
    from blastline.study.networks import SIZES, exported, new_network

    torch.manual_seed(1)
    network = new_network(5, 0.3, SIZES[size])
    rng = np.random.default_rng(4)
    shown, rows = some_contrasts(rng, 32), rng.standard_normal((32, 5))
    seen = [torch.from_numpy(each).permute(0, 3, 1, 2) for each in (shown.near, shown.wide)]
    known = torch.from_numpy(rows.astype(np.float32))
    network.parts().train()
    for _ in range(3):  # so that the running means are not what they start from
        network.log_odds(seen[0], seen[1], known)
    network.parts().eval()
    with torch.no_grad():
        theirs = network.log_odds(seen[0], seen[1], known).numpy()
    ours = network_log_odds(network_from(exported(network, np.zeros(5), np.ones(5))), rows, shown)
    np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-3)


def test_a_network_file_is_wired_as_written() -> None:
    layer = LayerFile(0, [[1.0, 2.0], [3.0, 4.0]], [0.5, -0.5])
    network = network_from(NetworkFile([1.0], [2.0], [], [], [layer]))
    assert network.head[0].weights.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert network.head[0].biases.tolist() == [0.5, -0.5]
