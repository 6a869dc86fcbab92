"""Choosing the quality by a budget: laws of the choice and of the prediction, and a budget that makes no sense."""

import errno
import gc
import itertools
import tracemalloc
from pathlib import Path
from typing import Any, get_args

import msgspec
import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from blastline.errors import OutputError, RuleError
from blastline.model import Quality, Timeline
from blastline.report import MAX_FIGURES
from blastline.run import gauge as gauges
from blastline.run import sampling
from blastline.run.budget import BEST_FIRST, RESERVE, Allowance, allowance, choose_quality, chosen, pick
from blastline.run.checking import checked
from blastline.run.costs import FilmCost
from blastline.run.listening import HeardFilm, listen
from blastline.run.options import RenderOptions
from blastline.run.rendering import write_report_of
from blastline.run.sampling import EXCERPT_FRAMES, counted_s, room_for_samples, sample_film, timed_s
from blastline.soundtrack import Soundtrack, open_soundtrack
from blastline.study.codecs import encode
from commands import RATE_HZ, blastline, write_film
from render_signals import shot_at

SECONDS = st.floats(1e-3, 1e5)
COSTS = st.builds(FilmCost, SECONDS, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 2.0))


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "film.wav", length_s=14.0, shots_s=(3.0, 9.0))


def test_every_quality_can_be_picked() -> None:
    assert set(BEST_FIRST) == set(get_args(Quality))


@given(st.dictionaries(st.sampled_from(BEST_FIRST), SECONDS, min_size=3), SECONDS, SECONDS)
def test_a_bigger_budget_never_picks_a_less_accurate_quality(
    predicted: dict[Quality, float], one_s: float, other_s: float
) -> None:
    less, more = (pick(predicted.__getitem__, allowed_s, lambda: 0.0) for allowed_s in sorted((one_s, other_s)))
    if less is not None:
        assert more is not None
        assert BEST_FIRST.index(more) <= BEST_FIRST.index(less)


@given(st.dictionaries(st.sampled_from(BEST_FIRST), SECONDS, min_size=3), SECONDS)
def test_what_is_picked_fits_and_nothing_better_does(predicted: dict[Quality, float], allowed_s: float) -> None:
    asked: list[Quality] = []

    def predict(quality: Quality) -> float:
        asked.append(quality)
        return predicted[quality]

    picked = pick(predict, allowed_s, lambda: 0.0)
    assert asked == list(BEST_FIRST[: len(asked)])
    fits = [RESERVE * predicted[quality] <= allowed_s for quality in asked]
    assert picked == (asked[-1] if picked else None)
    assert not any(fits[:-1])
    assert fits[-1] == (picked is not None)


@given(st.dictionaries(st.sampled_from(BEST_FIRST), SECONDS, min_size=3), SECONDS, st.integers(0, 2))
def test_once_predicting_has_spent_the_budget_the_fastest_alone_is_predicted(
    predicted: dict[Quality, float], allowed_s: float, enough_for: int
) -> None:
    asked: list[Quality] = []

    def predict(quality: Quality) -> float:
        asked.append(quality)
        return 2.0 * allowed_s + predicted[quality]

    assert pick(predict, allowed_s, lambda: allowed_s if len(asked) >= enough_for else 0.0) is None
    assert asked == [*BEST_FIRST[: min(enough_for, 2)], BEST_FIRST[-1]]


@given(COSTS, st.floats(1.0, 1e4), st.floats(1.0, 10.0))
def test_a_longer_film_costs_more_but_no_more_than_in_proportion(cost: FilmCost, film_s: float, times: float) -> None:
    varying = cost.of(film_s) - cost.fixed_s
    longer = cost.of(times * film_s) - cost.fixed_s
    assert varying - 1e-6 <= longer <= times * varying * (1.0 + 1e-9) + 1e-6


