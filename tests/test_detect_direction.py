"""From where a shot comes: what panning, the bed and the order of the channels do to its azimuth."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.direction import direction, with_azimuths
from blastline.model import Channels, Shot, Span
from blastline.ruleset import load_rules
from blastline.soundtrack.loudspeakers import _FIXED_DEG, _ONE_PAIR_DEG, _TWO_PAIRS_DEG, azimuths

RATE_HZ = 48_000
ONSET = 480
LAYOUTS = {
    "stereo": ("FL", "FR"),
    "5.1": ("FL", "FR", "FC", "LFE", "SL", "SR"),
    "7.1": ("FL", "FR", "FC", "LFE", "BL", "BR", "SL", "SR"),
}


def places(layout: str) -> tuple[float | None, ...]:
    found = azimuths(LAYOUTS[layout], len(LAYOUTS[layout]))
    assert found is not None
    return found


def panned(layout: str, azimuth_deg: float) -> NDArray[np.float64]:
    """Return the gains of a sound between the two loudspeakers around it, whose vectors add up to its direction."""
    there = places(layout)
    gains = np.zeros(len(there))
    named = sorted((deg, channel) for channel, deg in enumerate(there) if deg is not None)
    for (left_deg, left), (right_deg, right) in zip(named, named[1:] + named[:1], strict=True):
        if (azimuth_deg - left_deg) % 360.0 <= (right_deg - left_deg) % 360.0:
            pair = np.radians([[left_deg, right_deg]]).repeat(2, axis=0)
            pair = np.stack([np.cos(pair[0]), np.sin(pair[1])])
            toward = [math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))]
            gains[[left, right]] = np.linalg.solve(pair, toward)
            break
    return gains


def blast(length: int = 960) -> NDArray[np.float64]:
    wave = np.zeros(length)
    time = np.arange(length - ONSET)
    wave[ONSET:] = np.exp(-time / 60.0) * np.random.default_rng(5).standard_normal(time.size)
    return wave


def told(samples: NDArray[np.float64], there: tuple[float | None, ...], rise_db: float = 3.0) -> tuple[float, float]:
    found = direction(samples, ONSET, there, rate_hz=RATE_HZ, rise_db=rise_db)
    assert found is not None
    return found


def test_loudspeakers_stand_as_mirrored_as_their_names_are() -> None:
    for places in (_FIXED_DEG, _ONE_PAIR_DEG, _TWO_PAIRS_DEG):
        for name, angle in places.items():
            mirrored = places[name.translate(str.maketrans("LR", "RL"))]
            assert (mirrored + angle) % 360.0 == 0.0
            assert angle < 0.0 if "L" in name else angle > 0.0 if "R" in name else angle in (0.0, 180.0)


@pytest.mark.parametrize("layout", ["5.1", "7.1"])
@pytest.mark.parametrize("azimuth_deg", [0.0, 12.0, -25.0, 30.0, 70.0, -110.0, 125.0, 160.0, 180.0, -140.0])
def test_a_panned_sound_comes_from_where_it_was_panned_to(layout: str, azimuth_deg: float) -> None:
    found, focus = told(blast()[:, None] * panned(layout, azimuth_deg), places(layout))
    assert abs((found - azimuth_deg + 180.0) % 360.0 - 180.0) <= 0.1
    assert 0.3 <= focus <= 1.0


def test_one_loudspeaker_is_a_point_and_two_are_wider() -> None:
    assert told(blast()[:, None] * panned("5.1", -110.0), places("5.1")) == (-110.0, 1.0)
    focus = [told(blast()[:, None] * panned("5.1", deg), places("5.1"))[1] for deg in (30.0, 40.0, 70.0)]
    assert focus == sorted(focus, reverse=True)
    assert focus[-1] == pytest.approx(math.cos(math.radians(40.0)), abs=1e-3)


@pytest.mark.parametrize("azimuth_deg", [-25.0, 55.0, 130.0])
def test_a_voice_that_goes_on_in_the_centre_does_not_pull(azimuth_deg: float) -> None:
    time = np.arange(960) / RATE_HZ
    tones = np.arange(1, 20)[:, None]
    voice = (np.sin(2.0 * math.pi * 140.0 * tones * time + tones) / tones).sum(axis=0)
    samples = blast()[:, None] * panned("5.1", azimuth_deg) + 0.5 * voice[:, None] * panned("5.1", 0.0)
    assert told(samples, places("5.1"))[0] == pytest.approx(azimuth_deg, abs=3.0)


@pytest.mark.parametrize("seed", range(5))
def test_what_goes_on_and_is_like_the_shot_by_chance_alone_does_not_pull_at_all(seed: int) -> None:
    samples = 2.0 * blast()[:, None] * panned("5.1", -110.0)
    samples[:, 2] += np.random.default_rng(seed).standard_normal(960)
    assert told(samples, places("5.1")) == (-110.0, 1.0)


@pytest.mark.parametrize("azimuth_deg", [-110.0, 75.0, 150.0])
def test_a_voice_that_begins_with_the_shot_does_not_pull_where_the_shot_was_heard_without_it(
    azimuth_deg: float,
) -> None:
    voice = np.zeros(960)
    voice[ONSET:] = np.random.default_rng(8).standard_normal(480) * np.linspace(0.0, 1.0, 480)
    samples = blast()[:, None] * panned("5.1", azimuth_deg)
    samples[:, 2] += voice
    there = places("5.1")
    with_voice, _ = told(samples, there)
    found = direction(samples, ONSET, there, rate_hz=RATE_HZ, rise_db=3.0, doubtful=2)
    assert found is not None
    assert abs(found[0] - azimuth_deg) <= 6.0 < abs(with_voice - azimuth_deg)


def test_what_goes_on_where_the_shot_plays_as_well_is_taken_off() -> None:
    rng = np.random.default_rng(12)
    bed = 0.5 * np.sqrt(np.mean(np.diff(blast(960)[ONSET:]) ** 2)) * rng.standard_normal(960)
    samples = blast()[:, None] * panned("5.1", 70.0)
    samples[:, 1] += bed
    found, _ = told(samples, places("5.1"), rise_db=1.0)
    assert found == pytest.approx(70.0, abs=4.0)


def test_a_shot_that_is_heard_beside_the_centre_is_placed_without_its_voice() -> None:
    voice = np.zeros(960)
    voice[ONSET:] = np.random.default_rng(8).standard_normal(480) * np.linspace(0.0, 1.0, 480)
    samples = blast()[:, None] * panned("5.1", -75.0)
    samples[:, 2] += voice
    span = Span(ONSET, 960)
    shot = Shot(ONSET, 0.95, -6.0, 20.0, span, (), span, heard_in="sides")
    channels = Channels(places("5.1"), 2, lambda asked: samples[asked.start : asked.stop])
    rules = load_rules("standard").tier.channels
    [pulled] = with_azimuths([shot], channels, rate_hz=RATE_HZ, rules=rules)
    [found] = with_azimuths([shot], channels, rate_hz=RATE_HZ, rules=rules, side_onsets=[ONSET + 100])
    assert pulled.azimuth_deg is not None
    assert found.azimuth_deg is not None
    assert abs(found.azimuth_deg + 75.0) <= 6.0 < abs(pulled.azimuth_deg + 75.0)
    assert with_azimuths([shot], None, rate_hz=RATE_HZ, rules=rules) == [shot]
    gone = Channels(places("5.1"), 2, lambda asked: None)
    assert with_azimuths([shot], gone, rate_hz=RATE_HZ, rules=rules) == [shot]


def test_a_shot_in_the_centre_alone_is_in_front_whoever_doubts_it() -> None:
    samples = blast()[:, None] * panned("5.1", 0.0)
    assert direction(samples, ONSET, places("5.1"), rate_hz=RATE_HZ, rise_db=3.0, doubtful=2) == (0.0, 1.0)


def test_unlike_sounds_from_two_sides_meet_in_the_middle() -> None:
    rng = np.random.default_rng(7)
    samples = np.zeros((960, 6))
    samples[ONSET:, :2] = rng.standard_normal((480, 2))
    azimuth_deg, _ = told(samples, places("5.1"))
    assert abs(azimuth_deg) <= 8.0


@pytest.mark.parametrize("layout", ["stereo", "5.1", "7.1"])
def test_a_mirrored_film_mirrors_the_azimuth(layout: str) -> None:
    names = LAYOUTS[layout]
    mirrored = [names.index(name.translate(str.maketrans("LR", "RL")) if name != "LFE" else name) for name in names]
    rng = np.random.default_rng(3)
    samples = rng.normal(0.0, 0.05, (960, len(names))) + blast()[:, None] * rng.uniform(0.0, 1.0, len(names))
    here, there = told(samples, places(layout)), told(samples[:, mirrored], places(layout))
    assert there == (-here[0], here[1])


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_the_channels_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    samples = rng.normal(0.0, 0.05, (960, 8)) + blast()[:, None] * rng.uniform(0.0, 1.0, 8)
    order = rng.permutation(8)
    there = places("7.1")
    assert told(samples[:, order], tuple(there[channel] for channel in order)) == told(samples, there)


@pytest.mark.parametrize("gain", [0.125, -1.0, 8.0])
def test_gain_polarity_and_a_constant_change_nothing(gain: float) -> None:
    rng = np.random.default_rng(9)
    samples = rng.normal(0.0, 0.05, (960, 6)) + blast()[:, None] * panned("5.1", 47.0)
    assert told(gain * samples, places("5.1")) == told(samples, places("5.1"))
    assert told(samples + np.arange(6) / 8.0, places("5.1"))[0] == pytest.approx(
        told(samples, places("5.1"))[0], abs=0.1
    )


def test_the_low_channel_and_channels_without_a_place_tell_nothing() -> None:
    samples = blast()[:, None] * panned("5.1", 70.0)
    with_boom = samples.copy()
    with_boom[:, 3] = 5.0 * blast()
    assert told(with_boom, places("5.1")) == told(samples, places("5.1"))


def test_what_does_not_stand_out_has_no_direction() -> None:
    steady = np.random.default_rng(2).standard_normal((960, 6))
    assert direction(steady, ONSET, places("5.1"), rate_hz=RATE_HZ, rise_db=3.0) is None
    assert direction(np.zeros((960, 6)), ONSET, places("5.1"), rate_hz=RATE_HZ, rise_db=3.0) is None
    around = (0.0, 90.0, 180.0, -90.0)
    assert direction(np.repeat(blast()[:, None], 4, axis=1), ONSET, around, rate_hz=RATE_HZ, rise_db=3.0) is None


@pytest.mark.parametrize("gain", [-1.0, -0.7, -0.5])
def test_what_two_loudspeakers_play_against_each_other_comes_from_nowhere(gain: float) -> None:
    there = places("stereo")
    for gains in ([1.0, gain], [gain, 1.0]):
        samples = blast()[:, None] * np.array(gains)
        assert direction(samples, ONSET, there, rate_hz=RATE_HZ, rise_db=3.0) is None
        assert direction(np.abs(gains) * blast()[:, None], ONSET, there, rate_hz=RATE_HZ, rise_db=3.0) is not None


def test_a_film_that_begins_with_the_shot_has_nothing_to_subtract() -> None:
    samples = (blast()[:, None] * panned("5.1", -60.0))[ONSET:]
    found = direction(samples, 0, places("5.1"), rate_hz=RATE_HZ, rise_db=3.0)
    assert found is not None
    assert found[0] == pytest.approx(-60.0, abs=0.1)


@pytest.mark.parametrize(
    ("layout", "expected"),
    [
        (("FC",), None),
        (("FL", "FR"), (-30.0, 30.0)),
        (("FL", "FR", "FC", "LFE", "BL", "BR"), (-30.0, 30.0, 0.0, None, -110.0, 110.0)),
        (("FL", "FC", "FR", "SL", "SR", "LFE"), (-30.0, 0.0, 30.0, -110.0, 110.0, None)),
        (LAYOUTS["7.1"], (-30.0, 30.0, 0.0, None, -135.0, 135.0, -90.0, 90.0)),
        (("FL", "FR", "FC", "LFE", "BC", "SL", "SR"), (-30.0, 30.0, 0.0, None, 180.0, -110.0, 110.0)),
        (("FC", "LFE"), None),
    ],
)
def test_loudspeakers_stand_where_the_standards_put_them(
    layout: tuple[str, ...], expected: tuple[float | None, ...] | None
) -> None:
    assert azimuths(layout, len(layout)) == expected


def test_channels_without_names_are_in_the_usual_order_or_nowhere() -> None:
    assert azimuths(None, 6) == azimuths(LAYOUTS["5.1"], 6)
    assert azimuths(None, 1) is None
    assert azimuths(None, 12) is None


def test_straight_behind_is_180_from_either_side() -> None:
    gains = panned("7.1", 180.0)
    for channel in (4, 5):  # a hair louder on one side
        leaning = gains.copy()
        leaning[channel] *= 1.0 + 1e-5
        assert told(blast()[:, None] * leaning, places("7.1"))[0] == 180.0


def placed(samples: NDArray[np.float64], onset: int) -> float:
    """Return the azimuth of a shot of a stereo film, which lasts until the film ends."""
    span = Span(onset, samples.shape[0])
    channels = Channels(places("stereo"), None, lambda asked: samples[asked.start : asked.stop])
    shot = Shot(onset, 0.95, -6.0, 20.0, span, (), span)
    [found] = with_azimuths([shot], channels, rate_hz=RATE_HZ, rules=load_rules("standard").tier.channels)
    assert found.azimuth_deg is not None
    return found.azimuth_deg


@pytest.mark.parametrize("early", [1, 10, 19, 24])
def test_a_blast_that_one_microphone_of_a_pair_hears_a_little_earlier_is_as_much_in_the_middle(early: int) -> None:
    burst = np.random.default_rng(4).standard_normal(400)
    samples = np.zeros((1440, 2))
    for channel, begins in enumerate((ONSET - early, ONSET)):
        samples[begins : begins + burst.size, channel] = burst
    assert placed(samples, ONSET) == pytest.approx(0.0, abs=3.0)
    assert placed(samples[:, ::-1], ONSET) == -placed(samples, ONSET)


@pytest.mark.parametrize("onset", [0, 1, 23, 24, 25])
@pytest.mark.parametrize("azimuth_deg", [-30.0, -12.0, 20.0])
def test_a_shot_on_the_first_samples_of_a_film_comes_from_where_it_was_panned_to(
    onset: int, azimuth_deg: float
) -> None:
    samples = blast()[ONSET - onset :, None] * panned("stereo", azimuth_deg)
    assert placed(samples, onset) == pytest.approx(azimuth_deg, abs=0.1)


def test_what_begins_after_a_shot_is_over_does_not_pull() -> None:
    length = 3 * RATE_HZ
    samples = np.zeros((length, 6))
    shot, other = (blast()[ONSET:, None] * panned("5.1", deg) for deg in (30.0, -110.0))
    samples[RATE_HZ : RATE_HZ + 96] = shot[:96]
    samples[RATE_HZ + 96 : RATE_HZ + 96 + ONSET] = other
    span = Span(RATE_HZ, RATE_HZ + 96)
    channels = Channels(places("5.1"), 2, lambda asked: samples[asked.start : asked.stop])
    short = Shot(RATE_HZ, 0.95, -6.0, 20.0, span, (), span)
    [found] = with_azimuths([short], channels, rate_hz=RATE_HZ, rules=load_rules("standard").tier.channels)
    assert found.azimuth_deg == 30.0
