"""Figures of the studies: intervals, timing, bursts, levels and events follow from what was found and what is true."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.detect import Detection
from blastline.errors import RuleError
from blastline.model import Rejection, Shot, Span
from blastline.ruleset import load_rules
from blastline.study.bootstrap import f1_gain, intervals
from blastline.study.cases import Case, near_each_other, recordings
from blastline.study.corpus import read_corpus
from blastline.study.cost import Heard
from blastline.study.events import EXCERPT_BEFORE_S, ScoredEvent, excerpt, scored_events, write_events
from blastline.study.front import on_front, shortfall
from blastline.study.matching import Counts
from blastline.study.settings import CHANGES, changed, settings
from blastline.study.tally import Spent, Tally

RATE_HZ = 48_000
SPENT = Spent(cpu_s=0.5, read_s=0.1)


def case(true_ms: list[float], *, snr_db: float = 30.0, path: Path = Path("film.wav"), **more: Any) -> Case:
    shots = len(true_ms)
    return Case("film", path, np.array(true_ms), np.full(shots, snr_db), np.ones(shots, bool), **more)


def test_intervals_are_the_percentiles_of_films_drawn_anew_and_the_same_each_time() -> None:
    rng = np.random.default_rng(1)
    films = [Counts(*row) for row in rng.integers(0, 30, (15, 3)).tolist()]
    found = intervals(films, seed=4, draws=500)
    assert found == intervals(films, seed=4, draws=500)
    assert found != intervals(films, seed=5, draws=500)
    chosen = np.random.default_rng(4).integers(0, 15, (500, 15))
    scores = [sum((films[film] for film in draw), Counts(0, 0, 0)) for draw in chosen]
    for name in ("f1", "precision", "recall"):
        low, high = np.percentile([getattr(score, name) for score in scores], [2.5, 97.5])
        assert (getattr(found, name).low, getattr(found, name).high) == pytest.approx((low, high))


def test_an_interval_holds_the_score_and_one_film_has_none_around_it() -> None:
    films = [Counts(9, 1, 2), Counts(3, 3, 0), Counts(20, 0, 5), Counts(0, 4, 0)]
    found = intervals(films)
    assert found.f1.low < sum(films, Counts(0, 0, 0)).f1 < found.f1.high
    alone = intervals(films[:1])
    assert alone.recall.low == alone.recall.high == pytest.approx(9 / 11)


def test_a_gain_is_between_the_same_films() -> None:
    films = [Counts(9, 1, 2), Counts(3, 3, 0), Counts(20, 0, 5)]
    same = f1_gain(films, films)
    assert (same.low, same.high) == (0.0, 0.0)
    better = [Counts(each.hits + 1, each.false, each.missed) for each in films]
    assert f1_gain(better, films).low > 0.0
    assert f1_gain(films, better).high < 0.0
    with pytest.raises(ValueError, match="same films"):
        f1_gain(films, better[:2])


@pytest.mark.parametrize("seed", range(10))
def test_the_front_is_what_nothing_dominates(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # few distinct values, so that ties occur
    costs, scores = rng.integers(1, 8, 25).tolist(), rng.integers(1, 8, 25).tolist()
    points = list(zip(costs, scores, strict=True))

    def beats(one: tuple[float, float], other: tuple[float, float]) -> bool:
        return one[0] <= other[0] and one[1] >= other[1] and one != other

    expected = [not any(beats(other, point) for other in points) for point in points]
    found = on_front(costs, scores)
    assert found.tolist() == expected
    assert any(expected)
    for index, there in enumerate(expected):
        short = shortfall(index, costs, scores)
        assert short >= 0.0
        assert not there or short == 0.0


def test_timing_is_the_shift_of_what_was_found() -> None:
    true_ms = np.arange(1, 41) * 700.0
    late_ms = np.linspace(-1.0, 4.0, 40)
    tally = Tally()
    tally.add(case(true_ms.tolist()), true_ms + late_ms, minutes=0.5, spent=SPENT)
    score = tally.score("any")
    for timing in (score.timing, score.clear_timing):
        assert timing is not None
        assert timing.shots == 40
        assert timing.bias_ms == pytest.approx(np.median(late_ms))
        assert timing.median_ms == pytest.approx(np.median(np.abs(late_ms)))
        assert timing.p95_ms == pytest.approx(np.percentile(np.abs(late_ms), 95))
    assert score.f1_by_window_ms["2"] == pytest.approx(np.mean(np.abs(late_ms) <= 2.0))
    assert score.cost.times_read == pytest.approx(5.0)
    assert score.cost.cpu_s_per_hour == pytest.approx(60.0)


def test_what_is_not_timed_has_no_say_in_timing() -> None:
    one = Case("film", Path("a"), np.array([100.0, 900.0]), np.array([30.0, 30.0]), np.array([True, False]))
    tally = Tally()
    tally.add(one, np.array([101.0, 906.0]), minutes=1.0, spent=SPENT)
    timing = tally.score("any").timing
    assert timing is not None
    assert timing.shots == 1
    assert timing.bias_ms == pytest.approx(1.0)


def test_bursts_are_counted_shot_by_shot_and_as_a_whole() -> None:
    first, second = [1000.0, 1100.0, 1200.0], [5000.0, 5080.0, 5160.0, 5240.0]
    film = case([*first, *second], bursts=((0, 1, 2), (3, 4, 5, 6)))
    tally = Tally()
    found_ms = np.array([1000.0, 1100.5, 1200.0, 5000.0, 5080.0, 5240.0, 5260.0, 8000.0])
    tally.add(film, found_ms, minutes=1.0, spent=SPENT)
    bursts = tally.score("any").bursts
    assert bursts is not None
    assert (bursts.bursts, bursts.shots) == (2, 7)
    assert bursts.recall == pytest.approx(6 / 7)
    # an echo counted as a shot makes up for a missed one: the number is exact
    assert (bursts.exact, bursts.mean_error, bursts.mean_absolute_error) == (1.0, 0.0, 0.0)
    tally.add(film, found_ms[:6], minutes=1.0, spent=SPENT)
    again = tally.score("any").bursts
    assert again is not None
    assert (again.exact, again.mean_error, again.mean_absolute_error) == (0.75, -0.25, 0.25)


def test_onsets_near_each_other_are_bursts() -> None:
    assert near_each_other(np.array([0.0, 150.0, 300.0, 700.0, 800.0, 2000.0])) == ((0, 1, 2),)
    assert near_each_other(np.empty(0)) == ()


def test_false_alarms_without_a_gun_are_by_the_hour_and_recall_is_by_level() -> None:
    tally = Tally()
    tally.add(case([]), np.array([10.0, 20.0]), minutes=20.0, spent=SPENT)
    tally.add(case([100.0], snr_db=3.0), np.empty(0), minutes=1.0, spent=SPENT)
    tally.add(case([100.0, 400.0], snr_db=14.0), np.array([100.0]), minutes=1.0, spent=SPENT)
    score = tally.score("any")
    assert score.false_per_gun_free_hour == pytest.approx(6.0)
    assert score.recall_by_snr_db == {"0-6": 0.0, "12-22": 0.5}
    assert score.bursts is None


def test_a_shock_that_is_found_instead_keeps_its_shots_level() -> None:
    """The shock of a far shot comes before the blast of a near one: levels must not be mixed up."""
    far_and_near = Case(
        "film",
        Path("a"),
        np.array([1000.0, 1030.0]),
        np.array([30.0, 3.0]),
        np.ones(2, bool),
        alternatives_ms=((), (980.0,)),
    )
    tally = Tally()
    tally.add(far_and_near, np.array([980.0]), minutes=1.0, spent=SPENT)
    assert tally.score("any").recall_by_snr_db == {"0-6": 1.0, ">=22": 0.0}


def shot(at_ms: float, confidence: float) -> Shot:
    onset = round(at_ms * RATE_HZ / 1000.0)
    return Shot(onset, confidence, -3.0, 21.0, Span(onset, onset + 100), (), Span(onset, onset + 4800))


def heard(found_ms: list[float], refused_ms: dict[float, float]) -> Heard:
    refused = tuple(
        Rejection(round(at_ms * RATE_HZ / 1000.0), "does not sound like a shot", {"probability": p})
        for at_ms, p in refused_ms.items()
    )
    return Heard(Detection(tuple(shot(at_ms, 0.95) for at_ms in found_ms), refused), RATE_HZ, 10 * RATE_HZ, 0.1)


def test_every_error_is_told_with_what_the_detector_says_of_it() -> None:
    film = case([1000.0, 2000.0, 3000.0, 4000.0], forgiven_ms=(7000.0,))
    events = scored_events(film, heard([1000.5, 2020.0, 6000.0, 7003.0], {3004.0: 0.4}))
    assert [(event.kind, event.at_s) for event in events] == [
        ("missed", 2.0),
        ("false", 2.02),
        ("missed", 3.0),
        ("missed", 4.0),
        ("false", 6.0),
    ]
    mistimed, late, refused, unheard, false = events
    assert "+20.0 ms" in mistimed.reason
    assert "-20.0 ms" in late.reason
    assert (refused.reason, refused.probability) == ("does not sound like a shot", 0.4)
    assert unheard.probability is None
    assert (false.probability, false.level_db, false.reason) == (0.95, 21.0, "no shot near")


@pytest.mark.parametrize("at", [10, 24_000, 70_000, 95_990])
def test_an_excerpt_has_the_event_at_its_place(at: int) -> None:
    film = np.zeros(96_000, np.float32)
    film[at] = 1.0
    start = max(0, at - 30_000)
    cut = excerpt(film[start:], at, start=start, rate_hz=RATE_HZ)
    assert cut.size == 72_000
    assert np.flatnonzero(cut).tolist() == [24_000]


def test_the_folder_has_a_row_and_a_sound_for_each_error(tmp_path: Path) -> None:
    samples: NDArray[np.float64] = np.zeros(3 * RATE_HZ)
    samples[[4800, 100_000]] = 0.5, -0.25
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_16")
    film = case([100.0], path=path)
    events = scored_events(film, heard([100_000 / 48.0], {}))
    (tmp_path / "wrong").mkdir()
    write_events(tmp_path / "wrong", [(path, events)])
    with (tmp_path / "wrong" / "events.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == ["missed", "false"]
    for row, level in zip(rows, (0.5, -0.25), strict=True):
        sound, rate_hz = soundfile.read(tmp_path / "wrong" / row["excerpt"])
        assert rate_hz == RATE_HZ
        assert sound[round(EXCERPT_BEFORE_S * RATE_HZ)] == pytest.approx(level)


@pytest.mark.parametrize("name", ["film " * 40, "銃声" * 60])
def test_the_name_of_an_excerpt_is_one_that_a_file_can_have(tmp_path: Path, name: str) -> None:
    path = tmp_path / "film.wav"
    soundfile.write(path, np.zeros(RATE_HZ), RATE_HZ, subtype="PCM_16")
    (tmp_path / "wrong").mkdir()
    write_events(tmp_path / "wrong", [(path, [ScoredEvent(name, "missed", 0.5, None, None, "")])])
    (written,) = (tmp_path / "wrong").glob("missed-*.wav")
    assert len(written.name.encode()) <= 255
    assert name[-2:].strip() in written.name


def test_a_change_is_one_key_of_a_tier() -> None:
    tier = load_rules("standard").tier
    new = changed(tier, "verify.networks = 1")
    assert new.verify.networks == 1
    assert changed(new, f"verify.networks={tier.verify.networks}") == tier
    assert changed(tier, "scan.band_jump_db=off").scan.band_jump_db is None
    heard, felt = settings(), settings(felt=True)
    for every in (heard, felt):
        assert len({each.name for each in every}) == len(every) > 10
    changes = sum(len(each) for each in CHANGES.values())
    assert len(heard) + len(felt) == 6 + changes, "a change that changes nothing"
    assert all(each.tier.render == load_rules(each.quality).tier.render for each in heard)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("verify.networks=9", "verify.networks = 9"),
        ("verify.none=1", "expected TABLE.KEY=VALUE"),
        ("verify=1", "expected TABLE.KEY=VALUE"),
        ("schema.x=1", "expected TABLE.KEY=VALUE"),
        ("verify.networks", "expected TABLE.KEY=VALUE"),
        ("verify.networks=two", "expected a number"),
        ("verify.networks=off", "verify.networks"),
        ("verify.row_from='x'", "verify.row_from = 'x': expected a number or off, not a text"),
    ],
)
def test_a_change_that_does_not_fit_is_refused(change: str, complaint: str) -> None:
    with pytest.raises(RuleError, match=complaint):
        changed(load_rules("standard").tier, change)


def test_recordings_are_films_of_their_own(tmp_path: Path) -> None:
    rows = [
        "path,source,label,sub_label,duration_s,onsets_s,notes",
        "a.wav,range,gunshot,rifle,2.0,0.5;0.6;0.7,",
        "b.wav,range,gunshot,boom,2.0,0.5,slow or two-stage attack",
        "c.wav,kit,negative,drum,1.0,,",
    ]
    (tmp_path / "annotations.csv").write_text("\n".join(rows))
    burst, slow, drum = recordings(read_corpus([tmp_path]))
    assert burst.bursts == ((0, 1, 2),)
    assert not slow.timed.any()
    assert drum.true_ms.size == 0


ROWS = ("path,source,label,sub_label,duration_s,onsets_s,notes", "a.wav,range,gunshot,rifle,2.0,0.5;0.6,")


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("b.wav,range,gunshot,rifle,,0.5,", "line 3: duration_s = '': expected seconds from 0 on"),
        ("b.wav,range,gunshot,rifle,abc,0.5,", "line 3: duration_s = 'abc'"),
        ("b.wav,range,gunshot,rifle,2.0,0.5;x,", "line 3: onsets_s = '0.5;x': expected seconds from 0 on, with a semi"),
        ('b.wav,range,gunshot,rifle,2.0,"0.5,0.7",', "line 3: onsets_s = '0.5,0.7'"),
        ("b.wav,range,gunshot,rifle,2.0,-0.5,", "line 3: onsets_s = '-0.5'"),
        ("b.wav,range,gunshot,rifle,2.0,nan,", "line 3: onsets_s = 'nan'"),
        ("b.wav,range,gunshot,rifle,2.0,99,", "expected seconds before the end, at 2 s"),
        ("b.wav,range,gunshot,rifle,2.0,0.7;0.5,", "expected each later than the one before"),
        ("b.wav,range,gunshot,rifle,2.0,0.5;0.5,", "expected each later than the one before"),
        ("b.wav,range,gunshot,rifle,2.0,,", "expected the onset of each shot, as it is a gunshot"),
        ("b.wav,range,negative,drum,2.0,0.5,", "expected none, as it is a negative"),
        ("b.wav,range,Gunshot,rifle,2.0,0.5,", "line 3: label = 'Gunshot': expected gunshot or negative"),
        (",range,gunshot,rifle,2.0,0.5,", "line 3: path = '': expected a name"),
        ("b.wav,range,gunshot,rifle,2.0", "line 3: 5 cells; expected 7, as the first line names"),
        ("b.wav,range,gunshot,rifle,2.0,0.5,,,", "line 3: 9 cells; expected 7"),
        ("a.wav,range,gunshot,rifle,2.0,0.5,", "already; expected each recording once"),
        ("./a.wav,range,gunshot,rifle,2.0,0.5,", "already; expected each recording once"),
        ("a.wav,hall,negative,drum,2.0,,", "already; expected each recording once"),
    ],
)
def test_a_table_that_says_what_cannot_be_is_refused(tmp_path: Path, line: str, complaint: str) -> None:
    (tmp_path / "annotations.csv").write_text("\n".join([*ROWS, line]))
    with pytest.raises(RuleError) as told:
        read_corpus([tmp_path])
    assert complaint in str(told.value)
    assert str(tmp_path) in str(told.value)


def test_a_column_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / "annotations.csv").write_text(f"{ROWS[0]},path\n{ROWS[1]},b.wav")
    with pytest.raises(RuleError, match=r"annotations\.csv: line 1: column 'path' is there twice; expected each once"):
        read_corpus([tmp_path])


@pytest.mark.parametrize("data", [b"", "\n".join(ROWS).encode("utf-16"), "pf\u00e4d".encode("latin-1")])
def test_a_table_that_is_none_is_refused(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "annotations.csv").write_bytes(data)
    with pytest.raises(RuleError, match=r"annotations\.csv: "):
        read_corpus([tmp_path])


def test_two_sounds_of_one_name_in_two_folders_are_two(tmp_path: Path) -> None:
    rows = [ROWS[0], *(f"{folder}/shot.wav,range,gunshot,rifle,2.0,0.5," for folder in ("near", "far"))]
    (tmp_path / "annotations.csv").write_text("\n".join(rows))
    assert [each.name for each in recordings(read_corpus([tmp_path]))] == ["range/near/shot.wav", "range/far/shot.wav"]


def test_timing_is_told_of_the_onset_that_is_nearest() -> None:
    true_ms = [1000.0, 2000.0, 3000.0]
    found_ms = np.sort(np.concatenate([true_ms, np.array(true_ms) - 40.0]))
    tally = Tally()
    tally.add(case(true_ms), found_ms, minutes=0.1, spent=SPENT)
    timing = tally.score("any").timing
    assert timing is not None
    assert (timing.shots, timing.p95_ms) == (3, 0.0)


def test_what_another_shot_was_found_by_is_not_said_to_be_near() -> None:
    found = heard([1000.0], {})
    missed, *others = scored_events(case([1000.0, 1030.0]), found)
    assert others == []
    assert "away" not in missed.reason
    (missed, false) = scored_events(case([1000.0]), heard([1030.0], {}))
    assert missed.reason == "found +30.0 ms away"
    assert false.kind == "false"
