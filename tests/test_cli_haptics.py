"""Haptic formats from the command line: made with a render or from its files later, and refused in one line."""

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile
import wavinfo

from blastline.export import read_timeline
from blastline.model import Clip, Timeline, encode
from blastline.soundtrack import write_drive
from commands import BELIEVE, blastline, write_film
from haptic_films import RATE_HZ, Samples, drive_of, event, film
from haptic_rules import ahap_played, haptic_played, hjif_played

FORMATS = "ahap,haptic,hjif"
FILES = [
    "timeline.continuous.ahap",
    "timeline.hjif",
    "timeline.reel-01.haptic",
    "timeline.reels.csv",
    "timeline.transients.ahap",
]
SHOTS_S = (1.0, 2.5)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that was asked for every haptic format."""
    folder = tmp_path_factory.mktemp("result")
    quality = folder / "rules" / "quality"
    quality.mkdir(parents=True)
    (quality / "draft.toml").write_text(BELIEVE)
    scene = write_film(folder / "film.wav", length_s=4.0, shots_s=SHOTS_S)
    wanted = ["--format", f"json,{FORMATS}", "--quality", "draft", "--no-report"]
    ended = blastline("render", scene, "-o", folder / "out", "--rules", folder / "rules", *wanted)
    assert ended.code == 0, ended
    for name in FORMATS.split(","):
        assert f"{name}: " in ended.err
    return folder / "out"


def saved(folder: Path, whole: Timeline, drive: Samples, rate_hz: int = RATE_HZ) -> Path:
    """Write a timeline with its drive beside it, and return the timeline's file."""
    folder.mkdir(exist_ok=True)
    write_drive(folder / "drive.wav", [Clip(drive[:, None], rate_hz)], rate_hz=rate_hz, frames=len(drive))
    (folder / "timeline.json").write_bytes(encode(whole))
    return folder / "timeline.json"


WHOLE = film([event(RATE_HZ), event(2 * RATE_HZ)], 3 * RATE_HZ)


@pytest.fixture
def timeline(tmp_path: Path) -> Path:
    return saved(tmp_path / "in", WHOLE, drive_of(WHOLE))


def export(timeline: Path, folder: Path, *options: str | Path, formats: str = FORMATS) -> list[str]:
    ended = blastline("export", timeline, "--format", formats, "-o", folder, *options)
    assert ended.code == 0, ended
    return ended.err.splitlines()


