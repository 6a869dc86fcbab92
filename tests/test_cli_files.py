"""The command line on real files: what it writes, what it refuses, and what is left when it is broken off."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile

from blastline.export import read_timeline
from blastline.report import CHECKS
from blastline.run import rendering
from commands import BELIEVE, COMMAND, RATE_HZ, blastline, blastline_alone, interrupted, write_film
from media import write_media
from moments import moments

RESULTS = ["drive.wav", "report.html", "timeline.csv", "timeline.json"]
SHOTS_S = (1.0, 2.5)


@pytest.fixture(scope="session")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_film(tmp_path_factory.mktemp("film") / "film.wav", length_s=4.0, shots_s=SHOTS_S)


@pytest.fixture(scope="session")
def believing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return rules that take every candidate for a shot, so that no test depends on what the verifier has learnt."""
    folder = tmp_path_factory.mktemp("rules")
    for quality in ("draft", "standard"):
        (folder / "quality").mkdir(exist_ok=True)
        (folder / "quality" / f"{quality}.toml").write_text(BELIEVE)
    return folder


@pytest.fixture(scope="session")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path, believing: Path) -> Path:
    """Return the folder of a finished run."""
    folder = tmp_path_factory.mktemp("result") / "out"
    ended = blastline("render", film, "-o", folder, "--rules", believing)
    assert (ended.code, ended.out) == (0, ""), ended
    return folder


