"""`blastline conform` and `blastline study conform` as a user runs them."""

import csv
import hashlib
import re
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline.conform import Course, Placed, write_events, write_stretches
from blastline.conform.lines import Line
from blastline.conform.segments import MatchedSegment
from blastline.export import read_timeline
from blastline.model import (
    SCHEMA,
    Decision,
    DriveInfo,
    Event,
    Reflection,
    Rejection,
    Source,
    Span,
    Timeline,
    Window,
    encode,
)
from blastline.ruleset import load_rules
from blastline.study.conforming import made_film, score_one
from blastline.study.cuts import CASES
from blastline.timebase import parse_timebase, retimed
from blastline.timecode import timecode_at
from commands import blastline, write_wave
from conform_films import RATE_HZ, Samples, bang, film, murmur, put, seconds
from moments import moments

ONSETS_S = (2.0, 7.25, 12.0, 16.0, 18.5, 23.0)
OLD = 0.2 * film(26.0, ONSETS_S, seed=40)
NEW = np.concatenate([seconds(OLD, 3.0, 10.0), seconds(OLD, 14.0, 26.0)])
EXPECTED = {"shot-2": 4.25, "shot-4": 9.0, "shot-5": 11.5, "shot-6": 16.0}


def event(number: int, onset_s: float) -> Event:
    at = round(onset_s * RATE_HZ)
    return Event(
        id=f"shot-{number}",
        onset_sample=at,
        onset_s=at / RATE_HZ,
        timecode="",
        confidence=0.9,
        burst=None,
        shot_in_burst=None,
        peak_dbfs=-6.0,
        snr_db=30.0,
        blast=Span(at, at + 160),
        reflections=(Reflection(at + 800, at + 960, 50.0, -9.0),),
        window=Window(at - 96, at + 4_800, 80, 640),
        drive=DriveInfo("direct", "asked for", 0.5, 0.0, 1.0),
    )


def timeline_of(film_path: Path, frames: int) -> Path:
    source = Source(film_path.name, hashlib.sha256(film_path.read_bytes()).hexdigest(), RATE_HZ, frames, 1)
    events = tuple(event(number, onset_s) for number, onset_s in enumerate(ONSETS_S, start=1))
    made = Timeline(SCHEMA, "0.1.0", "standard", "ab" * 32, source, None, events, (), ())
    path = film_path.with_name("timeline.json")
    path.write_bytes(encode(made))
    return path


def with_windows(timeline: Path, window_of: Callable[[Event], Window]) -> None:
    """Give each event of a timeline another window."""
    found = read_timeline(timeline)
    events = tuple(msgspec.structs.replace(each, window=window_of(each)) for each in found.events)
    timeline.write_bytes(encode(msgspec.structs.replace(found, events=events)))


def in_pal(path: Path) -> Path:
    """Write the old film at 25 frames for 24."""
    import soxr

    return write_wave(path, soxr.resample(OLD, RATE_HZ * 25 / 24, 48_000), rate_hz=48_000)


@pytest.fixture
def films(tmp_path: Path) -> tuple[Path, Path, Path]:
    old = write_wave(tmp_path / "old.wav", OLD, rate_hz=RATE_HZ)
    return timeline_of(old, len(OLD)), old, write_wave(tmp_path / "new.wav", 0.5 * NEW, rate_hz=RATE_HZ)


