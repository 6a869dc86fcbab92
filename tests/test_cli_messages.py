"""What the command line tells of a run: progress, a summary, the checks that failed; and what it asks a run for."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import pytest

from blastline import run
from blastline.cli.conform import _say_lost
from blastline.cli.progress import shown_progress
from blastline.conform.place import Loss, Lost
from blastline.model import Check, Edits, Rejection, Timeline, encode
from blastline.report import CHECKS
from blastline.timebase import parse_timebase
from commands import Ended, blastline
from timelines import SHOT, timeline


def checked_by(monkeypatch: pytest.MonkeyPatch, *checks: Check) -> Timeline:
    """Let `check` find these checks in the timeline of two shots, and return it."""
    found = msgspec.structs.replace(timeline(), checks=checks)
    monkeypatch.setattr(run, "check", lambda *_, **__: found)
    return found


def test_a_failed_check_says_what_where_when_and_by_how_much(monkeypatch: pytest.MonkeyPatch) -> None:
    late = Check("felt_lag", "shot-0002", False, 0.75, 0.5, "ms")
    found = checked_by(monkeypatch, late, Check("drive_samples", None, False, 7, 0.0, "samples"))
    ended = blastline("check", "result", "--quiet")
    assert (ended.code, ended.err) == (1, "")
    assert ended.out.splitlines() == [
        f"failed: {CHECKS['felt_lag']}: not in shot-0002 at {found.events[1].timecode}, 0.75 ms "
        "(up to 0.5 ms either way)",
        f"failed: {CHECKS['drive_samples']}: 7 samples (exactly 0 samples)",
    ]
    assert blastline("check", "result").out.endswith("checks: 0 of 2 passed\n")


@pytest.mark.parametrize("name", CHECKS)
def test_no_check_is_called_by_the_name_that_it_has_in_json(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    passed = Check(name, None, True, 0.0, 1.0, "ms")
    for check in (passed, msgspec.structs.replace(passed, passed=False, measured=-2.0)):
        checked_by(monkeypatch, check)
        line, _ = blastline("check", "result").out.splitlines()
        assert line.startswith(f"{'passed' if check.passed else 'failed'}: {CHECKS[name]}")
        assert name not in line or "_" not in name
        assert line.isascii()  # a pipe's alphabet may have no other minus


@pytest.mark.parametrize(("value", "limit"), [(1.0000004, 1.0), (0.8999999, 0.9), (-0.50000001, -0.5)])
def test_a_check_that_just_fails_is_not_said_to_be_at_its_limit(
    monkeypatch: pytest.MonkeyPatch, value: float, limit: float
) -> None:
    """A drive that a mixer left a hair above full scale fails: "1 (up to 1)" would tell nobody why."""
    checked_by(monkeypatch, Check("drive_peak", None, False, value, limit, "of the limit"))
    [line] = blastline("check", "result", "--quiet").out.splitlines()
    said = re.search(r": (\S+) of the limit \(up to (\S+) of the limit\)$", line)
    assert said
    assert (float(said[1]) > float(said[2])) == (value > limit)
    assert said[1] != said[2]


def test_what_fails_for_every_shot_is_told_for_some_and_counted_for_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drive made for another film fails some checks for each of its hundreds of shots."""
    peaks = [Check("peak", f"shot-{n:04}", False, 1.5, 0.9, "of the limit") for n in range(1, 301)]
    checked_by(monkeypatch, Check("drive_samples", None, False, 7, 0.0, "samples"), *peaks)
    first, *told, count = blastline("check", "result").out.splitlines()
    assert first.startswith(f"failed: {CHECKS['drive_samples']}")
    assert [f"shot-{n:04}" in line for n, line in enumerate(told[:-1], start=1)] == [True] * 10
    assert told[-1] == f"failed: {CHECKS['peak']}: not in 290 more shots either"
    assert count == "checks: 0 of 301 passed"


