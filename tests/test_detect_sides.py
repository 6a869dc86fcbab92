"""Listening a second time beside the middle: what it gains, and what it must not change."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline import run
from blastline.detect import LATENCY_S, Detection, find_shots, verifier_of, whole
from blastline.detect.backdrop import LEVELS
from blastline.detect.company import in_company
from blastline.detect.fire import ScoredCandidates
from blastline.detect.sides import merge_mixes
from blastline.detect.verify import LogOdds
from blastline.detect.whole import ChunkResult, MixResult, of_whole_film
from blastline.model import Rejection, Shot, ShotEvidence, Span
from blastline.ruleset import BurstRules, QualityRules, load_rules
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.mix import mix_matrix
from blastline.soundtrack.reader import Soundtrack
from blastline.soundtrack.track import TrackFacts
from blastline.synth import Scene, Truth, render_scene, truth_of
from media import write_media

RATE_HZ = 48_000
NAMES = ("FL", "FR", "FC", "LFE", "SL", "SR")
RULES = load_rules("standard")
VERIFIER = verifier_of(RULES.tier)
SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 16.0,
    "seed": 4,
    "layout": "5.1",
    "beds": [{"kind": "dialogue", "level_dbfs": -16.0}, {"kind": "ambience", "level_dbfs": -58.0}],
    "shots": [
        {
            "at_s": 2.0,
            "weapon": "rifle",
            "environment": "street",
            "distance_m": 15.0,
            "snr_db": 4.0,
            "azimuth_deg": 110,
        },
        {
            "at_s": 6.0,
            "weapon": "pistol",
            "environment": "street",
            "distance_m": 8.0,
            "snr_db": 4.0,
            "azimuth_deg": -60,
        },
        {
            "at_s": 9.5,
            "weapon": "shotgun",
            "environment": "field",
            "distance_m": 20.0,
            "snr_db": 30.0,
            "azimuth_deg": 20,
        },
        {
            "at_s": 13.0,
            "weapon": "rifle",
            "environment": "field",
            "distance_m": 15.0,
            "snr_db": 6.0,
            "azimuth_deg": -90,
        },
    ],
}

Samples = NDArray[np.float32]


class Tape:
    """A track of samples in memory, which cannot be read twice."""

    def __init__(self, samples: Samples, layout: Sequence[str]) -> None:
        self.samples = samples
        self.facts = TrackFacts(RATE_HZ, samples.shape[1], tuple(layout), samples.shape[0])

    def pieces(self) -> Iterator[Samples]:
        for start in range(0, self.samples.shape[0], 10_007):
            yield self.samples[start : start + 10_007]

    def read_approximately(self, start_s: float, frames: int) -> Iterator[Samples]:
        yield self.samples[round(start_s * RATE_HZ) :][:frames]

    def warnings(self) -> list[str]:
        return []

    def close(self) -> None:
        pass


@pytest.fixture(scope="module")
def film() -> tuple[Samples, Truth]:
    audio = render_scene(msgspec.convert(SCENE, Scene))
    samples = np.round(audio.read(0, audio.frames) * 32_767.0) / 32_768.0
    return samples.astype(np.float32), truth_of(audio)


def opened(samples: Samples, layout: Sequence[str] = NAMES, mix: str = "mains") -> Soundtrack:
    matrix = mix_matrix(layout, len(layout), mix)
    return Soundtrack(Path("tape"), Tape(samples, layout), matrix=matrix, mix=mix, spool=None)


def found_in(
    samples: Samples,
    layout: Sequence[str] = NAMES,
    *,
    mix: str = "mains",
    size: int = 65_536,
    tier: QualityRules = RULES.tier,
) -> Detection:
    track = opened(samples, layout, mix)
    blocks = track.blocks(size, sides=tier.channels.sides, remembered_s=LATENCY_S)
    return find_shots(blocks, rate_hz=RATE_HZ, tier=tier, verifier=VERIFIER, channels=track.channels_in_space)


def deaf_to_sides() -> QualityRules:
    return msgspec.structs.replace(RULES.tier, channels=msgspec.structs.replace(RULES.tier.channels, sides=False))


def near(found: Detection, onset: int) -> Shot | None:
    return next((shot for shot in found.shots if abs(shot.onset - onset) <= 0.01 * RATE_HZ), None)


def test_shots_that_the_centre_drowns_are_found_beside_it_and_come_from_where_they_are(
    film: tuple[Samples, Truth],
) -> None:
    samples, truth = film
    once, twice = found_in(samples, tier=deaf_to_sides()), found_in(samples)
    drowned, clear = [truth.shots[index] for index in (0, 1, 3)], truth.shots[2]
    gained = [shot for shot in drowned if near(once, shot.onset_sample) is None and near(twice, shot.onset_sample)]
    assert len(gained) >= 2
    for shot in (*gained, clear):
        heard = near(twice, shot.onset_sample)
        assert heard is not None
        assert heard.heard_in == ("mains" if shot is clear else "sides")
        assert shot.azimuth_deg is not None
        assert heard.azimuth_deg == pytest.approx(shot.azimuth_deg, abs=5.0)
    assert len(twice.shots) <= 4


def test_what_both_mixes_hear_keeps_its_parts_in_the_mains(film: tuple[Samples, Truth]) -> None:
    kept = [shot for shot in found_in(film[0]).shots if shot.heard_in == "mains"]
    assert kept
    for heard in kept:
        alone = near(found_in(film[0], tier=deaf_to_sides()), heard.onset)
        assert alone is not None
        assert msgspec.structs.replace(alone, azimuth_deg=None, azimuth_focus=None) == msgspec.structs.replace(
            heard, azimuth_deg=None, azimuth_focus=None
        )


@pytest.mark.parametrize("size", [4_096, 768_000])
def test_the_block_size_changes_nothing(film: tuple[Samples, Truth], size: int) -> None:
    assert found_in(film[0], size=size) == found_in(film[0])


@pytest.mark.parametrize("order", [(0, 2, 1, 4, 5, 3), (5, 4, 3, 2, 1, 0)])
def test_channels_in_another_order_are_the_same_film(film: tuple[Samples, Truth], order: tuple[int, ...]) -> None:
    there = [NAMES[channel] for channel in order]
    assert found_in(np.ascontiguousarray(film[0][:, order]), there) == found_in(film[0])


def test_a_mirrored_film_mirrors_every_azimuth(film: tuple[Samples, Truth]) -> None:
    here, there = found_in(film[0]), found_in(np.ascontiguousarray(film[0][:, [1, 0, 2, 3, 5, 4]]))
    assert [shot.onset for shot in there.shots] == [shot.onset for shot in here.shots]
    for one, other in zip(here.shots, there.shots, strict=True):
        assert one.azimuth_deg is not None
        assert other.azimuth_deg == -one.azimuth_deg


def test_a_delay_delays_and_turns_nothing(film: tuple[Samples, Truth]) -> None:
    delay = 12_345
    later = found_in(np.concatenate([np.zeros((delay, 6), np.float32), film[0]]))
    for shot in found_in(film[0]).shots:
        moved = near(later, shot.onset + delay)
        assert moved is not None
        assert moved.onset == shot.onset + delay
        assert moved.azimuth_deg == shot.azimuth_deg


@pytest.mark.parametrize(
    ("layout", "mix"), [(("FC",), "mains"), (("FL", "FR", "BL", "BR"), "mains"), (("FL", "FR"), "0,1")]
)
def test_films_without_sides_are_heard_once(film: tuple[Samples, Truth], layout: tuple[str, ...], mix: str) -> None:
    samples = np.ascontiguousarray(film[0][:, : len(layout)])
    for block in opened(samples, layout, mix).blocks(sides=True):
        assert block.sides is None
    plain = find_shots(opened(samples, layout, mix).blocks(), rate_hz=RATE_HZ, tier=RULES.tier, verifier=VERIFIER)
    heard = found_in(samples, layout, mix=mix)
    without = tuple(msgspec.structs.replace(s, azimuth_deg=None, azimuth_focus=None) for s in heard.shots)
    assert (without, heard.rejections) == (plain.shots, plain.rejections)
    if len(layout) == 1:
        assert heard == plain


@pytest.mark.parametrize("mix", ["center", "0,1", "2"])
def test_who_says_what_to_listen_to_is_not_overruled(film: tuple[Samples, Truth], mix: str) -> None:
    blocks = list(opened(film[0], mix=mix).blocks(sides=True))
    assert blocks
    assert all(block.sides is None for block in blocks)


def test_sides_are_the_mains_less_the_centre_whatever_the_block(film: tuple[Samples, Truth]) -> None:
    silent = film[0].copy()
    silent[:, 2] = 0.0
    expected = np.concatenate([block.heard for block in opened(silent).blocks()])
    for size in (1_000, 65_536):
        sides = [block.sides for block in opened(film[0]).blocks(size, sides=True) if block.sides is not None]
        np.testing.assert_allclose(np.concatenate(sides), expected, atol=2e-7)


@pytest.mark.parametrize("kind", ["wav", "mkv"])
def test_sides_are_the_same_wherever_they_are_read(film: tuple[Samples, Truth], tmp_path: Path, kind: str) -> None:
    import soundfile

    path = tmp_path / f"film.{kind}"
    if kind == "wav":
        soundfile.write(path, film[0], RATE_HZ, subtype="PCM_16")
    else:
        write_media(path, [film[0]], codec="flac")
    with open_soundtrack(path) as track:
        heard, beside = track.read_approximately(0.0, 1.0, sides=True)[:RATE_HZ].T
    with open_soundtrack(path) as track:
        first, *_ = list(track.blocks(RATE_HZ, sides=True))
        assert first.sides is not None
        np.testing.assert_array_equal(heard, first.heard)
        np.testing.assert_array_equal(beside, first.sides)
        if kind == "wav":
            again = track.read(Span(0, RATE_HZ), sides=True).sides
            assert again is not None
            np.testing.assert_array_equal(again, first.sides)


def test_what_has_just_gone_by_can_be_read_and_what_is_long_gone_can_not() -> None:
    samples = np.random.default_rng(1).uniform(-1.0, 1.0, (100_000, 6)).astype(np.float32)
    track = opened(samples)
    for block in track.blocks(10_000, remembered_s=0.5):
        around = track.channels_in_space
        assert around is not None
        recent = Span(max(0, block.span.stop - 24_000), block.span.stop)
        heard = around.read(recent)
        assert heard is not None
        exact = samples[recent.start : recent.stop]
        assert np.all(np.abs(heard - exact) <= 2.0**-7 * np.abs(exact))
        if block.start >= 60_000:
            assert around.read(Span(0, 100)) is None


def test_a_film_that_can_be_read_once_tells_what_a_file_of_samples_tells(
    film: tuple[Samples, Truth], tmp_path: Path
) -> None:
    import soundfile

    soundfile.write(tmp_path / "film.wav", film[0], RATE_HZ, subtype="PCM_16")
    coded = write_media(tmp_path / "film.mkv", [film[0]], codec="flac")
    there, here = (run.detect(path).events for path in (tmp_path / "film.wav", coded))
    assert [event.onset_sample for event in here] == [event.onset_sample for event in there]
    assert {event.heard_in for event in here} == {"mains", "sides"}
    for one, other in zip(here, there, strict=True):
        assert (one.confidence, one.heard_in) == (other.confidence, other.heard_in)
        assert one.azimuth_deg is not None
        assert one.azimuth_deg == pytest.approx(other.azimuth_deg, abs=0.5)


def test_rules_that_do_not_ask_for_sides_hear_the_mains_alone(film: tuple[Samples, Truth]) -> None:
    drafty = load_rules("draft").tier
    assert not drafty.channels.sides
    assert {shot.heard_in for shot in found_in(film[0], tier=drafty).shots} == {"mains"}


def shot(onset: int, confidence: float) -> Shot:
    span = Span(onset, onset + 100)
    return Shot(onset, confidence, -6.0, 20.0, span, (), span)


def test_one_onset_is_one_shot_and_the_mix_that_is_surer_judges_it() -> None:
    mains = (
        [shot(1_000, 0.5), shot(5_000, 0.95), shot(9_000, 0.6), shot(13_000, 0.85)],
        [Rejection(20_000, "no", {"probability": 0.1})],
    )
    sides = (
        [
            *(shot(1_100, 0.97), shot(5_010, 0.99), shot(9_010, 0.55), shot(13_010, 0.8)),
            *(shot(20_005, 0.96), shot(30_000, 0.92)),
        ],
        [Rejection(40_000, "no", {"probability": 0.2}), Rejection(30_100, "no", {"probability": 0.2})],
    )
    strict = msgspec.structs.replace(RULES.tier, verify=msgspec.structs.replace(RULES.tier.verify, threshold=0.9))
    shots, refused = merge_mixes(mains, sides, rate_hz=RATE_HZ, tier=strict)
    assert [(s.onset, s.confidence, s.heard_in) for s in shots] == [
        (1_000, 0.97, "sides"),
        (5_000, 0.95, "mains"),
        (9_000, 0.6, "mains"),
        (13_000, 0.85, "mains"),
        (20_005, 0.96, "sides"),
        (30_000, 0.92, "sides"),
    ]
    assert [(each.at_sample, each.reason) for each in refused] == [(40_000, "no, in the sides")]


def test_who_judged_a_shot_is_told_of_the_mix_that_did() -> None:
    in_mains, in_sides = ShotEvidence(0.5, 1, None, "fallen"), ShotEvidence(0.9, 8, None, "next sound")
    mains = [msgspec.structs.replace(shot(at, 0.5), evidence=in_mains) for at in (1_000, 9_000)]
    sides = [msgspec.structs.replace(shot(1_010, 0.9), evidence=in_sides)]
    judged, alone = merge_mixes((mains, []), (sides, []), rate_hz=RATE_HZ, tier=RULES.tier)[0]
    # how the shot ends is told of the parts, which are those of the mains
    assert judged.evidence == ShotEvidence(0.9, 8, None, "fallen")
    assert alone.evidence == in_mains


def test_what_is_refused_in_the_sides_is_listed_from_the_same_probability_on(film: tuple[Samples, Truth]) -> None:
    listed = [each for each in found_in(film[0]).rejections if each.reason.endswith(", in the sides")]
    least = min(each.evidence["probability"] for each in listed)
    assert RULES.tier.verify.report_from <= least < RULES.tier.channels.sides_company_threshold


def believed(mains: list[Shot], sides: list[Shot]) -> set[int]:
    shots, _ = merge_mixes((mains, []), (sides, []), rate_hz=RATE_HZ, tier=RULES.tier)
    return {each.onset for each in in_company(shots, rate_hz=RATE_HZ, tier=RULES.tier)[0]}


@pytest.mark.parametrize("apart_ms", [100.0, 3000.0])
def test_a_second_listening_costs_no_shot_that_the_mains_believe(apart_ms: float) -> None:
    """As a round of a burst or in company: what both hear is not held to what is asked of the sides alone."""
    gap, confidences = round(apart_ms * RATE_HZ / 1000.0), np.arange(0.05, 1.0, 0.05).round(2).tolist()
    sure = [shot(10_000, 0.97), shot(10_000 + gap, 0.97)]
    places = set[int]()
    for heard in confidences:
        doubted = shot(10_000 + 2 * gap, heard)
        alone = believed([*sure, doubted], [])
        places |= alone
        for beside in confidences:
            assert alone <= believed([*sure, doubted], [shot(doubted.onset + 5, beside)]), (heard, beside)
    assert 10_000 + 2 * gap in places


@pytest.mark.parametrize("aside", [0, 1, 200])
def test_a_row_is_told_by_the_mix_that_judged_its_shots_wherever_they_begin_in_it(aside: int) -> None:
    """Both mixes hear a burst, each to another sample or to the same one; the sides alone know it for fire."""
    onsets = 10_000 + 4_800 * np.arange(6)
    evidence = ShotEvidence(0.5, 1, None, "fallen")
    heard = [msgspec.structs.replace(shot(at, 0.3), evidence=evidence) for at in onsets.tolist()]
    there = [msgspec.structs.replace(shot(at + aside, 0.95), evidence=evidence) for at in onsets.tolist()]
    # one of them is likely in the mains as well, so that all of them are heard there
    in_mains, in_sides = _scored(onsets, [1.0, *5 * [-1.0]]), _scored(onsets + aside, 6 * [3.0])
    film: ChunkResult = {"mains": found(heard, in_mains), "sides": found(there, in_sides)}
    told, _ = of_whole_film([film], rate_hz=RATE_HZ, tier=RULES.tier)
    assert {each.heard_in for each in told} == {"sides"}
    assert [each.onset for each in told] == onsets.tolist()
    assert [each.evidence and each.evidence.even_row for each in told] == 6 * ["fire"]
    alone, _ = of_whole_film([{"mains": film["mains"]}], rate_hz=RATE_HZ, tier=RULES.tier)
    assert [each.evidence and each.evidence.even_row for each in alone] == 6 * [None]


def found(shots: list[Shot], scored: ScoredCandidates) -> MixResult:
    return MixResult(shots, [], scored, shots, np.zeros(len(shots), np.bool_))


def _scored(onsets: NDArray[np.intp], log_odds: list[float]) -> ScoredCandidates:
    odds = np.array(log_odds)
    unheard = np.zeros((onsets.size, LEVELS), np.int16)
    return ScoredCandidates(onsets, np.full(onsets.size, -6.0), LogOdds(odds, odds, odds), unheard)


def test_what_the_mains_are_sure_of_is_not_moved_by_the_sides() -> None:
    sure = RULES.tier.verify.threshold
    gap = round(RULES.tier.bursts.shortest_gap_ms * RATE_HZ / 1000.0)
    mains = [shot(10_000, sure), shot(50_000, sure - 0.1)], list[Rejection]()
    sides = [shot(10_400, 0.99), shot(10_001 + gap, 0.99), shot(50_400, 0.99)], list[Rejection]()
    shots, _ = merge_mixes(mains, sides, rate_hz=RATE_HZ, tier=RULES.tier)
    assert [each.onset for each in shots] == [10_000, 50_000, 10_001 + gap, 50_400]


def test_only_what_is_not_left_to_the_mains_is_heard_in_the_sides(
    film: tuple[Samples, Truth], monkeypatch: pytest.MonkeyPatch
) -> None:
    samples, _ = film
    assert any(shot.heard_in == "sides" for shot in found_in(samples).shots)

    def all_of(
        heard: NDArray[np.bool_], onsets: NDArray[np.intp], *, rate_hz: int, rules: BurstRules
    ) -> NDArray[np.bool_]:
        return np.ones(onsets.size, np.bool_)

    monkeypatch.setattr(whole, "left_to_mains", all_of)
    assert all(shot.heard_in == "mains" for shot in found_in(samples).shots)