def test_a_render_writes_them_and_an_export_writes_the_same(tmp_path: Path, result: Path) -> None:
    assert sorted(path.name for path in result.iterdir()) == sorted([*FILES, "drive.wav", "timeline.json"])
    lines = export(result / "timeline.json", tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == FILES
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (result / name).read_bytes()
    assert [line.split(":")[0] for line in lines] == FORMATS.split(",")
    assert all("times within" in line and "amplitudes within" in line for line in lines)
    assert export(result / "timeline.json", tmp_path / "quiet", "--quiet") == []


def test_every_shot_of_a_render_is_in_every_file_at_its_time(result: Path) -> None:
    onsets_s = np.array([each.onset_sample / RATE_HZ for each in read_timeline(result / "timeline.json").events])
    assert len(onsets_s) >= 2
    continuous, transients = result / "timeline.continuous.ahap", result / "timeline.transients.ahap"
    [backrest, _] = hjif_played(result / "timeline.hjif")
    reel = haptic_played(result / "timeline.reel-01.haptic")
    for found, limit_ms in ((ahap_played(continuous, transients), 0.001), (reel, 0.1), (backrest, 0.5)):
        times_s = np.array([time_s for time_s, _ in found.pulses])
        assert np.max(np.min(np.abs(times_s[None, :] - onsets_s[:, None]), axis=1)) <= limit_ms / 1000.0


def test_every_shot_of_a_render_is_a_cue_of_the_drive(result: Path) -> None:
    info = wavinfo.WavInfoReader(str(result / "drive.wav"))
    events = read_timeline(result / "timeline.json").events
    assert info.cues is not None
    assert [(cue.position, info.cues.label_and_note(cue.name)[0]) for cue in info.cues.cues] == [
        (each.onset_sample, each.id) for each in events
    ]
    nexts = [*(each.onset_sample for each in events[1:]), math.inf]
    for cue, each, after in zip(info.cues.cues, events, nexts, strict=True):
        assert info.cues.range(cue.name) == min(each.window.stop, after) - each.onset_sample


def test_a_drive_elsewhere_is_given(tmp_path: Path, timeline: Path) -> None:
    elsewhere = (timeline.parent / "drive.wav").rename(tmp_path / "mine.wav")
    complaint = f"{timeline.parent / 'drive.wav'}: no such file; haptic formats are made from the drive: give it with"
    assert complaint in blastline("export", timeline, "--format", "hjif", "-o", tmp_path / "out").complaint
    assert not (tmp_path / "out").exists()
    export(timeline, tmp_path / "out", "--drive", elsewhere)
    assert export(timeline, tmp_path / "csv", formats="csv,audacity") == []
    more = ("--drive", elsewhere, "--actuator", "crowson-t108sm")
    told = "not used: --drive and --actuator; only ahap, haptic, hjif are made from the drive"
    assert export(timeline, tmp_path / "more", *more, formats="csv,audacity") == [told]
    assert not [line for line in export(timeline, tmp_path / "both", *more, formats="csv,hjif") if "not used" in line]


@pytest.mark.parametrize(
    ("frames", "rate_hz", "complaint"),
    [
        (3 * RATE_HZ - 1, RATE_HZ, "has 143999 samples, the timeline 144000: not the drive of this timeline"),
        (3 * RATE_HZ, 44_100, "has 44100 samples a second, the timeline 48000: not the drive of this timeline"),
    ],
)
def test_a_drive_of_another_length_or_rate_is_refused(
    tmp_path: Path, timeline: Path, frames: int, rate_hz: int, complaint: str
) -> None:
    soundfile.write(timeline.parent / "drive.wav", np.full(frames, 0.5), rate_hz, subtype="PCM_24")
    said = blastline("export", timeline, "--format", "ahap", "-o", tmp_path / "out").complaint
    assert said == f"{timeline.parent / 'drive.wav'}: {complaint}"
    assert not (tmp_path / "out").exists()


def test_a_drive_that_never_moves_is_refused_and_one_that_misses_a_shot_is_told(tmp_path: Path) -> None:
    silent = saved(tmp_path / "silent", WHOLE, np.zeros(3 * RATE_HZ))
    said = blastline("export", silent, "--format", "haptic", "-o", tmp_path / "out").complaint
    assert "drive.wav: is at rest in the windows of all 2 shots: not the drive of this timeline" in said
    half = drive_of(WHOLE)
    half[2 * RATE_HZ :] = 0.0
    lines = export(saved(tmp_path / "half", WHOLE, half), tmp_path / "out", formats="hjif")
    assert lines[0] == f"the drive is at rest at 1 of the shots, which get no pulse: shot-{2 * RATE_HZ}"


def test_a_drive_with_samples_that_are_no_numbers_is_refused(tmp_path: Path, timeline: Path) -> None:
    file = timeline.parent / "drive.wav"
    drive, _ = soundfile.read(file)
    drive[[RATE_HZ + 100, 2 * RATE_HZ]] = np.nan, np.inf
    soundfile.write(file, drive, RATE_HZ, subtype="FLOAT")
    said = blastline("export", timeline, "--format", "hjif", "-o", tmp_path / "out").complaint
    assert said == f"{file}: 2 of its samples are no numbers; expected a drive"
    assert not (tmp_path / "out").exists()


def test_what_exceeds_the_limit_is_told_and_written_as_the_limit(tmp_path: Path, timeline: Path) -> None:
    file = timeline.parent / "drive.wav"
    drive, _ = soundfile.read(file)
    first = WHOLE.events[0].onset_sample
    drive[first : first + 480] = 1.0
    soundfile.write(file, drive, RATE_HZ, subtype="FLOAT")
    assert not [line for line in export(timeline, tmp_path / "at", formats="ahap") if "limit, first" in line]
    drive[first : first + 480] = 1.26
    soundfile.write(file, drive, RATE_HZ, subtype="FLOAT")
    told, *_ = export(timeline, tmp_path / "over", formats="ahap")
    assert told == (
        f"{file}: reaches 1.26 times the actuator's limit, first at 01:00:01:00; what is over the limit is written as "
        "the limit"
    )
    for name in ("timeline.continuous.ahap", "timeline.transients.ahap"):
        assert (tmp_path / "over" / name).read_bytes() == (tmp_path / "at" / name).read_bytes()


def test_a_timeline_without_a_drive_needs_one_and_its_actuator(tmp_path: Path, timeline: Path) -> None:
    detected = msgspec.structs.replace(WHOLE, actuator=None)
    alone = tmp_path / "alone.json"
    alone.write_bytes(encode(detected))
    said = blastline("export", alone, "--format", "hjif", "-o", tmp_path / "out").complaint
    assert said.startswith(f"{alone}: has no drive and names no actuator; haptic formats are made from a drive")
    drive = timeline.parent / "drive.wav"
    export(alone, tmp_path / "out", "--drive", drive, "--actuator", "crowson-t108sm")
    export(timeline, tmp_path / "same")
    assert (tmp_path / "out" / "timeline.hjif").read_bytes() == (tmp_path / "same" / "timeline.hjif").read_bytes()


def test_an_unknown_actuator_is_refused(tmp_path: Path, timeline: Path) -> None:
    said = blastline("export", timeline, "--format", "hjif", "--actuator", "none", "-o", tmp_path / "out").complaint
    assert said.startswith("none: no such actuator profile; expected a .toml file or one of: crowson-t108sm")


def test_reels_of_a_longer_film_do_not_survive_unnoticed(tmp_path: Path, timeline: Path) -> None:
    out = tmp_path / "out"
    export(timeline, out)
    stale = out / "timeline.reel-02.haptic"
    (out / "timeline.reel-01.haptic").rename(stale)
    said = blastline("export", timeline, "--format", "haptic", "-o", out).complaint
    assert "exists already; give --overwrite" in said
    for name in FILES:
        (out / name).unlink(missing_ok=True)
    said = blastline("export", timeline, "--format", "haptic", "-o", out).complaint
    assert said == f"{stale}: exists already; give --overwrite to replace it, or another place"
    export(timeline, out, "--overwrite")
    assert sorted(path.name for path in out.iterdir()) == FILES


def test_ones_own_rules_for_breakpoints(tmp_path: Path, timeline: Path) -> None:
    rules = tmp_path / "rules"
    rules.mkdir()
    (rules / "haptics.toml").write_text("reel_s = 10.0\namplitude_error = 0.1\n")
    export(timeline, tmp_path / "fine")
    export(timeline, tmp_path / "coarse", "--rules", rules)
    fine, coarse = (
        json.loads((tmp_path / name / "timeline.hjif").read_bytes())["perceptions"][0]["channels"][0]["bands"][1]
        for name in ("fine", "coarse")
    )
    assert len(coarse["effects"][0]["keyframes"]) < len(fine["effects"][0]["keyframes"])
    (rules / "haptics.toml").write_text("reel_s = 1024.0\n")
    said = blastline("export", timeline, "--format", "haptic", "--rules", rules, "-o", tmp_path / "out").complaint
    assert said == f"{rules / 'haptics.toml'}: reel_s = 1024.0: expected a number, 960 or less"