@given(COSTS, st.floats(1.0, 1e4), st.floats(1.0, 10.0))
def test_without_pictures_the_prediction_scales_with_the_film(cost: FilmCost, film_s: float, times: float) -> None:
    plain = FilmCost(cost.fixed_s, cost.per_second, cost.per_shot, 0.0, cost.shots_per_s)
    longer = plain.of(times * film_s) - plain.fixed_s
    assert longer == pytest.approx(times * (plain.of(film_s) - plain.fixed_s), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("shots", [1, MAX_FIGURES, 100 * MAX_FIGURES])
def test_a_report_draws_each_shot_but_no_more_than_it_has_room_for(shots: int) -> None:
    assert FilmCost(0.0, 0.0, 0.0, 2.0, 0.25).of(4.0 * shots) == 2.0 * min(shots, MAX_FIGURES)


@given(SECONDS)
def test_a_sample_is_part_of_the_film_and_shots_are_counted_in_no_less_than_is_timed(film_s: float) -> None:
    assert 0.0 < timed_s(film_s) <= counted_s(film_s) <= film_s


@pytest.mark.parametrize("text", ["90", "90s", "90 s", "1.5min", " 1.5 min", "0.025h", ".025 h"])
def test_a_time_can_be_said_in_many_ways(text: str) -> None:
    allowed = allowance(budget=text, max_cost=None, quality=None)
    assert allowed is not None
    assert allowed.of(7200.0) == pytest.approx(90.0)


def test_a_cost_is_per_second_of_film() -> None:
    allowed = allowance(budget=None, max_cost=0.01, quality=None)
    assert allowed is not None
    assert allowed.of(7200.0) == pytest.approx(72.0)
    assert allowance(budget=None, max_cost=None, quality="draft") is None


def test_what_is_measured_is_checked_as_the_run_will_be(film: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Timeline] = []

    def spied(timeline: Timeline, *rest: Any, **options: Any) -> Timeline:
        seen.append(timeline)
        return checked(timeline, *rest, **options)

    monkeypatch.setattr(gauges, "checked", spied)
    options = RenderOptions(phase="zero", background="direct", level_db=-6.0, report=False)
    choose_quality(film, Allowance("--budget 1h", cpu_s=3600.0), options, drives=True, since_cpu_s=0.0)
    assert {(made.phase, made.background, made.level_db) for made in seen} == {("zero", "direct", -6.0)}


def test_of_a_window_with_many_shots_a_few_are_rendered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A minute of one machine gun is one window: to render all of it would cost more than the budget."""
    seen: list[int] = []
    shots = [shot_at(RATE_HZ + number * 4_000, decay_ms=200.0, rate_hz=RATE_HZ) for number in range(100)]

    def one_window(*heard: Any) -> HeardFilm:
        return gauges.with_shots(listen(*heard), shots, heard[1])

    def counted(timeline: Timeline, *rest: Any, **options: Any) -> Timeline:
        seen.append(len(timeline.events))
        return checked(timeline, *rest, **options)

    monkeypatch.setattr(gauges, "listen", one_window)
    monkeypatch.setattr(gauges, "checked", counted)
    monkeypatch.setattr(gauges, "process_time", lambda: float(sum(seen)))  # a clock that each shot moves by a second
    path = tmp_path / "film.wav"
    soundfile.write(path, 0.1 * np.random.default_rng(1).standard_normal(12 * RATE_HZ), RATE_HZ)
    with gauges.open_gauge(path, RenderOptions(report=False), drives=True) as gauge:
        cost = gauge.cost("draft")
    assert max(seen) < 2 * gauges.FEW_SHOTS
    assert cost.shots_per_s * gauge.film_s == pytest.approx(100.0)
    assert cost.per_shot == pytest.approx(1.0)


def test_the_cost_does_not_depend_on_what_the_process_has_used_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_film(tmp_path / "film.wav", length_s=8.0, shots_s=(3.0,))
    costs = []
    for used_s in (0.0, 4096.0):
        clock = itertools.count(used_s)  # goes on by a second whenever it is read
        for module in (gauges, sampling):
            monkeypatch.setattr(module, "process_time", lambda clock=clock: float(next(clock)))
        with gauges.open_gauge(path, RenderOptions(report=False), drives=False) as gauge:
            costs.append(gauge.cost("draft"))
    assert costs[0] == costs[1]
    assert costs[0].per_second > 0.0


def test_pictures_are_timed_without_looking_through_what_was_there_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full collection of garbage takes as long as two pictures: it may not fall among the three that are timed."""
    spared: list[bool] = []

    def watched(*of: Any, **options: Any) -> None:
        spared.append(gc.get_freeze_count() > 0)
        write_report_of(*of, **options)

    monkeypatch.setattr(gauges, "write_report_of", watched)
    path = tmp_path / "film.wav"
    soundfile.write(path, 0.1 * np.random.default_rng(1).standard_normal(12 * RATE_HZ), RATE_HZ)
    with gauges.open_gauge(path, RenderOptions(), drives=True) as gauge:
        gauge.cost("draft")
    assert len(spared) > 2
    assert all(spared[1:])  # the first only warms up
    assert gc.get_freeze_count() == 0


@given(SECONDS, SECONDS, st.booleans())
def test_the_budget_that_would_do_does(needed_s: float, film_s: float, by_time: bool) -> None:
    allowed = Allowance("x", cpu_s=1.0) if by_time else Allowance("x", cpu_per_s=1.0)
    option, value = allowed.in_words(needed_s, film_s).split()
    named = (
        allowance(budget=value, max_cost=None, quality=None)
        if option == "--budget"
        else allowance(budget=None, max_cost=float(value), quality=None)
    )
    assert named is not None
    assert needed_s * (1.0 - 1e-6) <= named.of(film_s) <= 1.11 * needed_s


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (
            "--budget soon",
            "--budget soon: expected a CPU time of more than 0, up to 1000000000 s, such as 90s",
        ),
        ("--budget 0", "--budget 0: expected a CPU time"),
        ("--budget -5s", "--budget -5s: expected a CPU time"),
        ("--budget 1e3", "--budget 1e3: expected a CPU time"),
        ("--budget 2days", "--budget 2days: expected a CPU time"),
        ("--max-cost 0", "--max-cost 0: expected CPU seconds per second of film"),
        ("--max-cost nan", "--max-cost nan: expected CPU seconds"),
        ("--max-cost inf", "--max-cost inf: expected CPU seconds"),
        ("--max-cost 1e308", "--max-cost 1e+308: expected CPU seconds"),
        ("--budget " + "9" * 400, f"--budget {'9' * 40}: expected a CPU time"),
        ("--max-cost much", "--max-cost 'much': expected a number"),
        ("--max-cost 1 --budget 2min", "--budget and --max-cost: expected one of them"),
        ("--quality draft --budget 2min", "--quality draft and --budget: expected one of them"),
        ("--quality draft --max-cost 1", "--quality draft and --max-cost: expected one of them"),
    ],
)
def test_a_wrong_budget_is_one_line(film: Path, tmp_path: Path, options: str, complaint: str) -> None:
    assert complaint in blastline("detect", film, *options.split()).complaint
    assert complaint in blastline("render", film, "-o", tmp_path / "out", *options.split()).complaint
    assert not (tmp_path / "out").exists()


