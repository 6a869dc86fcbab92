"""What each mix takes from which channel."""

from collections.abc import Sequence

import numpy as np
import pytest

from blastline.errors import SoundtrackError
from blastline.soundtrack.loudspeakers import azimuths
from blastline.soundtrack.mix import (
    LFE_GAIN,
    as_front,
    centre_of,
    is_identity,
    mix_matrix,
    mixed,
    names_of,
    sides_matrix,
    summing_order,
)

SIDE_5_1 = ("FL", "FR", "FC", "LFE", "SL", "SR")
FILM_5_1 = ("FL", "FC", "FR", "SL", "SR", "LFE")


def test_mains_of_5_1_are_the_weights_of_bs_775() -> None:
    expected = [0.5**0.5, 0.5**0.5, 1.0, 0.0, 0.5, 0.5]
    np.testing.assert_allclose(mix_matrix(SIDE_5_1, 6, "mains")[:, 0], expected, rtol=1e-7)
    np.testing.assert_allclose(mix_matrix(None, 6, "mains")[:, 0], expected, rtol=1e-7)


def test_weights_follow_the_names_and_not_the_places() -> None:
    by_name = dict(zip(SIDE_5_1, mix_matrix(SIDE_5_1, 6, "all"), strict=True))
    for name, weights in zip(FILM_5_1, mix_matrix(FILM_5_1, 6, "all"), strict=True):
        np.testing.assert_array_equal(weights, by_name[name])


@pytest.mark.parametrize(("channels", "low"), [(6, 3), (7, 3), (8, 3)])
def test_the_low_channel_drives_and_is_not_heard(channels: int, low: int) -> None:
    mains = mix_matrix(None, channels, "mains")[:, 0]
    for mix, driving_mains in (("lfe", 0.0), ("all", 1.0)):
        matrix = mix_matrix(None, channels, mix)
        np.testing.assert_array_equal(matrix[:, 0], mains)
        expected = driving_mains * mains
        expected[low] = LFE_GAIN
        np.testing.assert_array_equal(matrix[:, 1], expected)
    assert pytest.approx(10.0, abs=1e-9) == 20.0 * np.log10(LFE_GAIN)


def test_without_a_low_channel_all_is_the_mains() -> None:
    np.testing.assert_array_equal(mix_matrix(None, 2, "all"), mix_matrix(None, 2, "mains"))


def test_three_channels_are_heard_as_asked_for_with_their_centre_and_without() -> None:
    heard, sides = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 1000)).astype(np.float32)
    front = as_front(heard, sides)
    (mains,) = mixed(front, mix_matrix(None, 3, "mains")).T
    matrix = sides_matrix(None, 3, "mains")
    assert matrix is not None
    np.testing.assert_allclose(mains, heard, atol=1e-6)
    np.testing.assert_allclose(mixed(front, matrix)[:, 0], sides, atol=1e-6)


@pytest.mark.parametrize(
    ("layout", "without"),
    [
        (("FL", "FR", "FC"), {"FC"}),
        (("FL", "FR", "FC", "LFE", "SL", "SR"), {"FC"}),
        (("FL", "FR", "FC", "BL", "BR", "DL", "DR"), {"FC"}),
    ],
)
def test_sides_are_the_mains_without_the_centre(layout: tuple[str, ...], without: set[str]) -> None:
    expected = mix_matrix(layout, len(layout), "mains").copy()
    expected[[layout.index(name) for name in without]] = 0.0
    matrix = sides_matrix(layout, len(layout), "mains")
    assert matrix is not None
    np.testing.assert_array_equal(matrix, expected)
    assert centre_of(layout, len(layout)) == layout.index("FC")


@pytest.mark.parametrize("layout", [("FL", "FR"), ("FL", "FR", "LFE"), None])
def test_what_a_pair_plays_against_each_other_is_its_sides_and_nothing_else(layout: tuple[str, ...] | None) -> None:
    count = len(layout) if layout else 2
    matrix = sides_matrix(layout, count, "mains")
    assert matrix is not None
    assert centre_of(layout, count) is None
    there = np.random.default_rng(4).uniform(-1, 1, 1000).astype(np.float32)
    low = [np.ones_like(there)] * (count - 2)
    np.testing.assert_array_equal(mixed(np.stack([there, -there, *low], axis=1), matrix)[:, 0], there)
    assert not mixed(np.stack([there, there, *low], axis=1), matrix).any()


@pytest.mark.parametrize(
    ("layout", "mix"),
    [(("FC",), "mains"), (("FL", "FR", "BL", "BR"), "mains"), (("FL", "FR"), "0,1"), (("FL", "FR", "FC"), "center")],
)
def test_others_have_no_sides(layout: tuple[str, ...], mix: str) -> None:
    assert sides_matrix(layout, len(layout), mix) is None


