"""Scenes: the same to the bit however they are read, items that leave each other alone, and truth that holds."""

import itertools
import re
from collections import Counter
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
import pytest
import soundfile

from blastline.errors import OutputError, RuleError
from blastline.model import Span
from blastline.synth import (
    NEGATIVE_KINDS,
    Scene,
    SceneAudio,
    decode_truth,
    film_scene,
    load_scene,
    render_scene,
    synthesise,
    truth_of,
    write_scene,
)
from blastline.synth.apart import MARGIN_DB, stands_out_db
from blastline.synth.files import BLOCK_S
from blastline.synth.layouts import mains
from blastline.synth.master import limited, quantised
from blastline.synth.scene import Master
from blastline.synth.spread import expanded
from blastline.synth.tone import peak, rms
from blastline.units import db_from_gain, gain_from_db

RATE_HZ = 16_000


def scene_of(**tables: Any) -> Scene:
    plain = {"schema": 1, "rate_hz": RATE_HZ, "duration_s": 6.0, "seed": 3, "shots": [], "negatives": []} | tables
    return msgspec.convert(plain, Scene)


def shot(at_s: float, **keys: Any) -> dict[str, Any]:
    level = {} if "snr_db" in keys or "peak_dbfs" in keys else {"peak_dbfs": -12.0}
    return {"at_s": at_s, "weapon": "pistol", "environment": "street"} | level | keys


BED = {"kind": "ambience", "level_dbfs": -40.0}


def whole(scene: Scene) -> np.ndarray[Any, np.dtype[np.float64]]:
    audio = render_scene(scene)
    return audio.read(0, audio.frames)


def test_the_same_seed_gives_the_same_bits_and_another_seed_does_not() -> None:
    scene = scene_of(beds=[BED], shots=[shot(2.0)], negatives=[{"at_s": 4.0, "kind": "door", "snr_db": 20.0}])
    assert np.array_equal(whole(scene), whole(scene))
    assert not np.array_equal(whole(scene), whole(msgspec.structs.replace(scene, seed=4)))


@pytest.mark.parametrize("layout", ["mono", "stereo", "5.1"])
def test_blocks_of_any_size_give_the_same_bits(layout: str) -> None:
    beds = [BED, {"kind": "drums", "level_dbfs": -30.0, "start_s": 1.0, "stop_s": 5.0}]
    scene = scene_of(beds=beds, shots=[shot(2.0, burst={"shots": 4, "rpm": 900})], layout=layout)
    expected = whole(scene)
    for size in (7_001, 16_000):
        blocks = [block for _, block in render_scene(scene).blocks(size)]
        assert np.array_equal(np.concatenate(blocks), expected)
    steps = quantised(expected, 0, master=scene.master, seed=1)
    cuts = (0, 5, 65_535, 70_000, 96_000)
    parts = [quantised(expected[a:b], a, master=scene.master, seed=1) for a, b in itertools.pairwise(cuts)]
    assert np.array_equal(np.concatenate(parts), steps)


def test_another_item_leaves_the_others_as_they_were() -> None:
    few = scene_of(shots=[shot(2.0)])
    more = scene_of(
        shots=[shot(0.5, weapon="rifle"), shot(2.0)], negatives=[{"at_s": 1.0, "kind": "clap", "peak_dbfs": -6.0}]
    )
    audio, others = (
        render_scene(more),
        render_scene(scene_of(shots=more_shots(more)[:1], negatives=more_negatives(more))),
    )
    left = audio.read(0, audio.frames) - others.read(0, others.frames)
    assert np.allclose(left, whole(few), atol=1e-12)


def more_shots(scene: Scene) -> list[dict[str, Any]]:
    plain: list[dict[str, Any]] = msgspec.to_builtins(scene)["shots"]
    return plain


def more_negatives(scene: Scene) -> list[dict[str, Any]]:
    plain: list[dict[str, Any]] = msgspec.to_builtins(scene)["negatives"]
    return plain


def test_a_shot_starts_at_its_onset_in_an_empty_scene() -> None:
    for at_s in (0.0, 1.0, 2.123456):
        audio = render_scene(scene_of(shots=[shot(at_s)]))
        (truth,) = truth_of(audio).shots
        assert truth.onset_sample == round(at_s * RATE_HZ)
        samples = audio.read(0, audio.frames)[:, 0]
        assert not np.any(samples[: truth.start_sample])
        assert np.any(samples[truth.onset_sample : truth.onset_sample + 4])
        assert truth.peak_dbfs == pytest.approx(-12.0, abs=0.01)