def test_what_passed_is_listed_once_with_the_shots_that_were_held_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    lag = Check("felt_lag", "shot-0001", True, 0.1, 0.5, "ms")
    noted = msgspec.structs.replace(lag, event="shot-0002", limit=None)
    peaks = [Check("peak", f"shot-000{n}", n == 1, 0.5 * n, 0.9, "of the limit") for n in (1, 2)]
    checked_by(monkeypatch, lag, noted, Check("drive_shift", None, True, None, 0.5, "samples"), *peaks)
    *passed, failed, count = blastline("check", "result").out.splitlines()
    assert passed == [
        f"passed: {CHECKS['felt_lag']} (1 shot; 1 could not be held to it)",
        f"not measured: {CHECKS['drive_shift']}",
    ]
    assert failed.startswith(f"failed: {CHECKS['peak']}: not in shot-0002")
    assert count == "checks: 2 of 3 passed; 2 could not be held to a limit"


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8"])
def test_a_name_that_the_outputs_alphabet_lacks_is_spelt_out(tmp_path: Path, encoding: str) -> None:
    """Windows writes into a pipe in its old alphabet: the files are written, and their names are told all the same."""
    original, folder = tmp_path / "timeline.json", tmp_path / "שלום"
    original.write_bytes(encode(timeline()))
    ended = blastline("export", original, "--format", "csv", "-o", folder, "--quiet", encoding=encoding)
    told = str(folder / "timeline.csv").encode(encoding, "backslashreplace").decode(encoding)
    assert ended == Ended(0, f"{told}\n", "")


def test_passed_checks_are_counted_and_give_exit_code_0(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "check", lambda *_, **__: timeline())
    ended = blastline("check", "result")
    assert (ended.code, ended.out.splitlines()[-1], ended.err) == (
        0,
        "checks: 1 of 1 passed; 1 could not be held to a limit",
        "",
    )
    assert blastline("check", "result", "--quiet") == Ended(0, "", "")


def test_a_render_is_summed_up(monkeypatch: pytest.MonkeyPatch) -> None:
    found = timeline()
    damaged = msgspec.structs.replace(found.source, warnings=("2 samples were not numbers",))
    made = msgspec.structs.replace(found, source=damaged)
    asked: list[Any] = []

    def render(film: Path, folder: Path, options: Any, progress: Any, note: Any) -> Timeline:
        asked.append((film, folder, options))
        progress("listening", 1, 2)
        progress("listening", 2, 2)
        note("webvtt: times are whole milliseconds")
        return made

    monkeypatch.setattr(run, "render", render)
    ended = blastline("render", "film.mkv", "-o", "out", "--format", "csv, json", "--mix", "0,2", "--stream", "1")
    assert (ended.code, ended.out) == (0, "")
    assert ended.err.splitlines() == [
        "blastline: listening ...",
        "warning: 2 samples were not numbers",
        "webvtt: times are whole milliseconds",
        "2 shots, 1 burst",
        "drive: 1 filter",
        f"results: {Path('out', 'report.html')}",
        "checks: 1 of 1 passed; 1 could not be held to a limit",
    ]
    assert blastline("render", "film.mkv", "-o", "out", "--quiet").err == "warning: 2 samples were not numbers\n"
    (film, folder, options), (_, _, default) = asked
    assert (film, folder) == (Path("film.mkv"), Path("out"))
    assert options == run.RenderOptions(formats=("json", "csv"), mix="0,2", stream=1)
    assert default == run.RenderOptions()


def test_what_was_asked_of_a_drive_is_told_where_it_is_not_as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    made = msgspec.structs.replace(timeline(), phase="zero", background="direct", level_db=-6.0)
    monkeypatch.setattr(run, "render", lambda *_: made)
    told = blastline("render", "film.mkv", "-o", "out").err
    assert "drive: 1 filter; phase zero; level -6 dB; the film's own sound between the shots\n" in told


def test_what_was_nearly_a_shot_is_counted_where_nobody_has_edited(monkeypatch: pytest.MonkeyPatch) -> None:
    refused = tuple(Rejection(at, "too unsure", {"probability": odds}) for at, odds in ((1, 0.7), (2, 0.2), (3, 0.5)))
    made = msgspec.structs.replace(timeline(), rejections=refused)
    monkeypatch.setattr(run, "render", lambda *_: made)
    told = "2 shots, 1 burst, 2 more nearly taken for shots (rejections in the timeline)\n"
    assert told in blastline("render", "film.mkv", "-o", "out").err
    by_hand = Edits("labels.txt", kept=2, moved=0, changed=0, added=0, deleted=2)
    monkeypatch.setattr(run, "render", lambda *_: msgspec.structs.replace(made, edits=by_hand))
    assert "2 shots, 1 burst\n" in blastline("render", "film.mkv", "-o", "out").err


