"""matplotlib draws for an account without a home, and says nothing of it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from blastline import run
from blastline.report import drawing
from blastline.report.drawing import ready_to_draw
from commands import write_film


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is where nobody may write")
def test_without_a_home_nothing_is_said(tmp_path: Path) -> None:
    code = "from pathlib import Path; from blastline.report.drawing import ready_to_draw; ready_to_draw(Path())"
    settings = {"HOME": "/proc", "XDG_CONFIG_HOME": "", "XDG_CACHE_HOME": "", "MPLCONFIGDIR": ""}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=tmp_path, env=os.environ | settings, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("asked", [None, "/users/own"])
def test_where_nothing_else_can_be_written_fonts_are_kept_beside_the_results_until_they_are_known(
    asked: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The user's own setting, which could not be written either, stays."""
    kept: list[str | None] = []

    def refusing() -> None:
        kept.append(os.environ.get("MPLCONFIGDIR"))
        if kept[-1] in (None, asked):
            raise OSError("a temporary directory could not be created")
        (Path(str(kept[-1])) / "fontlist.json").write_text("{}")

    monkeypatch.delenv("MPLCONFIGDIR", raising=False)
    if asked is not None:
        monkeypatch.setenv("MPLCONFIGDIR", asked)
    monkeypatch.setattr(drawing, "_import", refusing)
    ready_to_draw(tmp_path)
    assert (kept[0], Path(str(kept[1])).parent) == (asked, tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert os.environ.get("MPLCONFIGDIR") == asked


def test_the_report_of_a_film_without_shots_needs_nothing_that_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = write_film(tmp_path / "film.wav", length_s=1.0)
    monkeypatch.setattr(drawing, "_import", lambda: pytest.fail("matplotlib was imported"))
    assert run.render(film, tmp_path / "out", run.RenderOptions()).events == ()
    assert "no shots were found" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