def test_a_new_cut_gets_its_timeline_and_its_tables(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    assert ended.code == 0
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert {each.id: each.onset_s for each in made.events} == pytest.approx(EXPECTED, abs=1e-4)
    assert made.source.name == "new.wav"
    assert made.source.frames == len(NEW)
    assert [each.reason.split(":")[0] for each in made.rejections] == ["shot-1", "shot-3"]
    assert all(each.drive is None for each in made.events)
    with (tmp_path / "out" / "conform.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["placed"] for row in rows] == ["no", "yes", "no", "yes", "yes", "yes"]
    assert all(abs(float(row["residual_ms"])) < 0.1 for row in rows if row["placed"] == "yes")
    with (tmp_path / "out" / "stretches.csv").open() as file:
        assert [round(float(row["old_start_s"])) for row in csv.DictReader(file)] == [3, 14]
    assert "4 of 6 shots placed, 2 not" in ended.out
    assert ended.err.count("not placed: shot-") == 2


def test_a_result_is_moved_by_its_folder_as_by_its_timeline(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    result = tmp_path / "result"
    result.mkdir()
    timeline.rename(result / "timeline.json")
    for name, given in (("by-folder", result), ("by-file", result / "timeline.json")):
        assert blastline("conform", given, "--from", old, "--to", new, "-o", tmp_path / name).code == 0
    folder, file = ((tmp_path / name / "timeline.json").read_bytes() for name in ("by-folder", "by-file"))
    assert folder == file
    ended = blastline("conform", result, "--from", old, "--to", new, "-o", result, "--overwrite")
    assert "is the old timeline; choose another folder for the new one" in ended.complaint


def test_old_and_new_places_are_told_in_the_timecode_of_either_film(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, new = films
    said = retimed(read_timeline(timeline), parse_timebase("01:00:00:00", "24"))
    timeline.write_bytes(encode(said))
    new_says = ("--start-timecode", "10:00:00:00", "--frame-rate", "25")
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out", *new_says)
    assert ended.code == 0, ended
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert (made.source.start_timecode, made.source.frame_rate) == ("10:00:00:00", "25")
    with (tmp_path / "out" / "conform.csv").open() as file:
        rows = {row["id"]: row for row in csv.DictReader(file)}
    assert {each.id: each.timecode for each in said.events} == {name: row["old_timecode"] for name, row in rows.items()}
    placed = {name: row["new_timecode"] for name, row in rows.items() if row["placed"] == "yes"}
    assert placed == {each.id: each.timecode for each in made.events}
    missing = {each.reason.split(":")[0]: timecode_at(made.source, each.at_sample) for each in made.rejections}
    assert missing == {name: row["new_timecode"] for name, row in rows.items() if row["placed"] == "no"}
    for name, at in missing.items():
        assert re.search(rf"{name}: .*\(old film {rows[name]['old_timecode']}, .* at {at}\)", ended.err)


def test_a_film_without_shots_gets_an_empty_timeline_and_its_stretches(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, new = films
    timeline.write_bytes(encode(msgspec.structs.replace(read_timeline(timeline), events=())))
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    assert (ended.code, "0 of 0 shots placed" in ended.out) == (0, True), ended
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert (made.events, made.rejections, made.source.name) == ((), (), "new.wav")
    with (tmp_path / "out" / "stretches.csv").open() as file:
        assert [float(row["old_start_s"]) for row in csv.DictReader(file)] == pytest.approx([3.0, 14.0], abs=0.02)


def test_what_rounds_to_nothing_has_no_sign_in_the_tables(tmp_path: Path) -> None:
    course = Course(MatchedSegment(Line(1.0, -1e-9, 0.0, 9.0), 0.0, 9.0, 0.9), 1.0, 0.0, 6)
    write_stretches(tmp_path / "stretches.csv", [course])
    write_events(
        tmp_path / "conform.csv",
        [event(1, 2.0)],
        [Placed(2.0, -1e-6, 0.9, 0)],
        source=Source("f", "0", 8_000, 80_000, 1),
    )
    assert "-0.0" not in (tmp_path / "stretches.csv").read_text() + (tmp_path / "conform.csv").read_text()


def test_every_span_of_an_event_moves_with_it(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    before = {each.id: each for each in read_timeline(timeline).events}
    for after in read_timeline(tmp_path / "out" / "timeline.json").events:
        by = after.onset_sample - before[after.id].onset_sample
        assert after.blast == Span(before[after.id].blast.start + by, before[after.id].blast.stop + by)
        [echo] = after.reflections
        assert (echo.start - after.onset_sample, echo.stop - after.onset_sample) == (800, 960)
        assert (echo.delay_ms, echo.level_db) == pytest.approx((50.0, -9.0))
        assert after.window.start < after.onset_sample < after.window.stop <= len(NEW)
        assert after.peak_dbfs == pytest.approx(-12.02, abs=0.01)


@pytest.mark.parametrize("length_ms", [4, 20, 60, 300])
@pytest.mark.parametrize("faster", [False, True])
def test_no_window_ends_later_than_the_old_one_did(
    films: tuple[Path, Path, Path], tmp_path: Path, length_ms: int, faster: bool
) -> None:
    """Who has set an end keeps it, also where it leaves less room than the rules' fade-out, or than the blast."""
    timeline, old, new = films
    length = length_ms * RATE_HZ // 1000
    with_windows(timeline, lambda e: Window(e.onset_sample - 96, e.onset_sample + length, 80, min(640, length // 2)))
    new = in_pal(tmp_path / "pal.wav") if faster else new
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert len(made.events) >= len(EXPECTED)
    for each in made.events:
        lasts_ms = (each.window.stop - each.onset_sample) / made.source.sample_rate_hz * 1000.0
        assert lasts_ms == pytest.approx(length_ms * (0.96 if faster else 1.0), abs=0.05)
        assert each.window.fits_fades


def test_what_the_old_timeline_turned_down_moves_with_its_scene(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    places_s = {"deleted by hand": 5.0, "in no new scene": 12.5, "does not sound like a shot": 20.0}
    turned_down = tuple(Rejection(round(at_s * RATE_HZ), why, {"probability": 0.4}) for why, at_s in places_s.items())
    timeline.write_bytes(encode(msgspec.structs.replace(read_timeline(timeline), rejections=turned_down)))
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    assert (ended.code, ended.err.count("not placed: ")) == (0, 2), ended
    made = read_timeline(tmp_path / "out" / "timeline.json").rejections
    assert [each.at_sample for each in made] == sorted(each.at_sample for each in made)
    moved = {each.reason: each for each in made if each.reason in places_s}
    assert {why: each.at_sample / RATE_HZ for why, each in moved.items()} == pytest.approx(
        {"deleted by hand": 2.0, "does not sound like a shot": 13.0}, abs=1e-4
    )
    assert all(each.evidence == {"probability": 0.4} for each in moved.values())


@pytest.mark.parametrize("seed", range(40, 48))
def test_a_copy_keeps_what_was_turned_down_from_the_first_sample_to_the_last(tmp_path: Path, seed: int) -> None:
    sound = 0.2 * film(8.0, (2.0, 5.5), seed=seed)
    old, new = (write_wave(tmp_path / name, sound, rate_hz=RATE_HZ) for name in ("old.wav", "copy.wav"))
    source = Source(old.name, hashlib.sha256(old.read_bytes()).hexdigest(), RATE_HZ, len(sound), 1)
    places = [0, 1, 70_000, len(sound) - 2, len(sound) - 1]
    turned_down = tuple(Rejection(at, "soft", {}) for at in places)
    timeline = tmp_path / "timeline.json"
    timeline.write_bytes(encode(Timeline(SCHEMA, "0.1.0", "standard", "ab" * 32, source, None, (), turned_down, ())))
    assert blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out").code == 0
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert [each.at_sample for each in made.rejections] == places


@pytest.mark.parametrize("lead_ms", [0, 2, 30])
@pytest.mark.parametrize("faster", [False, True])
def test_a_window_begins_where_somebody_has_set_its_start(
    films: tuple[Path, Path, Path], tmp_path: Path, lead_ms: int, faster: bool
) -> None:
    timeline, old, new = films
    lead = lead_ms * RATE_HZ // 1000
    with_windows(timeline, lambda e: Window(e.onset_sample - lead, e.onset_sample + 4_800, min(80, lead // 2), 640))
    new = in_pal(tmp_path / "pal.wav") if faster else new
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert {each.id for each in made.events} >= set(EXPECTED)
    for each in made.events:
        before_ms = (each.onset_sample - each.window.start) / made.source.sample_rate_hz * 1000.0
        assert before_ms == pytest.approx(lead_ms * (0.96 if faster else 1.0), abs=0.05)


def test_a_start_that_somebody_has_set_does_not_reach_out_of_its_scene(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, new = films
    early = 3 * RATE_HZ  # the fourth shot is two seconds into its scene
    with_windows(
        timeline, lambda e: Window(e.onset_sample - early, e.window.stop, 80, 640) if e.id == "shot-4" else e.window
    )
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    made = {each.id: each for each in read_timeline(tmp_path / "out" / "timeline.json").events}
    assert made["shot-4"].window.start == pytest.approx(7.0 * RATE_HZ, abs=RATE_HZ // 50)


def test_a_shot_in_a_scene_that_was_dubbed_over_is_felt_to_its_end(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    """The films part where another sound begins, but the shot in it is still there, and its echo with it."""
    timeline, old, _ = films
    dubbed = OLD.copy()
    since = 21 * RATE_HZ
    dubbed[since:] = 0.2 * murmur(5.0, seed=977)
    put(dubbed, 0.2 * bang(seed=40_005), ONSETS_S[-1])
    new = write_wave(tmp_path / "dubbed.wav", dubbed, rate_hz=RATE_HZ)
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    with (tmp_path / "out" / "stretches.csv").open(newline="") as file:
        [stretch] = csv.DictReader(file)
    assert float(stretch["old_stop_s"]) == pytest.approx(21.0, abs=0.05)
    before, after = (read_timeline(path).events[-1] for path in (timeline, tmp_path / "out" / "timeline.json"))
    assert (after.window, after.blast, after.reflections) == (before.window, before.blast, before.reflections)


def test_no_window_reaches_into_the_scene_after_its_own(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    long = 4 * RATE_HZ  # the second shot is 2.75 seconds before the end of its scene
    with_windows(
        timeline, lambda e: Window(e.window.start, e.onset_sample + long, 80, 640) if e.id == "shot-2" else e.window
    )
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    made = {each.id: each for each in read_timeline(tmp_path / "out" / "timeline.json").events}
    assert made["shot-2"].window.stop == pytest.approx(7.0 * RATE_HZ, abs=RATE_HZ // 50)
    assert made["shot-2"].window.fade_out_samples > 0


def test_a_moved_timeline_names_the_rules_that_its_windows_are_planned_by(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, new = films
    longer = tmp_path / "rules" / "quality" / "standard.toml"
    longer.parent.mkdir(parents=True)
    longer.write_text('schema = 1\nsource = "a test"\n[windows]\nsource = "a test"\nfade_out_ms = 50.0\n')
    blastline("conform", timeline, "--from", old, "--to", new, "--rules", tmp_path / "rules", "-o", tmp_path / "out")
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert made.rules_digest == load_rules("standard", tmp_path / "rules").digest
    assert made.rules_digest != read_timeline(timeline).rules_digest


def test_windows_are_planned_by_the_rules_of_a_user(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    """Where the built-in rules planned a start, nobody has set it; where somebody has, it stays."""
    timeline, old, new = films
    with_windows(
        timeline,
        lambda e: Window(
            e.onset_sample - (400 if e.id == "shot-4" else 96), e.window.stop, 80, e.window.fade_out_samples
        ),
    )
    longer = tmp_path / "rules" / "quality" / "standard.toml"
    longer.parent.mkdir(parents=True)
    longer.write_text('schema = 1\nsource = "a test"\n[windows]\nsource = "a test"\nfade_in_ms = 20.0\n')
    blastline("conform", timeline, "--from", old, "--to", new, "--rules", tmp_path / "rules", "-o", tmp_path / "out")
    leads = {
        each.id: each.onset_sample - each.window.start
        for each in read_timeline(tmp_path / "out" / "timeline.json").events
    }
    assert leads.pop("shot-4") == 400
    assert set(leads.values()) == {21 * RATE_HZ // 1000}  # 20 ms of fade-in, and the guard of 1 ms


def test_what_is_left_of_a_burst_is_numbered_anew(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    found = read_timeline(timeline)
    fired = [
        msgspec.structs.replace(each, burst=1, shot_in_burst=number)
        for number, each in enumerate(found.events, start=1)
    ]
    timeline.write_bytes(encode(msgspec.structs.replace(found, events=tuple(fired))))
    blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    made = read_timeline(tmp_path / "out" / "timeline.json").events
    assert made
    assert {(each.burst, each.shot_in_burst) for each in made} == {(None, None)}, "all are seconds apart"


@pytest.mark.parametrize("fade_in_ms", [5.0, 20.0])
def test_what_is_said_of_a_window_holds_where_it_moves_as_it_is(
    films: tuple[Path, Path, Path], tmp_path: Path, fade_in_ms: float
) -> None:
    timeline, old, new = films
    found = read_timeline(timeline)
    over = Decision("window", "80 ms", "it is over by then", {})
    none = Decision("reflections", "none", "it has none", {})
    said = tuple(msgspec.structs.replace(each, decisions=(over, none)) for each in found.events)
    timeline.write_bytes(encode(msgspec.structs.replace(found, events=said)))
    rules = tmp_path / "rules" / "quality" / "standard.toml"
    rules.parent.mkdir(parents=True)
    rules.write_text(f'schema = 1\nsource = "a test"\n[windows]\nsource = "a test"\nfade_in_ms = {fade_in_ms}\n')
    blastline("conform", timeline, "--from", old, "--to", new, "--rules", tmp_path / "rules", "-o", tmp_path / "out")
    made = read_timeline(tmp_path / "out" / "timeline.json").events
    assert made
    told = (over, none) if fade_in_ms == 5.0 else (none,)
    assert all(each.decisions == told for each in made)


def test_a_faster_copy_has_shorter_spans(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    import soxr

    timeline, old, _ = films
    new = write_wave(tmp_path / "pal.wav", soxr.resample(OLD, RATE_HZ * 25 / 24, 48_000), rate_hz=48_000)
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    assert "speed 1.041667" in ended.out
    made = read_timeline(tmp_path / "out" / "timeline.json")
    assert [each.onset_s for each in made.events] == pytest.approx([at * 0.96 for at in ONSETS_S], abs=5e-5)
    first = made.events[0]
    assert len(first.blast) == pytest.approx(160 * 3 * 0.96, abs=1)
    assert first.reflections[0].delay_ms == pytest.approx(48.0)


def test_results_are_replaced_only_when_asked_and_never_the_old_timeline(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, new = films
    arguments = ("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out")
    quiet = blastline(*arguments, "-q")
    assert (quiet.code, quiet.out, quiet.err) == (0, "", ""), "what was not placed is in the files"
    again = blastline(*arguments)
    assert "exists already; give --overwrite" in again.complaint
    with moments(tmp_path / "out") as seen:
        assert blastline(*arguments, "--overwrite").code == 0
    assert {len(files) for files in seen if "timeline.json" in files} == {3}, "it stood beside a part of its tables"
    beside = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path, "--overwrite")
    assert "is the old timeline" in beside.complaint


def test_no_drive_of_another_stays_beside_a_conformed_timeline(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    out = tmp_path / "out"
    out.mkdir()
    for name in ("timeline.json", "drive.wav", "report.html", "timeline.reaper.csv", "notes.txt"):
        (out / name).write_text("another's")
    arguments = ("conform", timeline, "--from", old, "--to", new, "-o", out, "-q")
    assert blastline(*arguments).code == 2
    assert (out / "drive.wav").exists()
    assert blastline(*arguments, "--overwrite").code == 0
    left = sorted(each.name for each in out.iterdir())
    assert left == ["conform.csv", "notes.txt", "stretches.csv", "timeline.json"]


@pytest.mark.parametrize(
    ("told", "are_kept"),
    [
        ("render other.wav", False),
        ("render new.wav", False),
        ("render new.wav --timeline out", True),
        ("export {timeline} --format json", False),
        ("export out --format csv", True),
    ],
)
def test_the_tables_of_a_new_cut_stay_beside_its_own_shots_alone(
    films: tuple[Path, Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: str, are_kept: bool
) -> None:
    """They tell where the shots of a timeline beside them were; those of another film, or found anew, were nowhere."""
    timeline, old, new = films
    monkeypatch.chdir(tmp_path)
    write_wave(tmp_path / "other.wav", film(4.0, (2.0,), seed=42), rate_hz=RATE_HZ)
    assert blastline("conform", timeline, "--from", old, "--to", new, "-o", "out", "-q").code == 0
    quick = ["--quality", "draft", "--no-report", "-q"] if told.startswith("render") else []
    words = told.format(timeline=timeline).split()
    assert blastline(*words, *quick, "-o", "out", "--overwrite").code == 0
    left = {each.name for each in Path("out").iterdir()} & {"conform.csv", "stretches.csv"}
    assert left == ({"conform.csv", "stretches.csv"} if are_kept else set())


@pytest.mark.parametrize(
    ("samples", "complaint"),
    [
        (film(20.0, (5.0,), seed=41), "nothing of"),
        (np.zeros(20 * RATE_HZ), "is silent from beginning to end"),
        (OLD[: RATE_HZ // 2], "lasts 0.500 s; expected at least 1 s"),
    ],
    ids=["another film", "silence", "too short"],
)
def test_a_new_film_that_cannot_be_used(
    films: tuple[Path, Path, Path], tmp_path: Path, samples: Samples, complaint: str
) -> None:
    timeline, old, _ = films
    new = write_wave(tmp_path / "other.wav", samples, rate_hz=RATE_HZ)
    ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out", "-q")
    assert complaint in ended.complaint
    assert not (tmp_path / "out").exists()


def test_a_film_of_which_most_is_digital_silence_is_a_film_all_the_same(
    films: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    timeline, old, _ = films
    new = write_wave(tmp_path / "late.wav", np.concatenate([np.zeros(30 * RATE_HZ), OLD]), rate_hz=RATE_HZ)
    assert blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out", "-q").code == 0
    found = read_timeline(tmp_path / "out" / "timeline.json").events
    assert [event.onset_s for event in found] == pytest.approx([30.0 + onset_s for onset_s in ONSETS_S], abs=1e-4)


def test_channels_are_advised_on_only_where_there_are_several(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, _ = films
    other = film(20.0, (5.0,), seed=41)
    one = write_wave(tmp_path / "one.wav", other, rate_hz=RATE_HZ)
    soundfile.write(tmp_path / "two.wav", np.stack([0.2 * other, 0.1 * other], axis=1), RATE_HZ)
    for new, advised in ((one, False), (tmp_path / "two.wav", True)):
        ended = blastline("conform", timeline, "--from", old, "--to", new, "-o", tmp_path / "out", "-q")
        assert "expected a cut of the same film" in ended.complaint
        assert ("--mix 0 hears the first alone" in ended.complaint) == advised


@pytest.mark.parametrize(
    ("samples", "what"), [(OLD[1:], "length"), (0.5 * OLD, "sha256")], ids=["shorter", "another mix"]
)
def test_an_old_film_that_is_not_the_timelines(
    films: tuple[Path, Path, Path], tmp_path: Path, samples: Samples, what: str
) -> None:
    timeline, _, new = films
    other = write_wave(tmp_path / "other.wav", samples, rate_hz=RATE_HZ)
    ended = blastline("conform", timeline, "--from", other, "--to", new, "-o", tmp_path / "out", "-q")
    assert f"its {what} is" in ended.complaint
    assert "is not the film that" in ended.complaint


def test_files_that_are_not_there(films: tuple[Path, Path, Path], tmp_path: Path) -> None:
    timeline, old, new = films
    none = tmp_path / "none.wav"
    for arguments in ((none, old, new), (timeline, none, new), (timeline, old, none)):
        ended = blastline(
            "conform", arguments[0], "--from", arguments[1], "--to", arguments[2], "-o", tmp_path / "out", "-q"
        )
        assert "none.wav: no such file" in ended.complaint


def test_a_film_that_is_cut_anew_keeps_its_shots(tmp_path: Path) -> None:
    old = made_film(tmp_path, 14, 1.5)  # a film of which a shot is cut out
    name = next(iter(CASES))
    score = score_one(name, old, tmp_path)
    assert score.surviving >= 15
    assert score.removed >= 1
    assert score.within >= 0.99 * score.surviving
    assert (score.astray, score.false) == (0, 0)
    assert msgspec.json.decode(msgspec.json.encode(score))["name"] == name
