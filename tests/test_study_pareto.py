"""The commands `study detection` and `study pareto` on a scene of their own: what they say and write holds together."""

import csv
import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec
import numpy as np
import pytest

from blastline.cli.study_pareto import pareto_table
from blastline.study.detection import DetectionStudy
from blastline.study.front import on_front
from blastline.study.pareto import ParetoStudy, study_pareto
from blastline.study.pareto_files import FILES, markdown, write_pareto
from blastline.study.pareto_picture import front_svg
from blastline.study.rendering_sweep import BEST
from blastline.study.settings import TIERS
from blastline.study.sources import StudySource
from commands import blastline
from light_peers import LIGHT

SCENE = """
schema = 1
rate_hz = 48000
duration_s = 5.0
seed = 4
[[beds]]
kind = "ambience"
level_dbfs = -50.0
[[shots]]
at_s = 1.2
weapon = "pistol"
environment = "field"
distance_m = 1.0
peak_dbfs = -1.5
positive_ms = 0.4
recording = "clean"
[[shots]]
at_s = 3.0
weapon = "smg"
environment = "field"
distance_m = 4.0
peak_dbfs = -2.0
recording = "clean"
burst = { shots = 4, rpm = 700.0 }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("scenes")
    (made / "shots.toml").write_text(SCENE)
    (made / "silent.toml").write_text(SCENE.partition("[[shots]]")[0])
    return made


@pytest.fixture(scope="module")
def study(folder: Path) -> ParetoStudy:
    return measured(folder)


def measured(folder: Path, *, jobs: int = 1) -> ParetoStudy:
    return study_pareto(
        StudySource(folder),
        jobs=jobs,
        own=["verify.threshold=0.95", "render.tolerance=1e-5"],
        changes={"draft": ("verify.look_from=0.3",), "standard": ("render.solver_rate_hz=4000",)},
    )


def accuracies(study: ParetoStudy) -> object:
    """Return all that does not depend on the machine."""
    detection = [msgspec.structs.replace(each, cost=None) for each in study.detection]
    assert study.rendering is not None
    drives = [(each.name, each.ratio, each.correlation, each.lost) for each in study.rendering.points]
    return detection, drives, study.rendering.weak


def test_the_front_and_the_bars_follow_from_the_figures(study: ParetoStudy) -> None:
    costs, f1 = [each.cost.times_read for each in study.detection], [each.f1 for each in study.detection]
    there = on_front(costs, f1)
    assert study.on_front == tuple(each.name for each, is_there in zip(study.detection, there, strict=True) if is_there)
    assert [each.name for each in study.detection[:3]] == list(TIERS)
    assert {"standard, verify.threshold=0.95"} < {each.name for each in study.detection}
    for tier in TIERS:
        (bar,) = [bar for bar in study.bars if bar.name.startswith(f"detection, {tier}: F1")]
        assert bar.met == (tier in study.on_front) or bar.measured == 0.0
    (times,) = [bar for bar in study.bars if bar.name == "detection, standard over draft: cost"]
    assert times.measured == pytest.approx(costs[1] / costs[0])


def test_every_figure_is_measured(study: ParetoStudy) -> None:
    for score in study.detection:
        assert score.shots == 5
        assert 0.0 <= score.intervals.f1.low <= score.f1 <= score.intervals.f1.high <= 1.0
        assert score.cost.times_read > 1.0
    for most_mb in study.peak_memory_mb.values():
        assert most_mb is None or 30.0 < most_mb < 1000.0
    assert set(study.peak_memory_mb) == set(TIERS)


def test_a_better_drive_loses_less(study: ParetoStudy) -> None:
    assert study.rendering is not None
    points = {point.name: point for point in study.rendering.points}
    assert points["direct"].lost > points["clipped"].lost > points["standard"].lost
    assert points["scaled"].correlation > 0.999
    assert points[BEST].above_best == 0.0
    assert points["reference"].above_best < points["standard, render.solver_rate_hz=4000"].above_best
    assert "standard, render.tolerance=1e-5" in points
    assert BEST not in study.rendering_on_front
    assert all(point.cost.cpu_s_per_hour > 0.0 for point in points.values())


def test_accuracy_is_the_same_when_run_twice_and_by_several_processes(study: ParetoStudy, folder: Path) -> None:
    assert accuracies(measured(folder, jobs=2)) == accuracies(study)


def test_the_files_hold_the_figures(study: ParetoStudy, tmp_path: Path) -> None:
    write_pareto(tmp_path, study)
    assert {path.name for path in tmp_path.iterdir()} == set(FILES)
    assert msgspec.json.decode((tmp_path / "pareto.json").read_bytes(), type=ParetoStudy) == study
    with (tmp_path / "pareto.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert study.rendering is not None
    assert len(rows) == len(study.detection) + len(study.rendering.points)
    for row, score in zip(rows, study.detection, strict=False):
        assert row["name"] == score.name
        assert float(row["f1_10ms"]) == score.f1
        assert row["on_front"] == str(int(score.name in study.on_front))
    table = markdown(study)
    assert all(f"| {tier} |" in table for tier in TIERS)


def test_the_picture_names_the_tiers_and_is_the_same_for_the_same_study(study: ParetoStudy) -> None:
    svg = front_svg(study)
    assert svg == front_svg(study)
    texts = [each.text for each in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]
    for name in (*TIERS, "direct", "clipped", "scaled"):
        assert texts.count(name) == (2 if name in TIERS else 1), name


def test_the_commands_print_and_write(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("blastline.study.peers.PEERS", (LIGHT,))  # what a library takes to start is not the point
    written, wrong = tmp_path / "figures.json", tmp_path / "wrong"
    done = blastline("study", "detection", "--fixtures", folder, "-o", written, "--excerpts", wrong, "--peers")
    assert done.code == 0, done.err
    assert "at 10 ms, 95 % of films drawn anew" in done.out
    assert "first rise" in done.out
    read = msgspec.json.decode(written.read_bytes(), type=DetectionStudy)
    assert read.protocol == "scenes"
    errors = sum(case.false + case.missed for case in read.cases)
    assert len(list(wrong.glob("*.wav"))) == errors
    assert len((wrong / "events.csv").read_text().splitlines()) == 1 + errors
    refused = blastline("study", "detection", "--fixtures", folder, "--excerpts", wrong)
    assert "exists already" in refused.complaint
    assert "expected two levels" in blastline("study", "detection", "--corpus", folder, "--mix", "loud").complaint
    assert "lower level first" in blastline("study", "detection", "--corpus", folder, "--mix", "9,3").complaint
    assert "or rms:6,30" in blastline("study", "detection", "--corpus", folder, "--mix", "loudness:6,30").complaint


def test_the_command_ends_with_one_where_a_bar_is_missed(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "shot.toml").write_text(SCENE.rpartition("[[shots]]")[0].replace("5.0", "2.0"))
    done = blastline("study", "pareto", "--fixtures", folder, "--no-rendering", "-o", tmp_path / "out")
    study = msgspec.json.decode((tmp_path / "out" / "pareto.json").read_bytes(), type=ParetoStudy)
    assert study.rendering is None
    assert done.code == (0 if all(bar.met for bar in study.bars) else 1)
    assert done.out.count("\n*") == len([each for each in study.detection if each.name in study.on_front])
    assert np.isfinite([each.cost.times_read for each in study.detection]).all()
    complaint = blastline(
        "study", "pareto", "--fixtures", folder, "--try", "scan.no=1", "-o", tmp_path / "none"
    ).complaint
    assert "scan.no=1" in complaint


def test_detection_is_told_where_no_shot_is_weak(tmp_path: Path) -> None:
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    (scenes / "silent.toml").write_text(SCENE.partition("[[shots]]")[0])
    source = StudySource(scenes)
    found = study_pareto(source, changes={}, with_rendering=True)
    assert found.rendering is None
    assert len(found.detection) == len(TIERS)
    assert "none of these shots is weak" in pareto_table(found)
    write_pareto(tmp_path, found)
    assert (tmp_path / "pareto.svg").is_file()