@pytest.mark.parametrize(("peak", "told"), [(0.0126, "0.013 of the actuator's limit (-38 dB)"), (0.2, ""), (0.0, "")])
def test_a_drive_that_hardly_moves_the_seat_is_told(monkeypatch: pytest.MonkeyPatch, peak: float, told: str) -> None:
    events = tuple(
        event
        if event.drive is None
        else msgspec.structs.replace(event, drive=msgspec.structs.replace(event.drive, peak=peak))
        for event in timeline().events
    )
    monkeypatch.setattr(run, "render", lambda *_: msgspec.structs.replace(timeline(), events=events))
    said = blastline("render", "film.mkv", "-o", "out").err
    assert (f"note: the strongest drive peaks at {told}: --level raises it\n" in said) == bool(told)


def test_an_edited_file_without_shots_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    none = Edits("labels.txt", kept=0, moved=0, changed=0, added=0, deleted=0)
    monkeypatch.setattr(run, "render", lambda *_: msgspec.structs.replace(timeline(), events=(), edits=none))
    assert "edits: labels.txt: no shots\n" in blastline("render", "film.mkv", "-o", "out").err


@pytest.mark.parametrize("options", [(), ("--quiet",), ("-o", "found.json")])
def test_detect_warns_of_a_damaged_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    found = timeline()
    damaged = msgspec.structs.replace(found, source=msgspec.structs.replace(found.source, warnings=("1 packet lost",)))
    monkeypatch.setattr(run, "detect", lambda *_, **__: damaged)
    monkeypatch.chdir(tmp_path)
    ended = blastline("detect", "film.mkv", *options)
    summary = "" if "--quiet" in options else "2 shots, 1 burst\n"
    assert (ended.code, ended.err) == (0, f"warning: 1 packet lost\n{summary}")


def test_every_option_of_render_arrives(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def render(film: Path, folder: Path, options: Any, *_: object) -> Timeline:
        asked.append(options)
        return timeline()

    monkeypatch.setattr(run, "render", render)
    options = "--quality draft --actuator own.toml --rules own --drive filter --phase zero --background direct"
    more = (
        "--level -6 --mix lfe --stream 0 --format audacity --no-report --overwrite --frame-rate 25 "
        "--timeline cut.csv --original first.json"
    )
    assert blastline("render", "film.mkv", "-o", "out", *options.split(), *more.split()).code == 0
    [arrived] = asked
    assert arrived == run.RenderOptions(
        quality="draft",
        actuator="own.toml",
        rules=Path("own"),
        drive="filter",
        phase="zero",
        background="direct",
        level_db=-6.0,
        mix="lfe",
        stream=0,
        timebase=parse_timebase(None, "25"),
        formats=("json", "audacity"),
        report=False,
        overwrite=True,
        timeline=Path("cut.csv"),
        original=Path("first.json"),
    )
    default = run.RenderOptions()
    # a budget is no option of its own: it chooses the quality, and is noted with it
    assert [name for name in vars(default) if getattr(default, name) == getattr(arrived, name)] == ["budget"]


def test_progress_away_from_a_terminal_is_a_line_per_stage(capsys: pytest.CaptureFixture[str]) -> None:
    with shown_progress(quiet=False) as progress:
        for stage, done in [("listening", 1), ("listening", 2), ("checking", 0)]:
            progress(stage, done, 2)
    assert capsys.readouterr().err == "blastline: listening ...\nblastline: checking ...\n"
    with shown_progress(quiet=True) as progress:
        progress("listening", 1, None)
    assert capsys.readouterr() == ("", "")


def test_progress_on_a_terminal_is_a_bar_with_the_time_left(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    with shown_progress(quiet=False) as progress:
        progress("listening", 24, None)
        progress("listening", 24, 48)
        progress("checking", 0, None)
    out, err = capsys.readouterr()
    assert out == ""
    assert re.search(r"listening.* 50 %.*left", err)
    assert "checking" in err


@pytest.mark.parametrize("count", [1, 20, 21, 300])
def test_of_many_shots_that_have_no_place_some_are_named_and_the_others_counted(
    count: int, capsys: pytest.CaptureFixture[str]
) -> None:
    lost = [(SHOT, Lost(Loss.REMOVED, 1.0, 0.2), "01:00:02:00")] * count
    _say_lost(cast("Any", SimpleNamespace(lost=lost)))
    lines = capsys.readouterr().err.splitlines()
    named = [line for line in lines if line.startswith(f"not placed: {SHOT.id}: ")]
    assert len(named) == min(count, 20)
    assert lines[len(named) :] == ([f"not placed: {count - 20} more, in conform.csv"] if count > 20 else [])