def test_a_budget_too_small_names_one_that_would_do(film: Path, tmp_path: Path) -> None:
    ended = blastline("detect", film, "--budget", "0.001s", "--quiet", "-o", tmp_path / "t.json")
    assert "draft, the fastest quality, takes about" in ended.complaint
    others = "and what measuring the other qualities takes"  # spent before they were
    assert ended.complaint.endswith(f"s, {others}, would do, and --quality draft measures nothing")
    assert not (tmp_path / "t.json").exists()


def test_an_earlier_result_is_refused_before_anything_is_measured(film: Path, tmp_path: Path) -> None:
    (tmp_path / "drive.wav").write_bytes(b"earlier")
    ended = blastline("render", film, "-o", tmp_path, "--budget", "1h")
    assert ended.code == 2
    assert "drive.wav: exists already" in ended.err
    assert "measuring" not in ended.err


def test_a_generous_budget_takes_the_most_accurate_and_says_so(film: Path, tmp_path: Path) -> None:
    ended = blastline("detect", film, "--budget", "2h", "-o", tmp_path / "t.json")
    made = msgspec.json.decode((tmp_path / "t.json").read_bytes(), type=Timeline)
    assert ended.code == 0
    assert made.budget is not None
    assert (made.quality, made.budget.asked, made.budget.allowed_cpu_s) == ("reference", "--budget 2h", 7200.0)
    assert set(made.budget.predicted_cpu_s) == {"reference"}
    assert made.budget.note in ended.err.splitlines()
    assert "nothing more accurate was given up" in made.budget.note
    plain = blastline("detect", film, "--quality", "reference", "--quiet").out
    assert msgspec.structs.replace(made, budget=None) == msgspec.json.decode(plain, type=Timeline)


