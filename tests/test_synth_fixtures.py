"""The fixtures: readable, many enough, wide enough, and the weak ones as weak as they have to be."""

from pathlib import Path

import numpy as np
import pytest

from blastline import dsp
from blastline.ruleset import load_actuator
from blastline.synth import load_scene, render_scene, truth_of
from blastline.synth.negatives import NEGATIVE_KINDS
from blastline.synth.tone import rms

FIXTURES = Path(__file__).parents[1] / "fixtures"
SCENES = {path.stem: load_scene(path) for path in sorted(FIXTURES.glob("*.toml"))}
GUN_FREE = ("quiet-town", "workshop")


def shots_of(name: str) -> int:
    scene = SCENES[name]
    written = sum(1 if item.burst is None else item.burst.shots for item in scene.shots)
    return written + (scene.random.shots if scene.random else 0)


def test_there_are_shots_enough_and_twenty_minutes_without_any() -> None:
    assert sum(shots_of(name) for name in SCENES) >= 120
    assert [shots_of(name) for name in GUN_FREE] == [0, 0]
    assert sum(SCENES[name].duration_s for name in GUN_FREE) == 1_200.0
    assert 500.0 < sum(scene.duration_s for name, scene in SCENES.items() if name not in GUN_FREE) < 700.0


def test_every_kind_of_negative_is_heard_somewhere() -> None:
    heard = {kind for scene in SCENES.values() if scene.random for kind in scene.random.kinds}
    heard |= {item.kind for scene in SCENES.values() for item in scene.negatives}
    assert set(NEGATIVE_KINDS) <= heard
    assert "explosion" not in heard


@pytest.mark.parametrize("name", ["street", "indoors", "field"])
def test_levels_spread_widely_and_mostly_above_12_db(name: str) -> None:
    levels = [item.snr_db for item in truth_of(render_scene(SCENES[name])).shots]
    assert min(levels) < 15.0 < 28.0 < max(levels)
    assert np.mean(np.array(levels) >= 11.9) >= 0.8


def test_the_edges_are_the_first_and_the_last_frame() -> None:
    audio = render_scene(SCENES["edges"])
    onsets = [item.onset_sample for item in truth_of(audio).shots]
    assert onsets[0] == 0
    assert onsets[-1] == audio.frames - 1
    assert 0.03 <= min(np.diff(onsets)[:-1]) / audio.rate_hz <= 0.05
    assert abs(audio.read(audio.frames - 1, audio.frames).item()) > 0.1


def test_the_weak_shots_are_felt_at_less_than_half_in_direct_conversion() -> None:
    audio = render_scene(SCENES["weak"])
    profile, _ = load_actuator("crowson-t108sm")
    felt, band = (dsp.discretise(part(profile), audio.rate_hz) for part in (dsp.felt_response, dsp.band))
    truth = truth_of(audio)
    assert len(truth.shots) >= 13
    assert min(np.diff([item.onset_sample for item in truth.shots])) >= 2 * audio.rate_hz
    for item in truth.shots:
        sound = audio.read(item.onset_sample, item.onset_sample + audio.rate_hz)[:, 0]
        assert rms(dsp.run_filter(felt, sound)) < 0.5 * rms(dsp.run_filter(band, sound))
