"""The study of segmentation: right scores 1, wrong 0, and what is there but masked counts neither way."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from blastline.detect import find_shots
from blastline.model import Clip, Reflection, Shot, Span
from blastline.ruleset import load_rules
from blastline.study.cases import scenes
from blastline.study.cost import listened
from blastline.study.detection import listener
from blastline.study.segmentation import Film, Parting, PartingTally, scene_films, score, shots_at_truth
from blastline.synth import Scene, ShotTruth, render_scene, truth_of
from blastline.synth.truth import TrueReflection
from commands import blastline

RATE_HZ = 48_000


def truth(*echoes: tuple[float, float, bool], blast_ms: float = 3.0) -> ShotTruth:
    """Return a shot at one second with echoes as (delay in ms, level in dB, heard)."""
    at = RATE_HZ
    return ShotTruth(
        onset_sample=at,
        onset_s=1.0,
        start_sample=at,
        weapon="pistol",
        environment="street",
        distance_m=5.0,
        rise_ms=0.1,
        snr_db=30.0,
        peak_dbfs=-6.0,
        blast=Span(at, at + round(blast_ms * 48)),
        reflections=tuple(
            TrueReflection(at + round(ms * 48), at + round(ms * 48) + 96, ms, level_db, audible=audible)
            for ms, level_db, audible in echoes
        ),
        heard_blast=Span(at, at + round(blast_ms * 48)),
    )


def found(*echoes: tuple[float, float], late_ms: float = 0.0, blast_ms: float = 3.0) -> Shot:
    at = RATE_HZ + round(late_ms * 48)
    return Shot(
        onset=at,
        confidence=1.0,
        peak_dbfs=-6.0,
        snr_db=30.0,
        blast=Span(at, at + round(blast_ms * 48)),
        reflections=tuple(
            Reflection(at + round(ms * 48), at + round(ms * 48) + 96, ms, level_db) for ms, level_db in echoes
        ),
        span=Span(at, at + RATE_HZ),
    )


def parting(true: ShotTruth, shot: Shot) -> Parting:
    tally = PartingTally(longest_ms=12.0)
    tally.add([true], [shot], RATE_HZ)
    return tally.parting()


def test_a_perfect_parting_scores_one() -> None:
    scored = parting(truth((20.0, -6.0, True), (90.0, -20.0, True)), found((20.0, -6.0), (90.0, -20.0)))
    assert (scored.asked, scored.precision, scored.recall, scored.f1) == (1, 1.0, 1.0, 1.0)
    assert (scored.every_asked, scored.every_f1) == (2, 1.0)
    assert (scored.blast_p95_ms, scored.start_p95_ms) == (0.0, 0.0)


def test_an_echo_three_milliseconds_off_is_false_and_missed() -> None:
    scored = parting(truth((20.0, -6.0, True)), found((23.0, -6.0)))
    assert (scored.precision, scored.recall) == (0.0, 0.0)
    assert scored.start_median_ms == pytest.approx(3.0)


def test_a_late_onset_moves_no_echo() -> None:
    scored = parting(truth((20.0, -6.0, True)), found((19.0, -6.0), late_ms=1.0, blast_ms=2.0))
    assert scored.f1 == 1.0
    assert scored.start_p95_ms == pytest.approx(0.0)
    assert scored.blast_p95_ms == pytest.approx(0.0)


def test_what_is_masked_is_not_asked_for_and_not_held_against_the_finder() -> None:
    masked = truth((20.0, -6.0, False))
    assert (parting(masked, found()).asked, parting(masked, found()).f1) == (0, 1.0)
    assert parting(masked, found((20.2, -6.0))).precision == 1.0
    assert parting(masked, found((22.0, -6.0))).precision == 0.0


def test_a_weak_claim_is_no_hit_for_a_strong_echo() -> None:
    scored = parting(truth((20.0, -6.0, True)), found((20.0, -19.0)))
    assert scored.recall == 0.0
    assert scored.every_recall == 1.0


def test_a_blast_longer_than_the_rules_allow_counts_as_that_long() -> None:
    scored = parting(truth(blast_ms=40.0), found(blast_ms=12.0))
    assert (scored.blasts_cut, scored.blast_p95_ms) == (1, 0.0)


SCENE = """
schema = 1
rate_hz = 24000
duration_s = 3.0
seed = 5
[[shots]]
at_s = 1.0
weapon = "rifle"
environment = "street"
peak_dbfs = -3.0
recording = "clean"
"""


def test_the_command_prints_the_bars_and_writes_every_figure(tmp_path: Path) -> None:
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    (scenes / "one.toml").write_text(SCENE)
    written = tmp_path / "figures.json"
    result = blastline("study", "segmentation", "--fixtures", scenes, "-o", written)
    assert result.code in (0, 1)
    assert "echoes counted as shots" in result.out
    assert msgspec.json.decode(written.read_bytes())["films"] == 1


def test_the_command_asks_for_something_to_listen_to() -> None:
    assert blastline("study", "segmentation").code == 2


def test_true_onsets_are_parted_as_the_detector_parts_them(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    path.write_text(SCENE)
    audio = render_scene(msgspec.toml.decode(path.read_bytes(), type=Scene))
    film = Film("one", None, audio.read(0, audio.frames)[:, 0].astype(np.float32), truth_of(audio))
    (shot,) = shots_at_truth(film, load_rules("standard").tier)
    assert shot.onset == film.truth.shots[0].onset_sample
    assert len(shot.blast) > 0


def test_starts_are_compared_with_the_echo_that_is_nearest() -> None:
    scored = parting(truth((20.0, -6.0, True), (27.0, -6.0, True)), found((27.0, -6.0)))
    assert scored.start_p95_ms == 0.0


def test_shots_are_found_beside_the_centre_as_a_run_finds_them(tmp_path: Path) -> None:
    shots = "".join(
        f'[[shots]]\nat_s = {at_s}\nweapon = "pistol"\nenvironment = "field"\nsnr_db = 3.0\nazimuth_deg = {side}\n'
        for at_s, side in ((1.0, 100.0), (2.5, -100.0), (4.0, 100.0))
    )
    bed = '[[beds]]\nkind = "dialogue"\nlevel_dbfs = -18.0\n'
    scene = f'schema = 1\nrate_hz = 48000\nduration_s = 6.0\nseed = 3\nlayout = "5.1"\n{bed}{shots}'
    (tmp_path / "drowned.toml").write_text(scene)
    tier = load_rules("standard").tier
    aside = score(scene_films(tmp_path), "standard").found_shots
    (case,) = scenes(tmp_path, tmp_path / "made")
    there = listener("standard", tier)
    assert aside == len(listened(case.path, tier, there.verifier).detection.shots) == 3
    (film,) = scene_films(tmp_path)
    clip = Clip(film.samples[:, None], film.truth.rate_hz)
    assert len(find_shots([clip], rate_hz=48_000, tier=tier, verifier=there.verifier).shots) < 3