def test_the_report_says_how_the_quality_was_chosen(film: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    ended = blastline("render", film, "-o", out, "--max-cost", "100", "--quiet")
    assert ended.code in (0, 1)
    made = msgspec.json.decode((out / "timeline.json").read_bytes(), type=Timeline)
    assert made.budget is not None
    assert made.budget.note in (out / "report.html").read_text(encoding="utf-8")
    assert made.budget.note not in ended.err


def test_what_was_given_up_is_named() -> None:
    note = chosen(Allowance("--budget 9s"), 9.0, "draft", {"reference": 30.0, "standard": 12.0, "draft": 5.0})
    assert "quality draft, about 5 s of the 9 s" in note
    assert note.endswith("given up: standard, about 12 s, reference, about 30 s")


def test_an_edited_timeline_has_no_budget(film: Path) -> None:
    with pytest.raises(RuleError, match=r"--budget 9s with --timeline cut\.csv: nothing is detected"):
        choose_quality(film, Allowance("--budget 9s", cpu_s=9.0), RenderOptions(timeline=Path("cut.csv")))


def tones(seconds: int) -> np.ndarray:
    """Return a tone for each second, each 100 Hz above the one before."""
    at = np.arange(RATE_HZ) / RATE_HZ
    return np.concatenate([0.5 * np.sin(2.0 * np.pi * 100.0 * (n + 2) * at) for n in range(seconds)])


def pitch(samples: np.ndarray) -> float:
    """Return the frequency of the middle of a sound."""
    middle = samples[samples.size // 2 - 4800 : samples.size // 2 + 4800]
    return float(np.argmax(np.abs(np.fft.rfft(middle))) * RATE_HZ / middle.size)


@pytest.mark.parametrize("kind", ["wav", "mkv"])
def test_a_stretch_is_from_where_it_is_asked_for(tmp_path: Path, kind: str) -> None:
    path, samples = tmp_path / f"film.{kind}", tones(12)
    if kind == "wav":
        soundfile.write(path, samples, RATE_HZ, subtype="PCM_16")
    else:
        encode(path, samples[:, None].astype(np.float32), "ac3", bits_per_s=192_000, rate_hz=RATE_HZ)
    for second in (9, 2, 6):
        with open_soundtrack(path) as track:
            near = track.read_approximately(second + 0.35, 0.3)[: round(0.3 * RATE_HZ), 0]
        late_s = second - (pitch(near) / 100.0 - 2.0)
        assert abs(late_s) < 0.1


def test_a_sample_is_taken_from_all_over_the_film(tmp_path: Path) -> None:
    film = tmp_path / "long.wav"
    quiet = np.zeros(100 * RATE_HZ, np.float32)
    quiet[60 * RATE_HZ :] = 0.25
    soundfile.write(film, quiet, RATE_HZ, subtype="PCM_16")
    with open_soundtrack(film) as track:
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=False)
    taken, _ = soundfile.read(sample.path)
    assert sample.film_s == pytest.approx(100.0)
    assert taken.size == round(sample.seconds * RATE_HZ)
    assert sample.seconds == pytest.approx(timed_s(100.0), rel=0.3)
    assert 0.1 < np.mean(np.abs(taken) > 0.1) < 0.6


@pytest.mark.parametrize("length_s", [20, 100])
def test_what_decoding_takes_is_told_for_a_second_of_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, length_s: int
) -> None:
    film, used_s = tmp_path / "film.wav", [0.0]
    soundfile.write(film, np.full(length_s * RATE_HZ, 0.25, np.float32), RATE_HZ, subtype="PCM_16")
    plain = Soundtrack.read_approximately

    def half_as_long(track: Soundtrack, start_s: float, seconds: float, **how: bool) -> Any:
        used_s[0] += 0.5 * seconds
        return plain(track, start_s, seconds, **how)

    monkeypatch.setattr(Soundtrack, "read_approximately", half_as_long)
    monkeypatch.setattr(sampling, "process_time", lambda: used_s[0])
    with open_soundtrack(film) as track:
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=False)
    assert sample.decode_per_s == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(
    ("number", "name", "told"),
    [(errno.ENOSPC, None, True), (errno.ENOSPC, "out/drive.wav", False), (errno.EIO, None, False)],
)
def test_a_disk_too_full_for_samples_is_told_and_no_other_error_is_taken_for_that(
    number: int, name: str | None, *, told: bool
) -> None:
    with pytest.raises(OutputError if told else OSError) as raised, room_for_samples():
        raise OSError(number, "no room", name)
    assert isinstance(raised.value, OutputError) == told
    assert ("cannot write what the budget is tried on: no room" in str(raised.value)) == told


