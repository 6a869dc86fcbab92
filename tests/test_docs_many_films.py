"""The scripts of docs/many-films.md, run as they are printed there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pandas
import pytest

from commands import write_film

PAGE = Path(__file__).parents[1] / "docs" / "many-films.md"
MANY, TABLE = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def ran(script: str, *arguments: Path | str, cwd: Path, code: int = 0, **settings: str) -> str:
    """Run a script of the page, which ends with an exit code, and return what it printed."""
    words = [sys.executable, "-c", script, *map(str, arguments)]
    done = subprocess.run(words, cwd=cwd, env=os.environ | settings, capture_output=True, text=True, errors="replace")
    assert (done.returncode, done.stderr.count("\n")) == (code, code)  # a failure is one line
    return done.stdout


def test_all_films_are_rendered_once_and_the_broken_one_is_told(tmp_path: Path) -> None:
    films, results = tmp_path / "films", tmp_path / "films" / "results"  # where a drive could be taken for a film
    (films / "reel").mkdir(parents=True)
    for name in ("one.wav", "reel/one.WAV"):
        write_film(films / name, length_s=2.5, shots_s=(1.0,))
    (films / "broken.wav").write_bytes(b"RIFF")
    told = ran(MANY, films, results, cwd=tmp_path, code=1)
    assert told.startswith(f"{films / 'broken.wav'}: exit code 2\nblastline: ")
    assert told.count("\n") == 2
    done = sorted(results.rglob("timeline.json"))
    assert [file.parent for file in done] == [results / "one.wav", results / "reel" / "one.WAV"]
    before = [file.stat().st_mtime_ns for file in done]
    assert ran(MANY, films, results, cwd=tmp_path, code=1) == told
    assert [file.stat().st_mtime_ns for file in done] == before


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every name is a text")
@pytest.mark.parametrize("encoding", ["utf-8:strict", "ascii"])
def test_a_film_whose_name_cannot_be_shown_stops_no_other(tmp_path: Path, encoding: str) -> None:
    films = tmp_path / "films"
    films.mkdir()
    for name in (b"a\xff.wav", "b\u00fc.wav".encode(), b"c\xe2\x82\xac.wav"):
        (films / os.fsdecode(name)).write_bytes(b"RIFF")
    write_film(films / "z.wav", length_s=2.5, shots_s=(1.0,))
    told = ran(MANY, films, tmp_path / "results", cwd=tmp_path, code=1, PYTHONIOENCODING=encoding)
    assert told.count("exit code 2") == 3
    assert (tmp_path / "results" / "z.wav" / "timeline.json").exists()


def test_what_was_rendered_among_the_films_is_no_film_however_the_folders_are_named(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    write_film(tmp_path / "a" / "x.wav", length_s=2.5, shots_s=(1.0,))
    (tmp_path / "reel.wav").mkdir()
    for words in ((tmp_path, "results"), (".", tmp_path / "results")):
        assert ran(MANY, *words, cwd=tmp_path) == ""
        assert [*tmp_path.rglob("timeline.json")] == [tmp_path / "results" / "a" / "x.wav" / "timeline.json"]


@pytest.mark.skipif(sys.platform == "win32", reason="links there need other rights")
def test_a_film_that_is_a_link_is_done_or_told(tmp_path: Path) -> None:
    films, results = tmp_path / "films", tmp_path / "results"
    films.mkdir()
    write_film(tmp_path / "elsewhere.wav", length_s=2.5, shots_s=(1.0,))
    (films / "linked.wav").symlink_to(tmp_path / "elsewhere.wav")
    assert ran(MANY, films, results, cwd=tmp_path) == ""
    (films / "offline.mkv").symlink_to(tmp_path / "unmounted" / "offline.mkv")
    (films / "offline.txt").symlink_to(tmp_path / "unmounted" / "offline.txt")
    told = ran(MANY, films, results, cwd=tmp_path, code=1)
    assert told.startswith(f"{films / 'offline.mkv'}: exit code 2\nblastline: ")
    assert told.count("\n") == 2
    assert [file.parent for file in results.rglob("timeline.json")] == [results / "linked.wav"]


@pytest.mark.skipif(sys.platform == "win32", reason="folders there have other rights")
def test_a_folder_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    films, locked = tmp_path / "films", tmp_path / "films" / "locked"
    locked.mkdir(parents=True)
    write_film(films / "film.wav", length_s=2.5, shots_s=(1.0,))
    locked.chmod(0)
    try:
        if os.access(locked, os.R_OK):
            pytest.skip("the administrator may read everything")
        told = ran(MANY, films, tmp_path / "results", cwd=tmp_path, code=1)
    finally:
        locked.chmod(0o700)
    assert told == f"{locked}: Permission denied\n"
    assert (tmp_path / "results" / "film.wav" / "timeline.json").exists()


def test_a_folder_without_films_or_results_is_told(tmp_path: Path) -> None:
    films = tmp_path / "flims"
    assert ran(MANY, films, tmp_path / "results", cwd=tmp_path, code=1) == f"{films}: No such file or directory\n"
    assert ran(TABLE, tmp_path, cwd=tmp_path, code=1) == ""


def test_films_below_the_results_are_films(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    write_film(tmp_path / "films" / "x.wav", length_s=2.5, shots_s=(1.0,))
    assert ran(MANY, "films", ".", cwd=tmp_path) == ""
    assert (tmp_path / "x.wav" / "timeline.json").exists()


def test_what_a_run_left_that_was_killed_while_it_moved_its_files_is_rendered_again(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    write_film(tmp_path / "films" / "x.wav", length_s=2.5, shots_s=(1.0,))
    out = tmp_path / "results" / "x.wav"
    out.mkdir(parents=True)
    (out / "drive.wav").write_text("of a killed run")
    assert ran(MANY, "films", "results", cwd=tmp_path) == ""
    assert (out / "timeline.json").exists()
    assert (out / "drive.wav").read_bytes().startswith(b"RIFF")


def test_the_table_holds_the_shots_of_all_films(tmp_path: Path) -> None:
    for film, shots in (("a/one", 2), ("b/one", 0), ("c/one", 1)):
        folder = tmp_path / "results" / film
        folder.mkdir(parents=True)  # of one name in folders of their own, as reels are
        rows = "".join(f"shot-{number:04},0.{9 - number}\n" for number in range(1, shots + 1))
        (folder / "timeline.csv").write_text(f"id,confidence\n{rows}")
        (folder / "timeline.json").write_text("{}")
    for unfinished in ("b/half", "a/one/.blastline-living", "a/one/.blastline-killed/earlier-1"):
        (tmp_path / "results" / unfinished).mkdir(parents=True)
        (tmp_path / "results" / unfinished / "timeline.csv").write_text("id,confidence\nshot-0001,0.1\n")
        if unfinished != "b/half":
            (tmp_path / "results" / unfinished / "timeline.json").write_text("{}")
    told = ran(TABLE, tmp_path / "results", cwd=tmp_path)
    told = told.replace("\\", "/")
    assert [line.split() for line in told.splitlines()[-2:]] == [["a/one", "2", "0.7"], ["c/one", "1", "0.8"]]
    assert pandas.read_csv(tmp_path / "shots.csv")["film"].tolist() == ["a/one", "a/one", "c/one"]
