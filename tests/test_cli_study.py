"""What the studies write their figures into: refused before the work begins, whole, replaced only when asked for."""

from pathlib import Path

import pytest

from blastline.study.conforming import ConformScore
from commands import blastline

STUDIES = [
    ("detection --fixtures scenes", "blastline.study.detection.study_detection"),
    ("rendering --fixtures scenes", "blastline.study.rendering.score"),
    ("segmentation --random 1", "blastline.study.segmentation.score"),
    ("stability", "blastline.study.stability.measure_stability"),
    ("conform", "blastline.study.conforming.score_all"),
]

SCENE = """
schema = 1
rate_hz = 48000
duration_s = 4.0
seed = 3
[[beds]]
kind = "ambience"
level_dbfs = -60.0
[[shots]]
at_s = 1.5
weapon = "rifle"
environment = "field"
snr_db = 35.0
"""


@pytest.mark.parametrize(("words", "work"), STUDIES)
def test_a_file_for_figures_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, work: str
) -> None:
    begun: list[str] = []

    def measure(*_: object, **__: object) -> None:
        begun.append(work)
        raise KeyboardInterrupt

    monkeypatch.setattr(work, measure)
    mine = tmp_path / "figures.json"
    mine.write_text("mine")
    told = blastline("study", *words.split(), "--output", mine).complaint
    assert told == f"{mine}: exists already; give --overwrite to replace it, or another place"
    told = blastline("study", *words.split(), "--output", mine / "below.json", "--overwrite").complaint
    assert told.startswith(f"{mine}: is a file; expected a folder")
    assert begun == []
    assert blastline("study", *words.split(), "--output", mine, "--overwrite").code == 130
    assert begun == [work]
    assert [*tmp_path.iterdir()] == [mine]
    assert mine.read_text() == "mine"


def test_figures_replace_earlier_ones_only_when_that_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("blastline.study.conforming.score_all", lambda *_: [])
    file = tmp_path / "figures.json"
    assert blastline("study", "conform", "-o", file).code == 0
    first = file.read_text()
    assert blastline("study", "conform", "-o", file).code == 2
    file.write_text("mine")
    assert blastline("study", "conform", "-o", file, "--overwrite").code == 0
    assert file.read_text() == first == "[]\n"


@pytest.mark.parametrize(("within", "told"), [(0, "-"), (3, "0.0120")])
def test_no_shot_that_was_placed_has_no_worst_error(monkeypatch: pytest.MonkeyPatch, within: int, told: str) -> None:
    score = ConformScore("dubbed", 16, within, 0, 16 - within, 2, 0, 0.0, 0.012 if within else 0.0, 1, ())
    monkeypatch.setattr("blastline.study.conforming.score_all", lambda *_: [score])
    assert blastline("study", "conform").out.splitlines()[1].split()[-1] == told


@pytest.mark.parametrize(("study", "stage"), [("segmentation", "listening"), ("rendering", "rendering")])
def test_a_study_that_takes_minutes_says_what_it_is_at_unless_it_is_to_be_quiet(
    tmp_path: Path, study: str, stage: str
) -> None:
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    told, quiet = (blastline("study", study, "--fixtures", tmp_path, *options) for options in ((), ("--quiet",)))
    assert f"blastline: {stage} ..." in told.err
    assert quiet.err == ""
    assert told.code == quiet.code