def test_a_sample_joins_without_a_step_and_knows_its_loudest_frame(tmp_path: Path) -> None:
    film = tmp_path / "even.wav"
    even = np.full(100 * RATE_HZ, 0.25, np.float32)
    even[71 * RATE_HZ : 71 * RATE_HZ + 4] = 0.9  # may be in it or not
    soundfile.write(film, even, RATE_HZ, subtype="PCM_16")
    with open_soundtrack(film) as track:
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=False)
    taken, _ = soundfile.read(sample.path)
    assert abs(taken[sample.loudest]) == np.abs(taken).max()
    assert np.abs(np.diff(taken[np.abs(taken) < 0.5])).max() < 0.01
    assert np.sum(taken < 0.05) > 400  # faded where two stretches meet


@pytest.mark.parametrize(("begin", "end"), [(0.1, 0.6), (0.6, 0.1), (-0.1, -0.6)])
def test_a_sample_knows_its_loudest_frame_in_whichever_part_it_lies(tmp_path: Path, begin: float, end: float) -> None:
    film = tmp_path / "ramp.wav"
    soundfile.write(film, np.linspace(begin, end, 30 * RATE_HZ), RATE_HZ, subtype="PCM_16")
    with open_soundtrack(film) as track:
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=False)
    taken, _ = soundfile.read(sample.path)
    assert sample.seconds < 15.0, "more than one part, and not all of the film"
    assert abs(taken[sample.loudest]) == np.abs(taken).max()


def test_a_sample_is_heard_as_the_film_is_with_its_centre_and_without(tmp_path: Path) -> None:
    film = tmp_path / "film.wav"
    channels = np.random.default_rng(11).uniform(-0.1, 0.1, (9 * RATE_HZ, 6))
    soundfile.write(film, channels, RATE_HZ, subtype="PCM_24")
    with open_soundtrack(film) as track:
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=True)
    assert sample.seconds == pytest.approx(9.0)
    with open_soundtrack(film) as there, open_soundtrack(sample.path) as here:
        for one, other in zip(there.blocks(sides=True), here.blocks(sides=True), strict=True):
            assert one.sides is not None
            assert other.sides is not None
            np.testing.assert_allclose(other.heard, one.heard, atol=3.0 / 32_768)
            np.testing.assert_allclose(other.sides, one.sides, atol=3.0 / 32_768)


def test_a_sample_is_in_memory_a_stretch_at_a_time(tmp_path: Path) -> None:
    film, rate_hz = tmp_path / "long.wav", 8_000
    soundfile.write(film, np.zeros(20 * 60 * rate_hz, np.int16), rate_hz, subtype="PCM_16")
    with open_soundtrack(film) as track:
        tracemalloc.start()
        sample = sample_film(film, track, tmp_path / "sample.wav", counted=True)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert sample.seconds == pytest.approx(20 * 60, rel=0.05)
    assert sample.seconds / sample.stride == pytest.approx(timed_s(20 * 60), rel=0.05)
    excerpt_bytes = EXCERPT_FRAMES * np.dtype(np.float32).itemsize
    assert most < 4 * excerpt_bytes < 0.4 * sample.seconds * rate_hz * np.dtype(np.float32).itemsize


def test_beyond_the_end_of_a_film_there_is_nothing(film: Path) -> None:
    with open_soundtrack(film) as track:
        assert track.read_approximately(13.9, 30.0).shape[0] == round(0.1 * RATE_HZ)
        assert track.read_approximately(99.0, 1.0).shape == (0, 1)