@pytest.mark.parametrize("layout", [("FL", "FR"), ("FL", "FR", "LFE")])
def test_a_pair_with_equal_channels_is_mono_to_the_bit(layout: Sequence[str]) -> None:
    mono = np.random.default_rng(1).uniform(-1, 1, 5000).astype(np.float32)
    pair = np.stack([mono] * len(layout), axis=1)
    np.testing.assert_array_equal(mixed(pair, mix_matrix(layout, len(layout), "mains"))[:, 0], mono)


def test_mono_is_taken_as_it_is() -> None:
    for mix in ("mains", "center", "all", "0"):
        assert is_identity(mix_matrix(None, 1, mix))
    samples = np.ones((3, 1), np.float32)
    assert mixed(samples, mix_matrix(None, 1, "mains")) is samples


def test_every_mix_is_the_matrix_product_whatever_the_block() -> None:
    samples = np.random.default_rng(2).uniform(-1, 1, (1000, 8)).astype(np.float32)
    for mix in ("mains", "lfe", "all", "center", "0,7,3"):
        matrix = mix_matrix(None, 8, mix)
        whole = mixed(samples, matrix)
        np.testing.assert_allclose(whole, samples.astype(np.float64) @ matrix.astype(np.float64), atol=1e-6)
        for size in (1, 7, 64):
            blocks = [mixed(samples[start : start + size], matrix) for start in range(0, 1000, size)]
            np.testing.assert_array_equal(np.concatenate(blocks), whole)


def test_channels_in_another_order_are_the_same_sound_to_the_bit() -> None:
    samples = np.random.default_rng(3).uniform(-1, 1, (1000, 8)).astype(np.float32)
    layout = names_of(None, 8)
    usual = mixed(samples, mix_matrix(layout, 8, "all"), summing_order(layout, 8))
    for shuffled in (np.arange(8)[::-1], np.random.default_rng(4).permutation(8)):
        names = [layout[channel] for channel in shuffled]
        again = mixed(samples[:, shuffled], mix_matrix(names, 8, "all"), summing_order(names, 8))
        np.testing.assert_array_equal(again, usual)


@pytest.mark.parametrize("layout", ["mono", "stereo", "3.0", "quad", "5.0", "5.1", "6.1", "7.1"])
def test_the_usual_order_is_that_of_ffmpeg(layout: str) -> None:
    from av import AudioLayout

    names = tuple(channel.name for channel in AudioLayout(layout).channels)
    assert names_of(None, len(names)) == names


def test_numbered_channels_are_averaged_whatever_the_layout() -> None:
    np.testing.assert_array_equal(mix_matrix(None, 12, "11, 0")[[0, 11], 0], [0.5, 0.5])
    np.testing.assert_array_equal(mix_matrix(("FL", "FR"), 2, "1")[:, 0], [0.0, 1.0])


def test_a_stereo_version_beside_the_film_is_not_mixed_in() -> None:
    matrix = mix_matrix(("FL", "FR", "FC", "DL", "DR"), 5, "mains")
    np.testing.assert_array_equal(matrix[3:, 0], [0.0, 0.0])


@pytest.mark.parametrize(
    ("total", "plain"), [(("DL", "DR"), ("FL", "FR")), (("DR", "DL"), ("FR", "FL")), (("DL",), ("FL",))]
)
def test_a_stereo_version_alone_is_the_film(total: Sequence[str], plain: Sequence[str]) -> None:
    channels = len(total)
    assert names_of(total, channels) == plain
    for mix in ("mains", "all"):
        np.testing.assert_array_equal(mix_matrix(total, channels, mix), mix_matrix(plain, channels, mix))
    np.testing.assert_equal(sides_matrix(total, channels, "mains"), sides_matrix(plain, channels, "mains"))
    assert summing_order(total, channels) == summing_order(plain, channels)
    assert azimuths(total, channels) == azimuths(plain, channels)


@pytest.mark.parametrize(
    ("layout", "channels", "mix", "message"),
    [
        (None, 2, "2", "no channel 2; the sound has 2 channels"),
        (None, 1, "0,1", "no channel 1; the sound has 1 channel,"),
        (None, 2, "-1", "expected mains, lfe, center, all"),
        (None, 2, "loud", "expected mains, lfe, center, all"),
        (None, 2, "", "expected mains, lfe, center, all"),
        (None, 2, "0,,1", "expected mains, lfe, center, all"),
        (None, 2, "²", "expected mains, lfe, center, all"),
        (None, 2, "center", "no FC channel among FL, FR"),
        (None, 2, "lfe", "no LFE channel among FL, FR"),
        (None, 12, "mains", "does not say what its 12 channels are"),
        (None, 2, "0,0", "names channel 0 twice"),
        (None, 3, "2,0,1, 02", "names channel 2 twice"),
        (("LFE",), 1, "mains", "no main channel"),
    ],
)
def test_a_mix_that_the_file_does_not_have_is_refused(
    layout: Sequence[str] | None, channels: int, mix: str, message: str
) -> None:
    with pytest.raises(SoundtrackError, match=message):
        mix_matrix(layout, channels, mix)
