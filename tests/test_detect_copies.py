"""What copies an earlier, louder shot is its echo: how like two attacks are, and which copies are dropped."""

from functools import cache

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect import find_shots, verifier_of
from blastline.detect.bursts import drop_claimed_reflections, without_echoes
from blastline.detect.copies import attack, likeness
from blastline.model import Clip, EvenRow, Reflection, Shot, ShotEvidence, Span
from blastline.ruleset import load_rules
from blastline.synth import plain_shot

RATE_HZ = 48_000
ONSET = 4_800
RULES = load_rules("draft").tier.bursts


@cache
def bang(seed: int, *, gain: float = 1.0, constant: float = 0.0) -> NDArray[np.float32]:
    """Return noise that dies away with 8 ms, from `ONSET` on."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(ONSET) / RATE_HZ
    samples = np.zeros(2 * ONSET)
    samples[ONSET:] = gain * rng.standard_normal(ONSET) * np.exp(-time_s / 0.008)
    return (samples + constant).astype(np.float32)


def like(first: NDArray[np.float32], second: NDArray[np.float32], *, early: int = 0) -> float:
    earlier, later = attack(first, ONSET, RATE_HZ), attack(second, ONSET - early, RATE_HZ)
    return float(likeness(later, [earlier])[0])


@pytest.mark.parametrize("gain", [1.0, -1.0, 0.01, 30.0])
@pytest.mark.parametrize("constant", [0.0, 0.3])
def test_level_polarity_and_a_constant_change_nothing(gain: float, constant: float) -> None:
    assert like(bang(1), bang(1, gain=gain, constant=constant)) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("early", [-47, -10, 0, 1, 30, 47])
def test_an_onset_that_is_a_little_off_changes_little(early: int) -> None:
    assert like(bang(1), bang(1), early=early) > 0.97


@pytest.mark.parametrize("seed", range(2, 12))
def test_two_sounds_are_less_alike_than_a_copy_in_half_as_much_noise(seed: int) -> None:
    noise = 0.1 * np.random.default_rng(seed).standard_normal(2 * ONSET).astype(np.float32)
    assert like(bang(1), bang(seed)) < RULES.copy_likeness < like(bang(seed), bang(seed, gain=0.5) + noise)


@pytest.mark.parametrize("lead", [48, 100, 240, 1_000])
def test_an_attack_is_the_same_however_much_of_the_film_lies_before_it(lead: int) -> None:
    here, there = (attack(samples, at, RATE_HZ) for samples, at in ((bang(1), ONSET), (bang(1)[-lead - ONSET :], lead)))
    assert len(here) == len(there) == 2 * 18 * RATE_HZ // 1000, "16 ms and 1 ms at either side, in 16 bits"
    assert likeness(there, [here])[0] > 0.99


def test_several_are_compared_as_each_is() -> None:
    attacks = [attack(bang(seed), ONSET, RATE_HZ) for seed in range(5)]
    together = likeness(attacks[2], attacks)
    assert together == pytest.approx([likeness(attacks[2], [each])[0] for each in attacks], abs=1e-6)
    assert together.argmax() == 2


def test_what_is_not_known_is_like_nothing() -> None:
    known = attack(bang(1), ONSET, RATE_HZ)
    assert attack(bang(1)[ONSET:], 10, RATE_HZ) == b""
    assert attack(bang(1)[: ONSET + 100], ONSET, RATE_HZ) == b""
    assert attack(np.zeros(2 * ONSET, np.float32), ONSET, RATE_HZ) == b""
    assert likeness(known, [b"", known]).tolist() == [0.0, pytest.approx(1.0)]
    assert likeness(b"", [known]).tolist() == [0.0]


def test_an_attack_that_is_heard_in_its_margin_alone_is_like_nothing() -> None:
    known = np.frombuffer(attack(bang(1), ONSET, RATE_HZ), np.int16)
    margin = RATE_HZ // 1000
    late = np.zeros_like(known)
    late[-margin:] = 30_000
    with np.errstate(all="raise"):
        assert likeness(known.tobytes(), [late.tobytes(), known.tobytes()]).tolist() == [0.0, pytest.approx(1.0)]


def shot(at_ms: float, peak_dbfs: float, *, seed: int = 1, row: EvenRow | None = None) -> Shot:
    at = round(at_ms * RATE_HZ / 1000.0)
    part = Span(at, at + 9)
    known = ShotEvidence(0.9, 1, None, "fallen", attack=attack(bang(seed), ONSET, RATE_HZ), even_row=row)
    return Shot(at, 0.9, peak_dbfs=peak_dbfs, snr_db=30.0, blast=part, reflections=(), span=part, evidence=known)


def echoes(*shots: Shot) -> list[int]:
    kept, dropped = without_echoes(shots, rate_hz=RATE_HZ, rules=RULES)
    assert len(kept) + len(dropped) == len(shots)
    return [each.at_sample for each in dropped]


LATEST_MS, DROP_DB = RULES.latest_copy_ms, RULES.echo_drop_db


@pytest.mark.parametrize(
    ("second", "is_echo"),
    [
        (shot(100.0, -6.0 - DROP_DB), True),
        (shot(LATEST_MS, -30.0), True),
        (shot(LATEST_MS + 1.0, -30.0), False),
        (shot(100.0, -6.0 - DROP_DB + 0.1), False),
        (shot(100.0, -30.0, seed=2), False),
        (shot(100.0, -30.0, row="fire"), False),
        (msgspec.structs.replace(shot(100.0, -30.0), evidence=None), False),
    ],
)
def test_a_softer_copy_within_a_second_is_an_echo(second: Shot, is_echo: bool) -> None:
    assert echoes(shot(0.0, -6.0), second) == ([second.onset] if is_echo else [])


def test_a_shot_with_nothing_louder_before_it_copies_nothing_however_little_is_asked() -> None:
    rules = msgspec.structs.replace(RULES, copy_likeness=0.0)
    kept, dropped = without_echoes([shot(0.0, -9.0), shot(300.0, -6.0, seed=2)], rate_hz=RATE_HZ, rules=rules)
    assert (len(kept), dropped) == (2, ())


@pytest.mark.parametrize(("seed", "is_echo"), [(1, True), (2, False)])
def test_where_a_reflection_was_found_only_what_is_a_little_like_the_shot_is_its_echo(
    seed: int, *, is_echo: bool
) -> None:
    """Another shot is a spike of the matched filter as well."""
    later = shot(300.0, -12.0, seed=seed, row="no fire")  # asked about by no other rule
    heard = Reflection(later.onset, later.onset + 9, 300.0, -6.0)
    first = msgspec.structs.replace(shot(0.0, -6.0), reflections=(heard,))
    assert echoes(first, later) == ([later.onset] if is_echo else [])
    unknown = msgspec.structs.replace(later, evidence=None)
    assert echoes(first, unknown) == [later.onset]


def test_an_echo_found_as_a_sound_is_a_reflection_of_what_it_copies() -> None:
    other, first, echo = shot(0.0, -6.0, seed=2), shot(300.0, -8.0), shot(700.0, -15.0)
    kept, _ = without_echoes([other, first, echo], rate_hz=RATE_HZ, rules=RULES)
    assert [len(each.reflections) for each in kept] == [0, 1]
    (found,) = kept[1].reflections
    assert (found.start, found.stop) == (echo.onset, echo.blast.stop)
    assert (found.delay_ms, found.level_db) == pytest.approx((400.0, -7.0))
    lasting = drop_claimed_reflections(kept, rate_hz=RATE_HZ, rules=RULES)[1]
    assert lasting.span.stop == echo.blast.stop
    assert lasting.evidence is not None
    assert (lasting.evidence.copies, lasting.evidence.decay_end) == (1, "last reflection")


@pytest.mark.parametrize("beside_ms", [0.0, 0.9, -0.9])
def test_an_echo_that_was_heard_as_a_reflection_and_found_as_a_sound_is_one(beside_ms: float) -> None:
    """A clipped echo answers louder than it peaks: too loud for its peak to be expected there."""
    first, echo = shot(0.0, -6.0), shot(100.0, -6.0 - DROP_DB - 1.0)
    places = [echo.onset + round(beside_ms * RATE_HZ / 1000.0), echo.onset - 2_400, echo.onset + 2_400]
    heard = tuple(Reflection(at, at + 9, at * 1000.0 / RATE_HZ, -DROP_DB + 1.0) for at in sorted(places))
    assert first.evidence is not None
    evidence = msgspec.structs.replace(first.evidence, copies=len(heard))
    (kept,), _ = without_echoes(
        [msgspec.structs.replace(first, reflections=heard, evidence=evidence), echo], rate_hz=RATE_HZ, rules=RULES
    )
    found = [(each.start, each.level_db) for each in kept.reflections]
    assert found == [(places[1], heard[0].level_db), (echo.onset, -DROP_DB - 1.0), (places[2], heard[2].level_db)]
    assert kept.evidence is not None
    assert kept.evidence.copies == len(heard)


def test_any_louder_shot_before_it_may_be_what_a_shot_copies() -> None:
    between = shot(200.0, -6.0, seed=2)
    assert echoes(shot(0.0, -6.0), between, shot(400.0, -12.0), shot(500.0, -12.0, seed=2)) == [
        shot(at_ms, 0.0).onset for at_ms in (400.0, 500.0)
    ]


def test_an_echo_makes_no_echoes_of_its_own() -> None:
    """What an echo is like, its shot is like as well; but what comes too late after the shot is another sound."""
    assert echoes(shot(0.0, -6.0), shot(600.0, -12.0), shot(LATEST_MS + 500.0, -18.0)) == [shot(600.0, 0.0).onset]


def test_draft_takes_few_clear_echoes_in_a_quiet_place_for_shots() -> None:
    """It looks for no reflections, but hears softer copies; they cost it no shot."""
    tier = load_rules("draft").tier
    deaf = msgspec.structs.replace(tier, bursts=msgspec.structs.replace(tier.bursts, copy_likeness=1.0))
    verifier = verifier_of(tier)
    onsets, film = _quiet_film()
    heard = []
    for each in (deaf, tier):
        found = find_shots([Clip(film, RATE_HZ)], rate_hz=RATE_HZ, tier=each, verifier=verifier).shots
        true = [any(abs(one.onset - onset) <= RATE_HZ // 1000 for onset in onsets) for one in found]
        heard.append((sum(true), len(true) - sum(true)))
    (shots, echoes_as_shots), (still, left) = heard
    assert still == shots >= 0.9 * len(onsets)
    assert echoes_as_shots >= 6
    assert 3 * left <= echoes_as_shots


def _quiet_film() -> tuple[list[int], NDArray[np.float32]]:
    """Return twelve shots, five seconds apart, each with one echo 9 dB softer, over faint noise; and their onsets."""
    rng = np.random.default_rng(3)
    film = 3e-4 * rng.standard_normal(62 * RATE_HZ)
    onsets = []
    for number in range(12):
        sound, starts = _single(number)
        at, late = (1 + 5 * number) * RATE_HZ, round((0.08, 0.2, 0.35, 0.7)[number % 4] * RATE_HZ)
        onsets.append(at + starts)
        for place, gain in ((at, 0.5), (at + late, 0.5 * 10.0 ** (-9.0 / 20.0))):
            film[place : place + sound.size] += gain * sound[: film.size - place]
    return onsets, film.astype(np.float32)[:, None]


def _single(number: int) -> tuple[NDArray[np.float64], int]:
    """Return a made shot that is no burst, and where it begins."""
    for seed in range(10 * number, 10 * number + 10):
        sound, onsets = plain_shot(np.random.default_rng(seed), RATE_HZ)
        if len(onsets) == 1:
            return sound[: 4 * RATE_HZ], onsets[0]
    raise AssertionError("ten bursts in a row")
