"""What is heard of a shot: as its parts add up, whatever the polarity, the level and the number of other sounds."""

from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth import Scene, ShotTruth, render_scene, truth_of
from blastline.synth.audible import Audible, Parts, audible
from blastline.synth.colour import Colour
from blastline.synth.echoes import HeardEcho

RATE_HZ = 48_000
LEAD = 960
OPEN = Colour(highpass_hz=1.0, highpass_order=1)


def direct(positive_ms: float = 0.6) -> NDArray[np.float64]:
    time_ms = np.arange(round(0.016 * RATE_HZ)) * 1000.0 / RATE_HZ
    return np.asarray((1.0 - time_ms / positive_ms) * np.exp(-time_ms / positive_ms), np.float64)


def heard(echoes: dict[float, float], *, noise: float = 1e-3, scale: float = 1.0, seed: int = 0) -> Audible:
    """Judge a blast with echoes as {delay in ms: gain} in white noise."""
    blast = direct()
    alone = np.zeros(LEAD + round(0.51 * RATE_HZ))
    alone[LEAD : LEAD + blast.size] = blast
    listed = []
    for delay_ms, gain in sorted(echoes.items()):
        delay = round(delay_ms * 48)
        alone[LEAD + delay :][: blast.size] += gain * blast[: alone.size - LEAD - delay]
        listed.append(HeardEcho(delay, gain, gain * blast))
    bed = noise * np.random.default_rng(seed).standard_normal(alone.size)
    parts = Parts(alone.copy(), LEAD, blast, tuple(listed), OPEN)
    return audible(parts, scale * alone, scale * (alone + bed), lead=LEAD, rate_hz=RATE_HZ, rounding=0.0)


def test_an_echo_is_heard_over_a_quiet_bed_and_not_under_a_loud_one() -> None:
    assert heard({50.0: 0.3}).heard == (True,)
    assert heard({50.0: 0.3}, noise=1.0).heard == (False,)


def test_ten_times_the_noise_takes_twenty_decibels() -> None:
    margins = [heard({50.0: 0.3}, noise=noise).margins_db[0] for noise in (1e-3, 1e-2)]
    assert margins[0] - margins[1] == pytest.approx(20.0, abs=1.0)


@pytest.mark.parametrize("scale", [-1.0, 0.03, 20.0])
def test_polarity_and_level_change_nothing(scale: float) -> None:
    echoes = {12.0: 0.5, 50.0: 0.3, 200.0: 0.02}
    one, other = heard(echoes, noise=0.02), heard(echoes, noise=0.02, scale=scale)
    assert other.heard == one.heard
    assert other.blast == one.blast
    assert other.margins_db == pytest.approx(one.margins_db, abs=1e-6)


def test_what_starts_almost_together_is_heard_as_one() -> None:
    assert heard({50.0: 0.3, 51.0: 0.2}).heard == (True, False)
    assert heard({50.0: 0.2, 51.0: 0.3}).heard == (False, True)
    assert heard({50.0: 0.3, 56.0: 0.3}).heard == (True, True)


def test_the_blast_lasts_until_it_has_fallen_is_drowned_or_an_echo_is_heard() -> None:
    size = np.abs(direct())
    fallen = int(np.flatnonzero(size >= 0.1)[-1]) + 1
    assert heard({}).blast == pytest.approx(fallen, abs=3)
    assert heard({}, noise=0.3).blast < fallen
    assert heard({4.5: 0.9, 5.5: 0.1}).blast <= round(4.5 * 48)


def shot_of(bed_dbfs: float, seed: int, peak_dbfs: float = -6.0) -> ShotTruth:
    plain: dict[str, Any] = {
        "schema": 1,
        "rate_hz": 24_000,
        "duration_s": 3.0,
        "seed": seed,
        "beds": [{"kind": "rain", "level_dbfs": bed_dbfs}],
        "shots": [{"at_s": 1.0, "weapon": "rifle", "environment": "street", "peak_dbfs": peak_dbfs}],
        "negatives": [],
    }
    return truth_of(render_scene(msgspec.convert(plain, Scene))).shots[0]


@pytest.mark.parametrize("seed", range(3))
def test_a_louder_bed_masks_more_and_hides_no_echo_from_the_list(seed: int) -> None:
    quiet, loud, deafening = shot_of(-90.0, seed), shot_of(-20.0, seed), shot_of(-3.0, seed, -40.0)
    for louder in (loud, deafening):
        assert [echo.delay_ms for echo in louder.reflections] == [echo.delay_ms for echo in quiet.reflections]
    margins = [[echo.margin_db for echo in shot.reflections if echo.margin_db is not None] for shot in (quiet, loud)]
    assert np.median(margins[1]) < np.median(margins[0])
    assert not any(echo.audible for echo in deafening.reflections)
    assert quiet.heard_blast is not None
    assert deafening.heard_blast is not None
    assert len(deafening.heard_blast) < len(quiet.heard_blast)


def test_a_truth_from_before_there_was_this_is_read_still() -> None:
    plain = msgspec.to_builtins(shot_of(-60.0, 1))
    del plain["heard_blast"]
    for echo in plain["reflections"]:
        del echo["audible"], echo["margin_db"]
    old = msgspec.convert(plain, ShotTruth)
    assert old.heard_blast is None
    assert not any(echo.audible for echo in old.reflections)
