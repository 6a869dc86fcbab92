"""What the studies of detection listen to: mixes and clips of recordings, and peers that listen along."""

import importlib
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.errors import RuleError
from blastline.study.cases import GUN_FREE_EVERY, Case, random_films, scenes
from blastline.study.corpus import load_sound, read_corpus
from blastline.study.datasets import FOLD_SEED, FOLDS, by_fold
from blastline.study.detection import study_detection
from blastline.study.filmlike import CLIP_S, film_mixes, one_shot_clips, stock
from blastline.study.mixes import Levels, Sound, mix
from blastline.study.peer_scores import PeerTally, heard_by, opened, warm
from blastline.study.peers import PEERS, Peer, installed
from blastline.study.sources import StudySource
from blastline.study.workers import each_of

RATE_HZ = 48_000


def bang(onset: int, frames: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    samples = np.zeros(frames)
    length = frames - onset
    samples[onset:] = 0.8 * np.random.default_rng(seed).standard_normal(length) * np.exp(-np.arange(length) / 1500.0)
    return np.clip(samples, -1.0, 1.0)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return two recordings of shots, one of them unsure, a knock, and a quiet bed."""
    made = tmp_path_factory.mktemp("corpus")
    rng = np.random.default_rng(1)
    sounds = {
        "sure.wav": bang(12_000, 48_000, 1),
        "unsure.wav": bang(9_600, 48_000, 2),
        "knock.wav": bang(0, 9_600, 3) * np.cos(np.arange(9_600) / 9.0),
        "bed.wav": 1e-2 * rng.standard_normal(6 * RATE_HZ),
    }
    for name, samples in sounds.items():
        soundfile.write(made / name, samples, RATE_HZ, subtype="PCM_16")
    rows = [
        "path,source,label,sub_label,duration_s,onsets_s,notes",
        "sure.wav,one,gunshot,rifle,1.0,0.25,",
        "unsure.wav,two,gunshot,boom,1.0,0.2,slow or two-stage attack",
        "knock.wav,three,negative,knock,0.2,,",
        "bed.wav,four,negative,noise,6.0,,",
    ]
    (made / "annotations.csv").write_text("\n".join(rows))
    return made


def test_a_mix_is_always_the_same_and_one_in_four_has_no_shot(corpus: Path, tmp_path: Path) -> None:
    films = 4
    runs = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        runs.append(
            list(
                film_mixes(
                    stock(read_corpus([corpus])), tmp_path / name, films=films, levels=Levels(20.0, 30.0), seed=3
                )
            )
        )
    for one, other in zip(*runs, strict=True):
        assert one.path.read_bytes() == other.path.read_bytes()
        assert np.array_equal(one.true_ms, other.true_ms)
    assert [case.true_ms.size > 0 for case in runs[0]] == [True] * (GUN_FREE_EVERY - 1) + [False]
    shots = runs[0][0]
    assert ((shots.snr_db >= 20.0) & (shots.snr_db <= 30.0)).all()
    assert 0 < shots.timed.sum() < shots.timed.size


def test_random_films_are_always_the_same_and_one_in_four_has_no_gun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("blastline.study.cases.FILM_S", 12.0)
    monkeypatch.setattr("blastline.study.cases.SHOTS", (2, 5))
    monkeypatch.setattr("blastline.study.cases.OTHERS", (2, 5))
    first, second = (list(random_films(tmp_path / name, films=4, seed=2)) for name in ("first", "second"))
    for one, other in zip(first, second, strict=True):
        assert one.path.read_bytes() == other.path.read_bytes()
        assert np.array_equal(one.true_ms, other.true_ms)
    assert [case.true_ms.size > 0 for case in first] == [True, True, True, False]
    assert len({case.path.read_bytes() for case in first}) == 4


def test_scenes_made_at_once_are_those_made_in_turn(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    for number in range(3):
        scene = f"schema = 1\nrate_hz = 48000\nduration_s = 1.0\nseed = {number}\n"
        bed = '[[beds]]\nkind = "ambience"\nlevel_dbfs = -40.0\n'
        (folder / f"scene-{number}.toml").write_text(scene + bed)
    alone, together = (list(scenes(folder, tmp_path / f"by-{jobs}", jobs=jobs)) for jobs in (1, 2))
    assert [case.name for case in together] == ["scene-0", "scene-1", "scene-2"]
    assert [case.path.read_bytes() for case in together] == [case.path.read_bytes() for case in alone]
    (folder / "scene-1.toml").write_text("schema = 2\n")
    with pytest.raises(RuleError, match=r"scene-1\.toml"):
        list(scenes(folder, tmp_path / "wrong", jobs=2))


def test_a_mixed_shot_begins_where_it_says(corpus: Path, tmp_path: Path) -> None:
    sounds = stock(read_corpus([corpus]))
    knocks = [group for group in sounds.others if group[0].sub_label == "knock"]
    (case,) = film_mixes(replace(sounds, others=knocks), tmp_path, films=1, levels=Levels(40.0, 40.0), seed=3)
    samples, rate_hz = soundfile.read(case.path)
    assert rate_hz == RATE_HZ
    for at_ms in case.true_ms.tolist():
        onset = round(at_ms * RATE_HZ / 1000.0)
        assert np.abs(samples[onset : onset + 240]).max() > 3.0 * np.abs(samples[onset - 480 : onset - 24]).max()


def test_half_of_the_clips_have_one_shot_at_its_level(corpus: Path, tmp_path: Path) -> None:
    cases = list(one_shot_clips(stock(read_corpus([corpus])), tmp_path, clips=6, seed=3))
    assert [case.true_ms.size for case in cases] == [1, 0, 1, 0, 1, 0]
    assert [float(level) for case in cases for level in case.snr_db] == [-6.0, 0.0, 6.0]
    for case in cases[::2]:
        samples, _ = soundfile.read(case.path)
        assert samples.size == CLIP_S * RATE_HZ
        onset = round(float(case.true_ms[0]) * RATE_HZ / 1000.0)
        # the bed is even noise, and both recordings end 0.75 to 0.8 s after their shot
        shot, bed = samples[onset : onset + 37_200], samples[: onset - 480]
        added = np.mean(shot**2) - np.mean(bed**2)
        assert 10.0 * np.log10(added / np.mean(bed**2)) == pytest.approx(float(case.snr_db[0]), abs=1.0)


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        (StudySource(), "either --fixtures or --random, or --corpus"),
        (StudySource(fixtures=Path("a"), corpus=(Path("b"),)), "either --fixtures or --random, or --corpus"),
        (StudySource(fixtures=Path("a"), clips=True), "give --corpus"),
        (StudySource(fixtures=Path("a"), mix=Levels(0.0, 6.0)), "give --corpus"),
        (StudySource(fixtures=Path("a"), fold=0), "give --corpus"),
    ],
)
def test_a_source_that_is_none_is_refused(source: StudySource, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(RuleError, match=complaint):
        list(source.cases(tmp_path))


def test_folds_share_no_source_and_are_those_of_training(corpus: Path, tmp_path: Path) -> None:
    parts = by_fold(read_corpus([corpus]), FOLDS, FOLD_SEED)
    for fold, part in enumerate(parts):
        cases = list(StudySource(corpus=(corpus,), fold=fold).cases(tmp_path))
        assert [case.path for case in cases] == [recording.path for recording in part]
    with pytest.raises(RuleError, match="--fold 3"):
        list(StudySource(corpus=(corpus,), fold=3).cases(tmp_path))


def test_recordings_without_a_shot_make_no_mix(corpus: Path, tmp_path: Path) -> None:
    rows = (corpus / "annotations.csv").read_text().splitlines()
    (tmp_path / "annotations.csv").write_text("\n".join([rows[0], *rows[3:]]))
    with pytest.raises(RuleError, match="no recording of a gunshot"):
        stock(read_corpus([tmp_path]))


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.package)
def test_a_peer_hears_bursts_of_noise_and_is_scored_as_we_are(peer: Peer, tmp_path: Path) -> None:
    if not installed([peer])[0]:
        pytest.skip(f"{peer.package} is not installed")
    rng = np.random.default_rng(0)
    samples = 1e-3 * rng.standard_normal(4 * RATE_HZ)
    true_ms = np.array([500.0, 1400.0, 2600.0])
    for at in (24_000, 67_200, 124_800):
        samples[at : at + 4800] += 0.2 * rng.standard_normal(4800) * np.exp(-np.arange(4800) / 900.0)
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_16")
    case = Case("film", path, true_ms, np.full(3, 40.0), np.ones(3, bool))
    tally = PeerTally(peer)
    warm(peer)
    tally.add(case, heard_by(peer, *opened(case)))
    score = tally.score(read_s=0.001, minutes=4.0 / 60.0)
    assert score.f1_by_window_ms["50"] > 0.8
    assert score.cost.times_read > 0.0
    assert set(score.thresholds_by_window_ms.values()) <= set(peer.thresholds)


def test_each_window_has_the_threshold_that_is_best_for_it() -> None:
    """A peer that finds all shots 20 ms late at one threshold, and half of them exactly at another."""
    true_ms = np.array([100.0, 600.0, 1100.0, 1600.0])
    peer = Peer(
        "made up", "none", (1.0, 2.0), lambda s, r: s, lambda s, r, t: true_ms + 20.0 if t == 1.0 else true_ms[:2]
    )
    case = Case("film", Path("none"), true_ms, np.full(4, 40.0), np.ones(4, bool))
    tally = PeerTally(peer)
    tally.add(case, heard_by(peer, np.zeros(10, np.float32), RATE_HZ, 0.0))
    score = tally.score(read_s=1.0, minutes=1.0)
    assert score.thresholds_by_window_ms == {"2": 2.0, "10": 2.0, "50": 1.0, "500": 1.0}
    assert score.f1_by_window_ms["50"] == 1.0
    assert score.f1 == pytest.approx(2 / 3)


def test_a_peer_that_is_not_installed_is_named() -> None:
    module = importlib.import_module("blastline.study.peers")
    peer = Peer("made up", "no_such_package", (1.0,), module.PEERS[0].prepare, module.PEERS[0].pick)
    there, absent = installed([*PEERS[:1], peer])
    assert [each.package for each in there] == ["librosa"]
    assert absent == ("no_such_package",)


def test_a_shot_is_as_loud_over_the_bed_as_its_own_peak() -> None:
    wave = np.zeros(RATE_HZ)
    wave[4_800], wave[24_000] = 0.9, 0.009
    rng, bed = np.random.default_rng(1), 1e-2 * np.random.default_rng(2).standard_normal(4 * RATE_HZ)
    made = mix(bed, [Sound(wave, (4_800, 24_000))], rng=rng, rate_hz=RATE_HZ, levels=Levels(20.0, 20.0))
    assert made.level_db == pytest.approx([20.0, -20.0], abs=0.1)


def test_by_its_rms_the_event_adds_as_much_power_as_its_level_says() -> None:
    """As DCASE 2017 has it, from the onset to the end of the sound; what is before the onset says nothing."""
    rng = np.random.default_rng(3)
    wave = np.concatenate([np.zeros(RATE_HZ), rng.standard_normal(RATE_HZ) * np.exp(-np.arange(RATE_HZ) / 4_800.0)])
    bed = 1e-2 * rng.standard_normal(6 * RATE_HZ)
    made = mix(bed, [Sound(wave, (RATE_HZ,))], rng=rng, rate_hz=RATE_HZ, levels=Levels(12.0, 12.0, "rms"))
    (onset,) = made.onsets.tolist()
    bed_only = np.concatenate([made.samples[: onset - 480], made.samples[onset + RATE_HZ :]]).astype(np.float64)
    event = made.samples[onset : onset + RATE_HZ].astype(np.float64)
    added = np.mean(event**2) / np.mean(bed_only**2) - 1.0
    assert made.level_db == pytest.approx([12.0])
    assert 10.0 * np.log10(added) == pytest.approx(12.0, abs=1.0)


def test_onsets_after_the_end_of_their_sound_are_refused(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "short.wav", bang(4_800, 24_000, 1), RATE_HZ)
    rows = ["path,source,label,sub_label,duration_s,onsets_s,notes", "short.wav,one,gunshot,rifle,9.0,0.1;4.0,"]
    (tmp_path / "annotations.csv").write_text("\n".join(rows))
    told = r"short\.wav: .* 4 .*: expected seconds before the end of the sound, at 0\.5 s"
    for source in (StudySource(corpus=(tmp_path,)), StudySource(corpus=(tmp_path,), mix=Levels(6.0, 6.0), films=1)):
        (tmp_path / str(source.mix)).mkdir()
        with pytest.raises(RuleError, match=told):
            study_detection(source, tmp_path / str(source.mix), "draft")


def test_a_shot_of_which_nothing_is_heard_is_refused(tmp_path: Path) -> None:
    silent = bang(4_800, 24_000, 1)
    silent[12_000:] = 0.0
    soundfile.write(tmp_path / "short.wav", silent, RATE_HZ)
    rows = ["path,source,label,sub_label,duration_s,onsets_s,notes", "short.wav,one,gunshot,rifle,0.5,0.1;0.3,"]
    (tmp_path / "annotations.csv").write_text("\n".join(rows))
    (recording,) = read_corpus([tmp_path])
    with pytest.raises(RuleError, match=r"short\.wav: onsets_s = 0\.3 in .*: expected a shot; the 50 ms after it are"):
        load_sound(recording, RATE_HZ)


def test_clips_and_mixes_are_not_asked_for_together(corpus: Path, tmp_path: Path) -> None:
    with pytest.raises(RuleError, match="either --clips or --mix"):
        StudySource(corpus=(corpus,), mix=Levels(6.0, 30.0), clips=True).cases(tmp_path)


def test_a_study_that_is_broken_off_waits_for_no_film() -> None:
    films_s = [0.0, 60.0, 60.0, 60.0]
    done = each_of(time.sleep, films_s, jobs=2)
    assert next(done) == (0.0, None)
    began_s = time.monotonic()
    del done
    assert time.monotonic() - began_s < 30.0


def test_a_film_that_cannot_be_measured_is_told_by_its_error_alone(capfd: pytest.CaptureFixture[str]) -> None:
    """What waits behind it is given up without a word, and without a traceback of the pool."""
    with pytest.raises(ValueError, match="must be non-negative"):
        list(each_of(time.sleep, [-1.0, *[0.2] * 8], jobs=2))
    assert capfd.readouterr().err == ""