def files(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder, hidden ones too."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_render_writes_what_was_promised(result: Path, film: Path) -> None:
    assert sorted(files(result)) == RESULTS
    drive, original = soundfile.info(result / "drive.wav"), soundfile.info(film)
    assert (drive.samplerate, drive.frames, drive.channels) == (original.samplerate, original.frames, 1)
    assert drive.subtype == "PCM_24"
    found = read_timeline(result / "timeline.json")
    onsets_s = [event.onset_sample / RATE_HZ for event in found.events]
    assert all(min(abs(onset_s - shot_s) for onset_s in onsets_s) < 1e-3 for shot_s in SHOTS_S)
    samples, _ = soundfile.read(result / "drive.wav", dtype="int32")
    inside = np.zeros(len(samples), dtype=bool)
    for event in found.events:
        inside[event.window.start : event.window.stop] = True
    assert np.any(samples[inside])
    assert not np.any(samples[~inside])


def test_the_same_run_gives_the_same_files(tmp_path: Path, result: Path, film: Path, believing: Path) -> None:
    assert blastline("render", film, "-o", tmp_path, "--rules", believing, "--quiet").err == ""
    first, second = files(result), files(tmp_path)
    assert [name for name in first if first[name] != second[name]] == []


def test_a_result_passes_its_checks_again_and_a_late_drive_does_not(
    tmp_path: Path, result: Path, film: Path, believing: Path
) -> None:
    ended = blastline("check", result, "--audio", film, "--rules", believing, "--quiet")
    assert (ended.code, ended.out, ended.err) == (0, "", "")
    samples, _ = soundfile.read(result / "drive.wav", dtype="int32")
    soundfile.write(tmp_path / "late.wav", np.roll(samples, RATE_HZ // 20), RATE_HZ, subtype="PCM_24")
    ended = blastline("check", result, "--audio", film, "--drive", tmp_path / "late.wav", "--rules", believing)
    assert ended.code == 1
    assert "failed: " in ended.out


def test_a_film_that_is_not_found_is_told_with_where_it_was_looked_for(
    tmp_path: Path, result: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    moved = tmp_path / "a" / "b" / "timeline.json"
    moved.write_bytes((result / "timeline.json").read_bytes())
    monkeypatch.chdir(tmp_path)
    told = blastline("check", moved).complaint
    where = "not in its folder, the one above, one beside it or the current one"
    assert told.startswith(f"{moved}: source.name = 'film.wav': {where}; ")
    assert "--audio" in told


def test_a_film_in_a_folder_beside_the_result_is_found_unless_there_are_two(
    tmp_path: Path, result: Path, film: Path, believing: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("[scene]", "elsewhere"):
        (tmp_path / "a" / name).mkdir(parents=True)
    shutil.copytree(result, tmp_path / "a" / "out")
    shutil.copy(film, tmp_path / "a" / "[scene]" / "film.wav")
    monkeypatch.chdir(tmp_path)
    ended = blastline("check", Path("a", "out"), "--rules", believing, "--quiet")
    assert (ended.code, ended.err) == (0, "")
    # another film of that name: which one is meant?
    (tmp_path / "a" / "elsewhere" / "film.wav").write_bytes(b"RIFF")
    told = blastline("check", Path("a", "out"), "--rules", believing).complaint
    assert f"{Path('a', '[scene]', 'film.wav')}" in told
    assert f"{Path('a', 'elsewhere', 'film.wav')}" in told
    # alone it is refused, as any film that is not the one of the timeline
    (tmp_path / "a" / "[scene]" / "film.wav").unlink()
    assert blastline("check", Path("a", "out"), "--rules", believing).code == 2


def test_a_drive_that_is_no_sound_fails_and_one_of_two_channels_is_refused(
    tmp_path: Path, result: Path, film: Path, believing: Path
) -> None:
    samples, _ = soundfile.read(result / "drive.wav")
    broken = samples.copy()
    broken[: RATE_HZ // 10] = np.nan  # before the first shot, where it rests anyway
    soundfile.write(tmp_path / "broken.wav", broken, RATE_HZ, subtype="FLOAT")
    soundfile.write(tmp_path / "pair.wav", np.stack([samples, samples], axis=1), RATE_HZ, subtype="PCM_24")
    one, two = (
        blastline("check", result, "--audio", film, "--rules", believing, "--quiet", "--drive", tmp_path / name)
        for name in ("broken.wav", "pair.wav")
    )
    assert (one.code, one.out.splitlines()) == (
        1,
        [f"failed: {CHECKS['drive_samples']}: {RATE_HZ // 10} samples (exactly 0 samples)"],
    )
    assert "pair.wav: has 2 channels; expected a drive of 1" in two.complaint


def test_a_mix_beyond_full_scale_can_be_the_background(tmp_path: Path, film: Path, believing: Path) -> None:
    samples, _ = soundfile.read(film)
    samples[:4800] = 1.1
    soundfile.write(tmp_path / "loud.wav", samples, RATE_HZ, subtype="FLOAT")
    options = ("--background", "direct", "--rules", believing, "--no-report", "--quiet")
    blastline("render", tmp_path / "loud.wav", "-o", tmp_path / "out", *options)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    np.testing.assert_allclose(drive[:4000], 1.0, atol=2.0**-22)
    checks = {check.name: check.passed for check in read_timeline(tmp_path / "out" / "timeline.json").checks}
    assert checks["drive_peak"]
    assert checks["sound_outside_windows"]


def test_detect_writes_a_timeline_and_nothing_else(tmp_path: Path, film: Path, believing: Path) -> None:
    shown = blastline("detect", film, "--rules", believing)
    assert shown.code == 0
    found = json.loads(shown.out)
    assert len(found["events"]) >= len(SHOTS_S)
    assert f"\n{len(found['events'])} shots, " in shown.err
    file = tmp_path / "new" / "found.json"
    assert blastline("detect", film, "--rules", believing, "-o", file, "--quiet").out == ""
    assert file.read_text(encoding="utf-8") == shown.out
    assert [*tmp_path.rglob("*")] == [tmp_path / "new", file]
    assert "exists already" in blastline("detect", film, "-o", file).complaint
    assert blastline("detect", film, "--rules", believing, "-o", file, "--overwrite", "--quality", "draft").code == 0
    assert read_timeline(file).quality == "draft"


def test_an_export_prints_the_files_that_it_wrote(tmp_path: Path, result: Path) -> None:
    ended = blastline("export", result / "timeline.json", "--format", "csv,audacity", "-o", tmp_path)
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.splitlines() == [str(tmp_path / "timeline.csv"), str(tmp_path / "timeline.audacity.txt")]
    assert (tmp_path / "timeline.csv").read_bytes() == (result / "timeline.csv").read_bytes()


def test_a_result_is_exported_by_its_folder_as_by_its_timeline(tmp_path: Path, result: Path) -> None:
    formats = ("--format", "reaper,ahap")
    assert blastline("export", result, *formats, "-o", tmp_path / "folder").code == 0
    assert blastline("export", result / "timeline.json", *formats, "-o", tmp_path / "file").code == 0
    written = {each.name: each.read_bytes() for each in (tmp_path / "folder").iterdir()}
    assert written == {each.name: each.read_bytes() for each in (tmp_path / "file").iterdir()}
    (tmp_path / "empty").mkdir()
    ended = blastline("export", tmp_path / "empty", *formats, "-o", tmp_path / "none")
    assert str(tmp_path / "empty" / "timeline.json") in ended.complaint


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("text.wav", b"this is no sound\n" * 100),
        ("text.mkv", b"this is no film\n" * 100),
        ("empty.wav", b""),
        ("header.wav", b"RIFF\x24\x00\x00\x00WAVE"),
        ("none.wav", None),
        (".", None),
    ],
)
def test_what_is_no_film_is_refused(tmp_path: Path, name: str, content: bytes | None) -> None:
    film = tmp_path / name
    if content is not None:
        film.write_bytes(content)
    assert str(film) in blastline("detect", film).complaint
    assert str(film) in blastline("render", film, "-o", tmp_path / "out", "--quiet").complaint
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("--actuator none", "none: no such actuator profile; expected a .toml file or one of: crowson-t108sm"),
        (
            "--actuator unstable.toml",
            "unstable.toml: response.poles_rad_s[0] = [5.0, 0.0]: expected a negative real part",
        ),
        ("--rules none", "none: not a folder"),
        ("--rules wrong", "align.toml: correlation = 7: expected a number, 1 or less"),
        ("--rules unknown", "align.toml: korrelation: no such key"),
        ("--format json,xls", "--format 'xls': no such format; expected some of: json, schema, csv"),
        ("--format ,", "--format '': no such format"),
        ("--mix sides", "mix 'sides'"),
        ("--mix 5", "mix '5'"),
        ("--stream 3", "stream"),
        ("--level 41", "--level: 41 dB: expected -40 to 40"),
        ("--level nan", "--level: nan dB: expected -40 to 40"),
    ],
)
def test_rules_and_options_that_cannot_be_used_are_refused(
    tmp_path: Path, film: Path, options: str, complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    profile = Path(__file__).parents[1] / "rules" / "actuators" / "crowson-t108sm.toml"
    Path("unstable.toml").write_text(profile.read_text().replace("= [[-1400.0, 0.0], ", "= [[5.0, 0.0], "))
    for folder, text in (("wrong", "correlation = 7"), ("unknown", "korrelation = 0.5")):
        Path(folder).mkdir()
        Path(folder, "align.toml").write_text(text)
    assert complaint in blastline("render", film, "-o", "out", *options.split(), "--quiet").complaint
    assert not Path("out").exists()


def test_earlier_results_are_replaced_only_when_that_is_asked_for(tmp_path: Path, film: Path) -> None:
    (tmp_path / "timeline.csv").write_text("mine")
    (tmp_path / "notes.txt").write_text("mine")
    before = files(tmp_path)
    expected = f"{tmp_path / 'timeline.csv'}: exists already; give --overwrite to replace it, or another place"
    assert blastline("render", film, "-o", tmp_path).complaint == expected
    assert files(tmp_path) == before
    assert blastline("render", film, "-o", tmp_path, "--overwrite", "--no-report").code == 0
    assert sorted(files(tmp_path)) == ["drive.wav", "notes.txt", "timeline.csv", "timeline.json"]
    assert files(tmp_path)["notes.txt"] == b"mine"


def test_the_film_itself_is_no_place_for_a_timeline(tmp_path: Path, film: Path) -> None:
    own = tmp_path / "film.wav"
    own.write_bytes(film.read_bytes())
    before = files(tmp_path)
    for options in ((), ("--overwrite",)):
        complaint = blastline("detect", own, "-o", own, *options).complaint
        assert complaint == f"{own}: is the film itself; choose another folder or name for the results"
    (tmp_path / "out").mkdir()
    own.rename(tmp_path / "out" / "drive.wav")
    ended = blastline("render", tmp_path / "out" / "drive.wav", "-o", tmp_path / "out", "--overwrite")
    assert "drive.wav: is the film itself" in ended.complaint
    assert files(tmp_path) == {"out/drive.wav": before["film.wav"]}


def test_of_an_earlier_film_nothing_stays_beside_a_later_one(tmp_path: Path, result: Path, film: Path) -> None:
    for name in files(result):
        (tmp_path / name).write_bytes((result / name).read_bytes())
    formats = ("--format", "otio,haptic", "--frame-rate", "24")
    assert blastline("export", result / "timeline.json", *formats, "-o", tmp_path, "-q").code == 0
    edited = tmp_path / "timeline.audacity.txt"
    edited.write_text("1.0\t1.2\tshot-0001 1.00\n")
    (tmp_path / "notes.txt").write_text("mine")
    options = ("--format", "csv", "--no-report", "--timeline", edited, "--original", result / "timeline.json")
    assert blastline("render", film, "-o", tmp_path, *options, "-q").code == 2
    assert {"timeline.otio", "report.html", "timeline.reel-01.haptic"} <= files(tmp_path).keys()
    assert blastline("render", film, "-o", tmp_path, *options, "-q", "--overwrite").code == 0
    assert sorted(files(tmp_path)) == ["drive.wav", "notes.txt", edited.name, "timeline.csv", "timeline.json"]


@pytest.mark.parametrize("name", ["report.html", "conform.csv", "timeline.reel-02.haptic", "timeline.otio"])
@pytest.mark.parametrize("more", [(), ("--budget", "9h")], ids=["", "before measuring"])
def test_without_overwrite_no_file_of_another_run_stays_beside_a_result(
    tmp_path: Path, film: Path, name: str, more: tuple[str, ...]
) -> None:
    (tmp_path / name).write_text("of another film")
    told = blastline("render", film, "-o", tmp_path, "--no-report", *more).complaint
    assert (
        told == f"{tmp_path / name}: exists already, from another run; give --overwrite to remove it, or another place"
    )
    assert files(tmp_path) == {name: b"of another film"}


def test_a_timeline_stands_beside_all_files_of_its_own_run_at_every_moment(
    tmp_path: Path, result: Path, believing: Path
) -> None:
    other = write_film(tmp_path / "other.wav", length_s=2.5, shots_s=(1.0,))
    out = shutil.copytree(result, tmp_path / "out")
    formats = ("--format", "csv,otio,haptic,webvtt", "--frame-rate", "24")
    with moments(out) as seen:
        options = (*formats, "--quality", "draft", "--rules", believing, "--no-report", "--overwrite", "-q")
        assert blastline("render", other, "-o", out, *options).code == 0
    assert "timeline.vtt" in seen[-1]
    assert [each for each in seen if "timeline.json" in each and each not in (seen[0], seen[-1])] == []


def test_an_exported_timeline_comes_last(tmp_path: Path, result: Path) -> None:
    with moments(tmp_path / "cues") as seen:
        assert blastline("export", result, "--format", "webvtt,json,csv", "-o", tmp_path / "cues").code == 0
    assert sorted(seen[-1]) == ["timeline.csv", "timeline.json", "timeline.vtt"]
    assert ["timeline.json" in each for each in seen] == [False, False, False, True]


@pytest.mark.parametrize("same", [True, False], ids=["the same film", "another film"])
def test_an_exported_timeline_stands_beside_the_drive_of_its_film_or_none(
    tmp_path: Path, result: Path, same: bool
) -> None:
    out = shutil.copytree(result, tmp_path / "out")
    plain = json.loads((result / "timeline.json").read_text(encoding="utf-8"))
    plain["source"]["sha256"] = plain["source"]["sha256"] if same else "ab" * 32
    (tmp_path / "other.json").write_text(json.dumps(plain), encoding="utf-8")
    options = (tmp_path / "other.json", "-o", out, "--overwrite")
    assert blastline("export", *options, "--format", "webvtt").code == 0
    assert (out / "drive.wav").exists(), "without json the timeline there stays that of its drive"
    assert blastline("export", *options, "--format", "json").code == 0
    left = files(out).keys() & {"drive.wav", "report.html", "timeline.vtt"}
    assert left == ({"drive.wav", "report.html", "timeline.vtt"} if same else set())


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path, film: Path) -> None:
    (tmp_path / "file").write_text("mine")
    assert "file: is a file; expected a folder" in blastline("render", film, "-o", tmp_path / "file").complaint
    deeper = tmp_path / "file" / "deeper"
    assert "cannot write here: Not a directory" in blastline("render", film, "-o", deeper, "--quiet").complaint


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_folder_whose_name_is_no_utf_8_is_refused_at_once(tmp_path: Path, film: Path) -> None:
    out = tmp_path / os.fsdecode(b"b\xe4d")
    scene = Path(__file__).parents[1] / "fixtures" / "demo.toml"
    for words in (("render", film, "-o", out), ("synth", scene, "-o", out, "-q")):
        assert "d: the name is not valid UTF-8; choose another folder" in blastline_alone(*words).complaint
    assert [*tmp_path.iterdir()] == []


def test_a_timeline_of_a_newer_version_is_refused(tmp_path: Path, result: Path) -> None:
    plain = json.loads((result / "timeline.json").read_text(encoding="utf-8"))
    newer = tmp_path / "timeline.json"
    newer.write_text(json.dumps({**plain, "schema": "blastline.timeline/2", "version": "9.0"}))
    complaint = f"{newer}: schema = 'blastline.timeline/2', written by blastline 9.0: this version reads only"
    assert complaint in blastline("check", newer).complaint
    assert complaint in blastline("export", newer, "--format", "csv", "-o", tmp_path / "out").complaint
    assert not (tmp_path / "out").exists()


def small_files_only(most_bytes: int = 100_000) -> None:
    """Limit the size of files, which is what a full disk looks like from inside."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX limits")
@pytest.mark.parametrize("earlier", [False, True])
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path: Path, film: Path, earlier: bool) -> None:
    out = tmp_path / "out"
    if earlier:
        out.mkdir()
        (out / "timeline.csv").write_text("mine")
    before = files(tmp_path)
    ended = blastline_alone("render", film, "-o", out, "--overwrite", "--quiet", prepare=small_files_only)
    assert ended.complaint == f"{out / 'drive.wav'}: cannot write the drive: File too large"
    assert files(tmp_path) == before
    assert out.exists() == earlier


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX limits")
def test_a_full_disk_is_told_by_detect_and_synth_with_the_name_that_was_asked_for(tmp_path: Path, film: Path) -> None:
    out, scene = tmp_path / "out", tmp_path / "demo.toml"
    scene.write_text(
        'schema = 1\nrate_hz = 48000\nduration_s = 2.0\nseed = 1\n[[beds]]\nkind = "rain"\nlevel_dbfs = -40.0\n'
    )
    found = blastline_alone("detect", film, "-q", "-o", out / "f.json", prepare=partial(small_files_only, 100))
    made = blastline_alone("synth", scene, "-q", "-o", out, prepare=small_files_only)
    assert found.complaint == f"{out / 'f.json'}: cannot write: File too large"
    assert made.complaint.startswith(f"{out / 'demo.wav'}: cannot write the sound: ")
    assert not out.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX limits")
def test_a_full_disk_is_told_by_a_study_that_writes_excerpts(tmp_path: Path) -> None:
    noise = 1e-3 * np.random.default_rng(1).standard_normal(RATE_HZ)
    soundfile.write(tmp_path / "missed.wav", noise, RATE_HZ, subtype="PCM_16")
    rows = "path,source,label,sub_label,duration_s,onsets_s,notes", "missed.wav,here,gunshot,,1.0,0.5,"
    (tmp_path / "annotations.csv").write_text("\n".join(rows))
    asked = ("study", "detection", "--corpus", tmp_path, "--excerpts", tmp_path / "wrong", "-q", "-j", "1")
    ended = blastline_alone(*asked, prepare=small_files_only)
    assert ended.complaint.startswith(f"{tmp_path / 'wrong' / 'missed-0001-here_missed.wav-0.500s.wav'}: cannot write")
    # and by one that mixes films of recordings, which it removes again
    before = files(tmp_path)
    for jobs in ("1", "2"):
        mixed = ("study", "detection", "--corpus", tmp_path, "--mix", "6,30", "--films", "1", "-q", "-j", jobs)
        assert "cannot write the sound" in blastline_alone(*mixed, prepare=small_files_only).complaint
    assert files(tmp_path) == before
    assert not (tmp_path / "wrong").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX limits")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_timeline_that_standard_output_takes_in_part_is_told(tmp_path: Path, film: Path, unbuffered: str) -> None:
    whole = blastline("detect", film, "-q").out
    most_bytes = len(whole) // 2
    with (tmp_path / "timeline.json").open("wb") as file:
        ended = subprocess.run(
            [*COMMAND, "detect", film, "-q"],
            stdout=file,
            stderr=subprocess.PIPE,
            check=False,
            text=True,
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
            preexec_fn=partial(small_files_only, most_bytes),
        )
    assert (ended.returncode, ended.stderr) == (2, "blastline: input or output: File too large\n")


@pytest.mark.parametrize("lead_ms", [3.0, 8.0])
def test_a_drive_with_a_longer_lead_passes_its_checks(tmp_path: Path, film: Path, lead_ms: float) -> None:
    rules, out = tmp_path / "rules", tmp_path / "out"
    (rules / "quality").mkdir(parents=True)
    (rules / "quality" / "standard.toml").write_text(f"{BELIEVE}\n[render]\nlead_ms = {lead_ms}\n")
    ended = blastline("render", film, "-o", out, "--rules", rules, "--drive", "constrained", "--no-report", "-q")
    assert ended.code == 0, ended
    assert blastline("check", out, "--audio", film, "--rules", rules, "-q").code == 0


@pytest.mark.parametrize(
    ("seconds", "rate_hz"), [(3.0, RATE_HZ), (5.0, RATE_HZ), (4.0, 44_100), (1 / RATE_HZ, RATE_HZ)]
)
def test_another_film_is_not_checked_against(
    tmp_path: Path, result: Path, believing: Path, seconds: float, rate_hz: int
) -> None:
    other = tmp_path / "other.wav"
    soundfile.write(other, np.full(round(seconds * rate_hz), 0.1), rate_hz)
    ended = blastline("check", result, "--audio", other, "--rules", believing, "-q")
    expected = (
        f"the timeline {RATE_HZ if rate_hz != RATE_HZ else 4 * RATE_HZ}: not the film of this timeline; `blastline"
    )
    assert ended.complaint.startswith(f"{other}: has ")
    assert expected in ended.complaint


def test_another_file_than_the_film_is_told_and_checked_against(
    tmp_path: Path, result: Path, film: Path, believing: Path
) -> None:
    """A copy in another container passes; another film of the same length fails, and the drive is not to blame."""
    samples = np.asarray(soundfile.read(film, dtype="float32", always_2d=True)[0])
    copy = write_media(tmp_path / "film.mkv", [samples], codec="flac")
    other = write_film(tmp_path / "other.wav", length_s=4.0, shots_s=(1.7,))
    made_from = read_timeline(result / "timeline.json").source.sha256
    for file, code in ((copy, 0), (other, 1)):
        ended = blastline("check", result, "--audio", file, "--rules", believing)
        assert ended.code == code
        [told] = [line for line in ended.err.splitlines() if "sha256" in line]
        assert told.startswith(f"{file}: is not the file that {result / 'timeline.json'} was made from")
        assert made_from[:12] in told
    same = shutil.copy(film, tmp_path / "same.wav")
    assert "sha256" not in blastline("check", result, "--audio", same, "--rules", believing).err


@pytest.mark.parametrize(
    ("inside", "target"),
    [("scene/out", "."), ("scene/out", "timeline.json"), ("scene/out/cues", ".."), ("scene", "out")],
)
def test_the_film_in_the_folder_above_the_result_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, result: Path, film: Path, believing: Path, inside: str, target: str
) -> None:
    shutil.copytree(result, tmp_path / "scene" / "out")
    (tmp_path / "scene" / "out" / "cues").mkdir()
    shutil.copy(film, tmp_path / "scene")
    monkeypatch.chdir(tmp_path / inside)
    assert blastline("check", target, "--rules", believing, "-q").code == 0


def test_the_profile_of_ones_own_seat_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, film: Path, believing: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    built_in = Path(__file__).parents[1] / "rules" / "actuators" / "crowson-t108sm.toml"
    own = built_in.read_text(encoding="utf-8").replace('"crowson-t108sm"', '"my-seat"')
    Path("my-seat.toml").write_text(own, encoding="utf-8")
    seat = ["--actuator", "my-seat.toml"]
    assert blastline("render", film, "-o", "seat", *seat, "--rules", believing, "--no-report", "-q").code == 0
    timeline = Path("seat", "timeline.json")
    asked = f"{timeline}: was made for my-seat, which is not built in; give its file with --actuator"
    commands: tuple[list[str | Path], ...] = (
        ["check", timeline, "--audio", film, "-q"],
        ["export", timeline, "--format", "hjif", "-o", "out"],
    )
    for command in commands:
        assert blastline(*command).complaint == asked
        assert blastline(*command, *seat).code == 0


def test_a_profile_that_has_changed_since_is_not_what_the_drive_was_made_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, film: Path, believing: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    built_in = Path(__file__).parents[1] / "rules" / "actuators" / "crowson-t108sm.toml"
    changed = built_in.read_text(encoding="utf-8").replace("corner_hz = 1000.0", "corner_hz = 200.0")
    assert "200.0" in changed
    Path("own.toml").write_text(changed, encoding="utf-8")
    own = ["--actuator", "own.toml"]
    assert blastline("render", film, "-o", "out", *own, "--rules", believing, "--no-report", "-q").code == 0
    check: list[str | Path] = ["check", "out", "--audio", film, "-q"]
    export = ["export", "out/timeline.json", "--format", "hjif", "-o", "there"]
    assert "that is not the one of that name here" in blastline(*check).complaint
    assert "give its file with --actuator" in blastline(*export).complaint
    assert blastline(*check, *own).code == 0


@pytest.mark.parametrize("command", ["check", "export"])
@pytest.mark.parametrize("name", ["crowson-t108sm", "my-seat"])
def test_a_profile_that_the_drive_was_not_made_for_is_told_and_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, result: Path, film: Path, believing: Path, command: str, name: str
) -> None:
    """A changed profile of the same name is another; one that was only written otherwise is the same."""
    monkeypatch.chdir(tmp_path)
    built_in = Path(__file__).parents[1] / "rules" / "actuators" / "crowson-t108sm.toml"
    same = "# of mine\n" + built_in.read_text(encoding="utf-8")
    Path("same.toml").write_text(same, encoding="utf-8")
    other = same.replace('"crowson-t108sm"', f'"{name}"').replace("corner_hz = 1000.0", "corner_hz = 990.0")
    Path("other.toml").write_text(other, encoding="utf-8")
    words: dict[str, tuple[str | Path, ...]] = {
        "check": ("check", result, "--audio", film, "--rules", believing),
        "export": ("export", result, "--format", "hjif", "--overwrite", "-o", "out"),
    }
    made_for = read_timeline(result / "timeline.json").actuator
    assert made_for is not None
    ended = blastline(*words[command], "--actuator", "other.toml")
    [told] = [line for line in ended.err.splitlines() if "--actuator" in line]
    both = rf"crowson-t108sm \(digest {made_for.digest[:12]}\); .* {name} \(digest [0-9a-f]{{12}}\)"
    assert re.search(f"timeline.json: its drive was made for {both}", told)
    assert ended.code in (0, 1)
    assert "--actuator" not in blastline(*words[command], "--actuator", "same.toml").err
    assert "--actuator" not in blastline(*words[command]).err


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (["--drive", "nix.wav"], "nix.wav: no such file"),
        (["--drive", "pair.wav"], "pair.wav: has 2 channels; expected a drive of 1: export it as mono"),
        (["--actuator", "nix"], "nix: no such actuator profile"),
        ([], "drive.wav: no such file"),
    ],
)
def test_a_check_tells_what_is_wrong_before_it_decodes_the_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, result: Path, film: Path, wrong: list[str], told: str
) -> None:
    """The complaint is all that is said, without `-q`: no stage of the work had begun, and no file was left open."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(result, "result")
    soundfile.write("pair.wav", np.zeros((10, 2)), RATE_HZ)
    if not wrong:
        Path("result", "drive.wav").unlink()
    files_before = len(os.listdir("/dev/fd"))
    assert told in blastline("check", "result", "--audio", film, *wrong).complaint
    assert len(os.listdir("/dev/fd")) == files_before


def test_a_check_by_other_rules_says_so(result: Path, film: Path, believing: Path) -> None:
    told = "timeline.json: was made with other rules (digest "
    assert told in blastline("check", result, "--audio", film).err
    assert told not in blastline("check", result, "--audio", film, "--rules", believing).err


def test_the_sound_of_a_film_may_be_checked_in_another_file(tmp_path: Path, film: Path, believing: Path) -> None:
    samples = np.asarray(soundfile.read(film, dtype="float32", always_2d=True)[0])
    two = write_media(tmp_path / "film.mkv", [np.zeros_like(samples), samples], codec="flac")
    words = ("--rules", believing, "--no-report", "-q")
    assert blastline("render", two, "-o", tmp_path / "out", "--stream", "1", *words).code == 0
    check: list[str | Path] = ["check", tmp_path / "out", "--audio", film, "--rules", believing, "-q"]
    assert "no sound stream 1" in blastline(*check).complaint
    assert blastline(*check, "--stream", "0").code == 0


def test_an_interruption_that_was_swallowed_is_heeded_before_results_are_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python swallows what is raised while an object is destroyed."""

    class Dying:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    write, film, out = rendering.write_formats, write_film(tmp_path / "film.wav", length_s=1.0), tmp_path / "out"

    def swallowing(*arguments: Any) -> Any:
        Dying()
        return write(*arguments)

    monkeypatch.setattr("sys.unraisablehook", lambda _: None)
    monkeypatch.setattr(rendering, "write_formats", swallowing)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, and so does a run
    try:
        ended = blastline("render", film, "-o", out, "--no-report")
    finally:
        signal.signal(signal.SIGINT, before)
    assert (ended.code, out.exists()) == (130, False)


@pytest.mark.parametrize("command", ["render film.wav", "export timeline.json --format csv", "synth scene.toml"])
def test_a_folder_for_results_needs_a_name(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "'': expected the name of a folder for the results" in blastline(*command.split(), "-o", "").complaint


def test_a_folder_for_excerpts_needs_a_name_and_is_not_the_current_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = blastline("study", "detection", "--fixtures", "fixtures", "--excerpts", "")
    assert "--excerpts '': expected the name of a folder for the results" in ended.complaint


def test_a_check_without_a_name_does_not_check_the_result_in_the_current_folder(
    monkeypatch: pytest.MonkeyPatch, result: Path
) -> None:
    monkeypatch.chdir(result)
    assert "'': expected the name of a result's folder or its timeline.json" in blastline("check", "").complaint


def test_a_lock_that_was_left_is_told_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lock = tmp_path / "out" / ".blastline-moving"
    lock.mkdir(parents=True)
    os.utime(lock, (1e9, 1e9))
    monkeypatch.setattr("blastline.moving.hold", lambda _: None)  # a system without locks that end with their process
    ended = blastline("render", tmp_path / "none.wav", "-o", tmp_path / "out")
    assert ended.complaint == f"{lock}: another run is writing here; remove it where that is not so"


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("number", "at"),
    [
        (signal.SIGINT, "listening"),
        (signal.SIGINT, "rendering"),
        (signal.SIGTERM, "rendering"),
        (signal.SIGHUP, "listening"),
    ],
)
def test_a_run_that_is_interrupted_leaves_earlier_results_alone(
    tmp_path: Path, believing: Path, number: signal.Signals, at: str
) -> None:
    long_film = write_film(tmp_path / "film.wav", length_s=30.0, shots_s=tuple(np.arange(0.5, 29.0, 0.5)))
    out = tmp_path / "out"
    out.mkdir()
    (out / "timeline.json").write_text("mine")
    before = files(out)
    ended = interrupted("render", long_film, "-o", out, "--overwrite", "--rules", believing, number=number, at=at)
    assert (ended.code, ended.out) == (130, "")
    assert ended.err.splitlines()[-1] == "blastline: interrupted; nothing was written"
    assert "Traceback" not in ended.err
    assert files(out) == before
