"""What the command line tells of a run: progress, a summary, the checks that failed; and what it asks a run for."""

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest

from blastline import run
from blastline.cli.progress import shown_progress
from blastline.model import Check, Timeline, encode
from blastline.timebase import parse_timebase
from commands import Ended, blastline
from timelines import timeline


def test_a_failed_check_is_listed_and_gives_exit_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    failed = (Check("lag", "shot-0002", False, 0.75, 0.5, "ms"), Check("frames", None, False, None, None, "frames"))
    found = timeline()
    found = msgspec.structs.replace(found, checks=(*found.checks, *failed))
    monkeypatch.setattr(run, "check", lambda *_, **__: found)
    ended = blastline("check", "result", "--quiet")
    assert (ended.code, ended.err) == (1, "")
    assert ended.out.splitlines() == [
        "failed: lag, shot-0002: 0.75 ms (limit 0.5 ms)",
        "failed: frames, the film: not measured",
    ]
    assert blastline("check", "result").out.endswith("checks: 2 of 4 passed\n")


@pytest.mark.parametrize(("value", "limit"), [(1.0000004, 1.0), (0.8999999, 0.9), (-0.50000001, -0.5)])
def test_a_check_that_just_fails_is_not_said_to_be_at_its_limit(
    monkeypatch: pytest.MonkeyPatch, value: float, limit: float
) -> None:
    """A drive that a mixer left a hair above full scale fails: "1 (limit 1)" would tell nobody why."""
    failed = Check("drive_peak", None, False, value, limit, "of the limit")
    monkeypatch.setattr(run, "check", lambda *_, **__: msgspec.structs.replace(timeline(), checks=(failed,)))
    [line] = blastline("check", "result", "--quiet").out.splitlines()
    said = re.fullmatch(r"failed: drive_peak, the film: (\S+) of the limit \(limit (\S+) of the limit\)", line)
    assert said
    assert (float(said[1]) > float(said[2])) == (value > limit)
    assert said[1] != said[2]


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
    assert blastline("check", "result") == Ended(0, "checks: 2 of 2 passed\n", "")


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
        "checks: 2 of 2 passed",
    ]
    assert blastline("render", "film.mkv", "-o", "out", "--quiet").err == "warning: 2 samples were not numbers\n"
    (film, folder, options), (_, _, default) = asked
    assert (film, folder) == (Path("film.mkv"), Path("out"))
    assert options == run.RenderOptions(formats=("json", "csv"), mix="0,2", stream=1)
    assert default == run.RenderOptions()


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