def test_snr_is_the_peak_of_the_shot_over_what_lies_before_it() -> None:
    for snr_db in (6.0, 15.0, 24.0):
        scene = scene_of(beds=[BED], shots=[shot(3.0, snr_db=snr_db)])
        (truth,) = truth_of(render_scene(scene)).shots
        assert truth.snr_db == pytest.approx(snr_db, abs=0.1)
        bed = render_scene(scene_of(beds=[BED]))
        alone = whole(scene)[:, 0] - whole(scene_of(beds=[BED]))[:, 0]
        onset = truth.onset_sample
        level = rms(mains(bed.read(onset - RATE_HZ // 5, onset)))
        top = peak(alone[onset : onset + RATE_HZ // 20])
        assert db_from_gain(top) - db_from_gain(level) == pytest.approx(snr_db, abs=0.1)


def test_a_burst_keeps_its_rate() -> None:
    scene = scene_of(shots=[shot(1.0, burst={"shots": 8, "rpm": 900, "jitter": 0.0})])
    shots = truth_of(render_scene(scene)).shots
    spacing = np.diff([item.onset_sample for item in shots])
    assert spacing == pytest.approx(RATE_HZ * 60 / 900, abs=1)
    assert [item.shot_in_burst for item in shots] == list(range(8))
    assert {item.burst for item in shots} == {0}
    jittered = scene_of(shots=[shot(1.0, burst={"shots": 30, "rpm": 900, "jitter": 0.05})])
    late = np.array([item.onset_sample for item in truth_of(render_scene(jittered)).shots]) - RATE_HZ
    steady = np.arange(30) * RATE_HZ * 60 / 900
    assert np.abs(late - steady).max() <= 0.05 * RATE_HZ * 60 / 900 + 1
    assert np.std(late - steady) > 5.0


@pytest.mark.parametrize("environment", ["hall", "indoors", "street", "field", "far"])
@pytest.mark.parametrize("weapon", ["smg", "lmg", "suppressed"])
def test_every_shot_of_a_burst_stands_out_of_the_ones_before(weapon: str, environment: str) -> None:
    burst = {"shots": 9, "rpm": 1_100.0, "jitter": 0.02}
    for at_s in (1.0, 1.25):
        scene = scene_of(
            rate_hz=48_000, shots=[shot(at_s, weapon=weapon, environment=environment, burst=burst, peak_dbfs=-15.0)]
        )
        audio = render_scene(scene)
        samples = audio.read(0, audio.frames)[:, 0]
        shots = truth_of(audio).shots
        margins = [
            max(
                stands_out_db(samples, at, rate_hz=48_000) for at in (s.onset_sample, *s.accept_samples, s.start_sample)
            )
            for s in shots[1:]
        ]
        assert np.median(margins) >= MARGIN_DB[0] - 3.0  # gas and scatter differ from shot to shot


def test_a_step_stands_out_by_its_height_in_the_waveform_or_its_slope() -> None:
    low = np.sin(2.0 * np.pi * 50.0 * np.arange(9_600) / 48_000)
    step = np.where(np.arange(9_600) < 4_800, 0.1, 1.0) * np.sign(low)
    assert stands_out_db(step, 4_800, rate_hz=48_000) == pytest.approx(20.0, abs=0.1)
    click = low.copy()
    click[4_800:4_900] += 0.1
    assert stands_out_db(low, 4_800, rate_hz=48_000) < 1.0
    assert stands_out_db(click, 4_800, rate_hz=48_000) > 20.0
    assert stands_out_db(0.01 * click, 4_800, rate_hz=48_000) == pytest.approx(
        stands_out_db(click, 4_800, rate_hz=48_000)
    )


def test_a_mixer_turns_down_what_would_only_distort() -> None:
    loud = {"kind": "ambience", "level_dbfs": -10.0}
    asked = whole(scene_of(beds=[loud], shots=[shot(3.0, snr_db=40.0)]))
    held = whole(scene_of(beds=[loud], shots=[shot(3.0, snr_db=12.4)]))
    assert peak(asked - held) < 0.05
    freed = whole(scene_of(beds=[loud], shots=[shot(3.0, snr_db=40.0)], master={"drive_db": 40.0}))
    assert rms(freed[3 * RATE_HZ :]) > 1.2 * rms(asked[3 * RATE_HZ :])


def test_another_rate_keeps_the_times() -> None:
    scene = scene_of(shots=[shot(1.0, burst={"shots": 3, "rpm": 700}), shot(3.3)])
    here, there = (
        truth_of(render_scene(msgspec.structs.replace(scene, rate_hz=rate))).shots for rate in (16_000, 44_100)
    )
    for one, two in zip(here, there, strict=True):
        assert one.onset_s == pytest.approx(two.onset_s, abs=1.0 / 16_000)
        assert (one.weapon, one.rise_ms, one.distance_m) == (two.weapon, two.rise_ms, two.distance_m)


def test_a_reflection_comes_its_delay_behind_the_onset_and_is_as_long_as_the_blast() -> None:
    truth = truth_of(render_scene(scene_of(shots=[shot(1.0), shot(3.0, burst={"shots": 3, "rpm": 600})])))
    assert sum(len(item.reflections) for item in truth.shots) > 12
    for item in truth.shots:
        for echo in item.reflections:
            assert echo.start - item.onset_sample == pytest.approx(echo.delay_ms * RATE_HZ / 1000.0, abs=0.5)
            assert echo.stop - echo.start == item.blast.stop - item.blast.start


def test_shots_at_both_ends_stay_inside_the_scene() -> None:
    scene = scene_of(beds=[BED], shots=[shot(0.0), shot(5.9999), shot(5.99, burst={"shots": 5, "rpm": 600})])
    audio = render_scene(scene)
    truth = truth_of(audio)
    assert audio.read(0, audio.frames).shape == (audio.frames, 1)
    assert [item.onset_sample for item in truth.shots] == [0, round(5.99 * RATE_HZ), round(5.9999 * RATE_HZ)]
    for item in truth.shots:
        assert 0 <= item.blast.start <= item.blast.stop <= audio.frames
        assert all(echo.start < echo.stop <= audio.frames for echo in item.reflections)


def test_a_bed_has_its_level_and_stays_in_its_time() -> None:
    bed = {"kind": "ambience", "level_dbfs": -30.0, "fade_s": 0.0}
    scene = scene_of(beds=[bed | {"start_s": 20.0, "stop_s": 65.0}], duration_s=90.0)
    audio = render_scene(scene)
    assert not np.any(audio.read(0, 20 * RATE_HZ))
    assert not np.any(audio.read(65 * RATE_HZ, audio.frames))
    assert db_from_gain(rms(audio.read(20 * RATE_HZ, 65 * RATE_HZ))) == pytest.approx(-30.0, abs=1.0)


def test_a_bed_ends_as_it_begins() -> None:
    bed = {"kind": "ambience", "level_dbfs": -30.0, "start_s": 1.0, "stop_s": 5.0}
    faded, whole = (render_scene(scene_of(beds=[bed | {"fade_s": fade_s}])).beds(0, 6 * RATE_HZ) for fade_s in (1.0, 0))
    heard = np.abs(whole) > 1e-5
    weights = faded[heard] / whole[heard]
    from_edge_s = np.minimum(np.arange(0.5, 4 * RATE_HZ), np.arange(4 * RATE_HZ - 0.5, 0.0, -1.0)) / RATE_HZ
    expected = np.sin(np.minimum(from_edge_s, 1.0) * np.pi / 2.0) ** 2
    assert np.allclose(weights, expected[heard[RATE_HZ : 5 * RATE_HZ, 0]], atol=1e-9)


def test_the_limiter_leaves_the_quiet_alone_and_holds_the_ceiling() -> None:
    master = Master(ceiling_dbfs=-1.0, knee_db=4.0)
    ramp = np.linspace(-4.0, 4.0, 8_001)[:, None]
    out = limited(ramp, master)
    quiet = np.abs(ramp) <= gain_from_db(-5.0)
    assert np.array_equal(out[quiet], ramp[quiet])
    assert peak(out) <= gain_from_db(-1.0)
    slope = np.diff(out[:, 0]) / np.diff(ramp[:, 0])
    assert np.all((slope >= 0.0) & (slope <= 1.0 + 1e-9))
    beyond = slope[ramp[:-1, 0] > gain_from_db(-5.0)]
    assert beyond[0] == pytest.approx(1.0, abs=1e-3), "the knee is smooth"
    assert np.all(np.diff(beyond) <= 1e-9)
    assert np.array_equal(limited(-ramp, master), -out)


@pytest.mark.parametrize("bits", [16, 24])
def test_steps_are_the_nearest_without_dither_and_with_it_wander_as_two_throws_do(bits: Literal[16, 24]) -> None:
    """Triangular dither has a sixth of a step squared, and rounding then a twelfth, whatever the sound is."""
    samples = np.full((100_000, 1), 0.3 / 2 ** (bits - 1))
    errors = {
        dither: quantised(samples, 0, master=Master(bits=bits, dither=dither), seed=7) / 2.0 ** (32 - bits) - 0.3
        for dither in (False, True)
    }
    assert np.all(errors[False] == -0.3)
    assert np.mean(errors[True]) == pytest.approx(0.0, abs=0.01)
    assert np.var(errors[True]) == pytest.approx(1 / 6 + 1 / 12, rel=0.02)


def test_in_5_1_the_picture_is_in_front_and_the_lfe_has_only_the_bottom() -> None:
    scene = scene_of(beds=[{"kind": "dialogue", "level_dbfs": -30.0}], shots=[shot(3.0)], layout="5.1", rate_hz=48_000)
    audio = render_scene(scene)
    before = audio.read(0, 48_000)
    assert [bool(np.any(before[:, channel])) for channel in range(6)] == [False, False, True, False, False, False]
    lfe = audio.read(3 * 48_000, 4 * 48_000)[:, 3]
    spectrum = np.abs(np.fft.rfft(lfe))
    assert spectrum[:200].max() > 100.0 * spectrum[3_000:].max() > 0.0


def test_the_truth_that_is_written_with_the_sound_is_that_of_the_scene(tmp_path: Path) -> None:
    """The sound is written in blocks, and items lie in each, at their edges, and across them."""
    doors = [{"at_s": at_s, "kind": "door", "peak_dbfs": -20.0} for at_s in (0.5, BLOCK_S - 0.1, BLOCK_S + 3.0)]
    scene = scene_of(shots=[shot(1.0), shot(float(BLOCK_S)), shot(9.0)], negatives=doors, duration_s=2.0 * BLOCK_S)
    written = write_scene(scene, tmp_path)
    assert (len(written.shots), len(written.negatives)) == (3, 3)
    assert written == truth_of(render_scene(scene))
    assert written == decode_truth((tmp_path / f"{scene.name}.truth.json").read_bytes())


def test_a_film_has_what_was_asked_for_without_collisions() -> None:
    scene = film_scene(7, 300.0, 40, 60, rate_hz=RATE_HZ)
    audio = SceneAudio(scene)
    assert len(scene.negatives) == 60
    assert sum(1 if item.burst is None else item.burst.shots for item in scene.shots) == 40
    starts = sorted(item.at_s for item in (*scene.shots, *scene.negatives))
    assert min(np.diff(starts)) >= 0.3
    assert len(audio.cues) == 100
    assert not film_scene(7, 300.0, 40, 60, gun_free=True).shots
    assert film_scene(7, 300.0, 40, 60, rate_hz=RATE_HZ) == scene
    short = audio.read(0, 10 * RATE_HZ)
    assert np.isfinite(short).all()
    assert peak(short) <= 1.0


def test_random_negatives_are_of_every_kind_before_any_comes_again_where_none_is_asked_for() -> None:
    every = len(NEGATIVE_KINDS)
    for count in (every, every + 3):
        random = {"shots": 0, "negatives": count, "spacing_s": 0.5}
        counts = Counter(item.kind for item in expanded(scene_of(random=random, duration_s=60.0)).negatives)
        assert (set(counts), max(counts.values())) == (set(NEGATIVE_KINDS), 1 if count == every else 2)


def test_random_tables_add_to_what_is_written() -> None:
    random = {"shots": 9, "negatives": 5, "spacing_s": 0.1, "kinds": ["door", "clap"]}
    truth = truth_of(render_scene(scene_of(shots=[shot(1.0)], random=random, duration_s=20.0)))
    assert len(truth.shots) == 10
    assert sorted({item.kind for item in truth.negatives}) == ["clap", "door"]
    assert round(1.0 * RATE_HZ) in [item.onset_sample for item in truth.shots]


TOML = """schema = 1
rate_hz = 16000
duration_s = 2.0
seed = 5
[[beds]]
kind = "rain"
level_dbfs = -40.0
[[shots]]
at_s = 1.0
weapon = "rifle"
environment = "field"
snr_db = 30.0
"""


def test_the_files_hold_the_sound_and_its_truth(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    path.write_text(TOML + "[master]\nbits = 24\n")
    truth = synthesise(path, tmp_path / "out")
    samples, rate_hz = soundfile.read(tmp_path / "out" / "one.wav", always_2d=True)
    assert (rate_hz, len(samples)) == (truth.rate_hz, truth.frames)
    assert soundfile.info(tmp_path / "out" / "one.wav").subtype == "PCM_24"
    expected = whole(load_scene(path))
    assert np.abs(samples - expected).max() <= 1.6 / 2**23
    assert decode_truth((tmp_path / "out" / "one.truth.json").read_bytes()) == truth
    assert truth.shots == tuple(render_scene(load_scene(path)).shot_truths(Span(0, truth.frames)))
    with pytest.raises(OutputError, match=r"exists already"):
        synthesise(path, tmp_path / "out")


def test_a_shot_beside_the_edge_of_a_block_is_listed_once(tmp_path: Path) -> None:
    edge = BLOCK_S * RATE_HZ
    frames = (edge - 1, edge, edge + 1)
    scene = scene_of(shots=[shot(frame / RATE_HZ) for frame in frames])
    assert [item.onset_sample for item in write_scene(scene, tmp_path).shots] == list(frames)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"rifle"', '"rifles"', r"shots\[0\]\.weapon = 'rifles': expected one of: lmg, pistol, rifle, "),
        ("at_s = 1.0", "at_s = 1.99998", r"shots\[0\]\.at_s = 1\.99998: expected less than .* by a sample or more"),
        ("seed = 5\n", "", r"seed: is missing"),
        ("seed = 5\n", "seed = 5\nname = 'street'\n", r"name: no such key; a scene is named after its file$"),
        ("snr_db = 30.0", "snr_dB = 30.0", r"shots\[0\].snr_dB: no such key"),
        ("snr_db = 30.0", "snr_db = 30.0\npeak_dbfs = -3.0", r"shots\[0\]: expected one of snr_db and peak_dbfs"),
        ("snr_db = 30.0\n", "", r"shots\[0\]: expected one of snr_db and peak_dbfs"),
        ("at_s = 1.0", "at_s = 3.0", r"shots\[0\]\.at_s = 3\.0: expected less than duration_s = 2\.0"),
        ("rate_hz = 16000", "rate_hz = 100", r"rate_hz = 100: expected a whole number, 8000 or more"),
        ("level_dbfs = -40.0", "level_dbfs = -40.0\nstart_s = 1.0\nstop_s = 1.0", r"beds\[0\]\.stop_s = 1\.0"),
        ("seed = 5", "seed = ", r"not a TOML file"),
        ("seed = 5\n", "seed = 5\nrandom = {shots = 1, shot_snr_db = [-1e9, 1e9]}\n", r"random\.shot_snr_db\[0\]"),
        ('"rain"', '"hail"', r"beds\[0\]\.kind = 'hail': expected one of: ambience, crowd, "),
        ("seed = 5\n", "seed = 5\nlayout = 'quad'\n", r"layout = 'quad': expected one of: 5\.1, 7\.1, mono, stereo$"),
        ("seed = 5\n", "seed = 5\nmaster = {bits = 12}\n", r"master\.bits = 12: expected one of: 16, 24$"),
        (
            "seed = 5\n",
            "seed = 5\nrandom = {kinds = ['door', 'bang']}\n",
            r"random\.kinds\[1\] = 'bang': expected one of: ",
        ),
    ],
)
def test_a_scene_that_does_not_fit_is_one_line(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    path = tmp_path / "bad.toml"
    assert old in TOML
    path.write_text(TOML.replace(old, new))
    with pytest.raises(RuleError, match=re.escape(str(path)) + ": " + complaint) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)
