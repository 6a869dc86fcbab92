"""What cannot be used: one line that says so, exit code 2, and nothing written, whichever command meets it."""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile

from commands import RATE_HZ, Ended, blastline, blastline_alone, write_film

SHOTS_S = (1.0, 3.0, 5.0)
Edit = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a film, a new cut of it and, under `out`, a result."""
    folder = tmp_path_factory.mktemp("made")
    film = write_film(folder / "film.wav", length_s=7.0, shots_s=SHOTS_S)
    samples, _ = soundfile.read(film)
    soundfile.write(folder / "new.wav", np.concatenate([np.zeros(500), samples]), RATE_HZ)
    (folder / "first.csv").write_text("onset_s\n" + "".join(f"{shot_s}\n" for shot_s in SHOTS_S))
    ended = blastline("render", film, "-o", folder / "out", "--timeline", folder / "first.csv", "--no-report")
    assert ended.code == 0, ended
    return folder


def newer(plain: dict[str, Any]) -> None:
    plain["schema"] = "blastline.timeline/2"


def negative_sample(plain: dict[str, Any]) -> None:
    plain["events"][1]["onset_sample"] = -480


def negative_time(plain: dict[str, Any]) -> None:
    plain["events"][1]["onset_s"] = -0.01


def twice(plain: dict[str, Any]) -> None:
    plain["events"][1]["id"] = "shot-0001"


def without_onsets(plain: dict[str, Any]) -> None:
    for event in plain["events"]:
        del event["onset_sample"], event["onset_s"]


def window_beyond(plain: dict[str, Any]) -> None:
    plain["events"][1]["window"]["stop_sample"] = 10**9


def window_backwards(plain: dict[str, Any]) -> None:
    plain["events"][1]["window"]["start_sample"] = 10**6


def onset_beyond(plain: dict[str, Any]) -> None:
    plain["events"][1].update(onset_sample=10**9, onset_s=10**9 / RATE_HZ)


def echo_backwards(plain: dict[str, Any]) -> None:
    plain["events"][1]["reflections"] = [{"start_sample": 9, "stop_sample": 8, "delay_ms": 1.0, "level_db": -9.0}]


def no_timecode(plain: dict[str, Any]) -> None:
    plain["source"].update(start_timecode="junk", frame_rate="25")


def no_rate(plain: dict[str, Any]) -> None:
    plain["source"]["frame_rate"] = "25/0"


def beyond_any_count(plain: dict[str, Any]) -> None:
    plain["rejections"] = [{"at_sample": 2**63, "reason": "", "evidence": {}}]


JSON = [
    pytest.param(window_beyond, "which has 336000 frames, 7 s", id="a window beyond the film"),
    pytest.param(window_backwards, "1000000: expected at most 144000, the onset", id="a window that does not hold"),
    pytest.param(onset_beyond, "the film, which has 336000 frames, 7 s", id="an onset beyond the film"),
    pytest.param(echo_backwards, "events[1].reflections[0].stop_sample = 8", id="an echo that runs backwards"),
    pytest.param(no_timecode, "source.start_timecode = 'junk'", id="no timecode"),
    pytest.param(no_rate, "source.frame_rate = '25/0'", id="no frame rate"),
    pytest.param(beyond_any_count, "rejections[0].at_sample = 9223372036854775808", id="beyond any count"),
    pytest.param(newer, "schema = 'blastline.timeline/2'", id="a newer schema"),
    pytest.param(negative_sample, "events[1].onset_sample = -480", id="a negative sample"),
    pytest.param(negative_time, "events[1].onset_s = -0.01", id="a negative time"),
    pytest.param(twice, "shot-0001", id="a duplicated id"),
    pytest.param(without_onsets, "events[0]", id="a missing field"),
]


def run_on(command: str, made: Path, file: Path, out: Path, *more: str | Path) -> Ended:
    """Run a command that reads a timeline and writes a folder."""
    if command == "render":
        return blastline("render", made / "film.wav", "-o", out, "--timeline", file, "-q", *more)
    if command == "conform":
        films = ("--from", made / "film.wav", "--to", made / "new.wav")
        return blastline("conform", file, *films, "-o", out, "-q", *more)
    return blastline("export", file, "--format", "csv", "-o", out, "-q", *more)


@pytest.mark.parametrize("command", ["render", "export", "conform"])
@pytest.mark.parametrize(("spoil", "complaint"), JSON)
def test_a_spoilt_timeline(tmp_path: Path, made: Path, command: str, spoil: Edit, complaint: str) -> None:
    plain = json.loads((made / "out" / "timeline.json").read_text())
    spoil(plain)
    file = tmp_path / "spoilt.json"
    file.write_text(json.dumps(plain))
    told = run_on(command, made, file, tmp_path / "out").complaint
    assert told.startswith(f"{file}: ")
    assert complaint in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "text", "place", "expected"),
    [
        ("edited.csv", "id,confidence\nshot-0001,1\n", "line 1", "onset_sample or onset_s"),
        ("edited.csv", "id,onset_s\nshot-0001,1.0\nshot-0002,-0.5\n", "line 3: onset_s = '-0.5'", "a time from 0"),
        ("edited.csv", "id,onset_sample\nshot-0001,-1\n", "line 2: onset_sample = '-1'", "a sample from 0"),
        ("edited.csv", "id,onset_s\nshot-0001,1.0\nshot-0001,2.0\n", "line 3: id = 'shot-0001'", "each once"),
        (
            "labels.txt",
            "1.0\t1.2\tshot-0001 1.00\n-2.0\t1\tshot-0002 1.00\n",
            "line 2: start = '-2.0'",
            "a time from 0",
        ),
        ("labels.txt", "1.0\t1.2\tshot-0001 1.00\n2.0\t2.1\tshot-0001 1.00\n", "line 2: id = 'shot-0001'", "each once"),
        ("labels.txt", "1.0\n", "line 1", "start, end and text"),
        ("regions.csv", "#,Name,End\nR1,shot-0001,0:01.2\n", "line 1", "onset_sample or onset_s"),
        ("regions.csv", "#,Name,Start\nR1,shot-0001,0:01.2\n", "line 1: no column End", "#,Name,Start,End,Length"),
        ("regions.csv", "#,Name,Start,End\nR1,a,-0:01.0,0:02.0\n", "line 2: Start = '-0:01.0'", "a time from 0"),
        ("regions.csv", "#,Name,Start,End\nR1,shot-0001,1,2\nR2,shot-0001,3,4\n", "line 3: id =", "each once"),
    ],
)
def test_a_spoilt_table(tmp_path: Path, made: Path, name: str, text: str, place: str, expected: str) -> None:
    file = tmp_path / name
    file.write_text(text)
    told = run_on("render", made, file, tmp_path / "out").complaint
    assert told.startswith(f"{file}: {place}"), told
    assert expected in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["export", "conform"])
def test_a_table_where_a_timeline_is_wanted(tmp_path: Path, made: Path, command: str) -> None:
    told = run_on(command, made, made / "out" / "timeline.csv", tmp_path / "out").complaint
    assert told.startswith(f"{made / 'out' / 'timeline.csv'}: a table of shots, ")
    assert told.endswith("expected a timeline.json")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("names", ["cvs", "json,", "json,,csv", "json,CSV", ""])
def test_an_unknown_format(tmp_path: Path, made: Path, names: str) -> None:
    out = tmp_path / "out"
    told = [
        blastline("export", made / "out" / "timeline.json", "--format", names, "-o", out).complaint,
        blastline("render", made / "film.wav", "--format", names, "-o", out, "-q").complaint,
    ]
    assert told[0] == told[1]
    assert "no such format; expected some of: json, schema, csv, " in told[0]
    assert not out.exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
@pytest.mark.parametrize("command", ["render", "export", "conform"])
def test_a_folder_without_permission(tmp_path: Path, made: Path, command: str) -> None:
    out = tmp_path / "out"
    out.mkdir(mode=0o500)
    ended = run_on(command, made, made / "out" / "timeline.json", out)
    assert ended.complaint == f"{out}: cannot write here: Permission denied"
    assert list(out.iterdir()) == []


@pytest.mark.parametrize("command", ["render", "export", "conform"])
def test_a_place_where_no_folder_can_be(tmp_path: Path, made: Path, command: str) -> None:
    (tmp_path / "file").write_text("mine")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        assert str(tmp_path / "file") in run_on(command, made, made / "out" / "timeline.json", out).complaint
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("command", ["render", "export", "conform"])
def test_an_earlier_result_is_left_as_it_was(tmp_path: Path, made: Path, command: str) -> None:
    assert run_on(command, made, made / "out" / "timeline.json", tmp_path / "out").code == 0
    before = {file: hashlib.sha256(file.read_bytes()).digest() for file in (tmp_path / "out").iterdir()}
    assert "give --overwrite" in run_on(command, made, made / "out" / "timeline.json", tmp_path / "out").complaint
    plain = json.loads((made / "out" / "timeline.json").read_text())
    newer(plain)
    (tmp_path / "spoilt.json").write_text(json.dumps(plain))
    assert "schema" in run_on(command, made, tmp_path / "spoilt.json", tmp_path / "out", "--overwrite").complaint
    assert {file: hashlib.sha256(file.read_bytes()).digest() for file in (tmp_path / "out").iterdir()} == before


NESTED = "seed = " + "[" * 5_000


@pytest.mark.parametrize(
    ("name", "text", "command", "complaint"),
    [
        ("rules/scenes.toml", NESTED, "rules check rules", "scenes.toml: not a TOML file that can be read: its arrays"),
        (
            "scene.toml",
            NESTED,
            "synth scene.toml -o out -q",
            "scene.toml: not a TOML file that can be read: its arrays",
        ),
        ("seat.csv", "frequency_hz,gain_db\n" + "1" * 200_000, "actuator fit seat.csv -o p.toml", "seat.csv: line 2: "),
        ("seat.csv", "frequency_hz", "actuator fit seat.csv -o p.toml --peak-db nan", "--peak-db"),
        ("seat.csv", "frequency_hz", "actuator fit seat.csv -o p.toml --peak-db 1e5", "--peak-db"),
    ],
)
def test_a_spoilt_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, text: str, command: str, complaint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text(text)
    assert complaint in blastline(*command.split()).complaint
    assert not (tmp_path / "out").exists()
    assert not (tmp_path / "p.toml").exists()


def test_a_name_that_is_no_text_is_refused_before_the_work(tmp_path: Path, made: Path) -> None:
    edited = tmp_path / "cut\udcff.csv"
    edited.write_text("onset_s\n1.0\n")
    ended = blastline_alone("render", made / "film.wav", "-o", tmp_path / "out", "--timeline", edited, "-q")
    assert "the name is not valid UTF-8; rename the file" in ended.complaint
    assert not (tmp_path / "out").exists()
    scene = tmp_path / "scene\udcff.toml"
    scene.write_text("schema = 1")
    assert "rename the file" in blastline_alone("synth", scene, "-o", tmp_path / "out", "-q").complaint


def test_a_drive_that_is_not_the_timelines_is_told(tmp_path: Path, made: Path) -> None:
    folder = tmp_path / "result"
    assert run_on("render", made, made / "out" / "timeline.json", folder).code == 0
    found = ("detect", made / "film.wav", "-o", folder / "timeline.json", "--overwrite", "--quality", "draft", "-q")
    assert blastline(*found).code == 0
    ended = blastline("check", folder, "--audio", made / "film.wav")
    assert f"not checked: {folder / 'drive.wav'}" in ended.err
    assert blastline("check", folder, "--audio", made / "film.wav", "--quiet").err == ""
    seat = ("--drive", made / "out" / "drive.wav", "--actuator", "crowson-t108sm")
    given = blastline("check", folder, "--audio", made / "film.wav", *seat)
    assert "drive" in given.out
    assert "not checked" not in given.err
    (folder / "drive.wav").unlink()
    ended = blastline("check", folder, "--audio", made / "film.wav")
    assert ended.code == 0
    assert "not checked: a drive; the timeline has none, and only its events were held against the film\n" in ended.err


def test_a_timeline_without_anywhere_to_go_is_refused(made: Path) -> None:
    ended = blastline_alone("detect", made / "film.wav", prepare=lambda: os.close(1))
    assert (ended.code, ended.out) == (2, "")
    assert "standard output is closed" in ended.err
