"""The study of rendering on a scene of its own: what it says must hold of its figures, and the bars must bite."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from blastline.errors import RuleError
from blastline.model import Span
from blastline.ruleset import load_rules
from blastline.study.bars import Bar
from blastline.study.drives import render_setup, windowed_error
from blastline.study.rendering import RenderingScore, score
from blastline.study.truth import true_scenes
from commands import blastline
from render_signals import PROFILE

SCENE = """
schema = 1
rate_hz = 48000
duration_s = 3.0
seed = 4
[[beds]]
kind = "ambience"
level_dbfs = -66.0
[[shots]]
at_s = 0.7
weapon = "pistol"
environment = "field"
distance_m = 1.0
peak_dbfs = -1.5
positive_ms = 0.4
recording = "clean"
[[shots]]
at_s = 1.6
weapon = "smg"
environment = "field"
distance_m = 4.0
peak_dbfs = -2.0
recording = "clean"
burst = { shots = 3, rpm = 800.0 }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("scenes")
    (made / "two.toml").write_text(SCENE)
    (made / "silent.toml").write_text("schema = 1\nrate_hz = 48000\nduration_s = 1.0\nseed = 1\n")
    return made


@pytest.fixture(scope="module")
def scored(folder: Path) -> RenderingScore:
    return score(folder)


def bar(scored: RenderingScore, name: str) -> Bar:
    (found,) = [each for each in scored.bars if each.name.startswith(name)]
    return found


def test_truth_places_every_shot_and_skips_scenes_without(folder: Path) -> None:
    scenes = list(true_scenes(folder, load_rules("standard").tier))
    assert [scene.name for scene in scenes] == ["two"]
    (scene,) = scenes
    assert len(scene.shots) == 4
    assert scene.shots[0].onset / 48_000 == pytest.approx(0.7, abs=0.05)
    assert [index for planned in scene.windows for index in planned.shots] == [0, 1, 2, 3]
    assert all(Span(0, scene.frames) & planned.window.span == planned.window.span for planned in scene.windows)


def test_four_drives_keep_their_order(scored: RenderingScore) -> None:
    assert scored.all_shots == 4
    for rows in scored.shots.values():
        assert rows
        for row in rows:
            assert row.needed > 1.0
            direct, clipped, scaled, best = (row.felt[n] for n in ("direct", "clipped", "scaled", "constrained"))
            assert direct.ratio < 0.5
            assert best.ratio > direct.ratio
            assert scaled.correlation > 0.999
            assert best.peak <= 1.0
            # what is minimised: |felt - wanted|^2 over |wanted|^2
            assert misfit(best.ratio, best.correlation) < misfit(clipped.ratio, clipped.correlation)


def misfit(ratio: float, correlation: float) -> float:
    return 1.0 + ratio**2 - 2.0 * ratio * correlation


def test_bars_of_fidelity_hold(scored: RenderingScore) -> None:
    for phase in ("causal", "zero"):
        for name in ("mean ratio", "mean correlation", "peak", "drive before the lead"):
            assert bar(scored, f"constrained, {phase}: {name}").met
        assert bar(scored, f"filter, {phase}: largest lag").met
        assert bar(scored, f"filter by windows against the whole track, {phase}").met
        assert bar(scored, f"the same with all of the film as pre-roll, {phase}").measured == 0.0


def test_solver_reaches_what_scipy_reaches(scored: RenderingScore) -> None:
    assert scored.optima
    for each in scored.optima:
        assert -1e-4 < each.excess < 1e-3
        assert 4000.0 <= each.rate_hz <= 8000.0
        assert 0.0 < each.reference < 0.9


def test_means_are_those_of_the_rows(scored: RenderingScore) -> None:
    rows = scored.shots["causal"]
    means = scored.means("causal", "constrained")
    assert means.ratio == pytest.approx(np.mean([row.felt["constrained"].ratio for row in rows]))
    assert np.isnan(scored.means("causal", "constrained", "no such scene").ratio)


def test_a_short_pre_roll_shows(folder: Path) -> None:
    tier = load_rules("standard").tier
    for scene in true_scenes(folder, tier):
        setup = render_setup(PROFILE, 48_000, "causal", tier.render)
        errors = [windowed_error(scene, setup, preroll_ms=ms) for ms in (10.0, 100.0, 600.0, 3000.0)]
        assert errors == sorted(errors, reverse=True)
        assert errors[0] > 10.0 * errors[2]
        assert errors[-1] == 0.0


def test_a_bar_that_is_missed_says_so() -> None:
    assert Bar("lag", 0.6, 0.5).margin == pytest.approx(-0.1)
    assert not Bar("lag", 0.6, 0.5).met
    assert Bar("ratio", 0.9, 0.83, better="above").met
    assert not Bar("ratio", float("nan"), 0.83, better="above").met


def test_command_prints_the_table_and_writes_every_figure(folder: Path, tmp_path: Path) -> None:
    written = tmp_path / "figures.json"
    done = blastline("study", "rendering", "--fixtures", folder, "--quality", "draft", "-o", written)
    assert done.code in (0, 1)
    assert "constrained, causal: mean ratio" in done.out
    read = msgspec.json.decode(written.read_bytes(), type=RenderingScore)
    assert read.quality == "draft"
    assert done.code == (0 if all(each.met for each in read.bars) else 1)


def test_folder_without_shots_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RuleError, match=r"no scene .* with shots"):
        score(tmp_path)


def test_what_was_not_measured_meets_no_bar(tmp_path: Path) -> None:
    (tmp_path / "faint.toml").write_text(SCENE.partition("[[shots]]\nat_s = 1.6")[0].replace("-1.5", "-60.0"))
    scored = score(tmp_path, quality="draft")
    assert not scored.shots["causal"]
    for name in ("constrained, causal: mean ratio", "constrained, zero: largest lag", "constrained rendering: CPU"):
        assert not bar(scored, name).met


def test_a_lag_without_delay_is_counted_in_samples_of_its_own_film(scored: RenderingScore) -> None:
    lags = [abs(row.felt["scaled"].lag_ms) * row.rate_hz / 1000.0 for row in scored.shots["zero"]]
    found = bar(scored, "filter, zero: largest lag")
    assert found.measured == pytest.approx(max(lags))
    assert (found.limit, found.unit) == (1.0, "samples")
