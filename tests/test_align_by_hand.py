"""Shots set by hand where nothing begins, or too close together to compare: they are held to what is due of a drive."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.model import DriveChoice, Phase, Timeline, Window
from blastline.run import RenderOptions
from checked_films import RATE_HZ, Samples, failures, film, rendered

IN_A_ROAR = [14_400, 36_000, 57_600]
SECONDS_APART_MS = 3

Change = Callable[[Samples, Window], None]
"""What is done to a drive in a shot's window."""


def roar(path: Path, rms: float = 0.1) -> Path:
    """Write noise as loud before a shot as after it: no place in it is an attack."""
    samples = rms * np.random.default_rng(3).standard_normal(70_000)
    soundfile.write(path, np.clip(samples, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


def double_shots(path: Path) -> tuple[Path, list[int]]:
    """Write three shots, each followed by another before it can be compared."""
    onsets = [at + late * RATE_HZ // 1000 for at in IN_A_ROAR for late in (0, SECONDS_APART_MS)]
    return film(path, onsets, [0.3] * len(onsets)), onsets


def silenced(drive: Samples, window: Window) -> None:
    drive[window.start : window.stop] = 0.0


def inverted(drive: Samples, window: Window) -> None:
    drive[window.start : window.stop] *= -1.0


def moved(drive: Samples, window: Window) -> None:
    own = slice(window.start + window.fade_in_samples, window.stop - window.fade_out_samples)
    drive[own] = np.roll(drive[own], RATE_HZ // 1000)


def moved_whole(drive: Samples, window: Window) -> None:
    late = RATE_HZ // 2000
    drive[window.start : window.stop] = np.r_[np.zeros(late), drive[window.start : window.stop - late]]


def turned_over(drive: Samples, window: Window) -> None:
    drive[window.start + 24 * (RATE_HZ // 1000) : window.stop] *= -1.0


def softer(drive: Samples, window: Window) -> None:
    drive[window.start : window.stop] *= 0.89


CHANGES = pytest.mark.parametrize(
    ("change", "name"),
    [
        (silenced, "peak_as_rendered"),
        (inverted, "drive_as_rendered"),
        (moved, "drive_as_rendered"),
        (turned_over, "drive_as_rendered"),
        (softer, "peak_as_rendered"),
    ],
)


def is_compared(made: Timeline) -> bool:
    return any(check.limit is not None for check in made.checks if check.name.endswith("_correlation"))


def wrong_with(path: Path, made: Timeline, change: Change) -> set[str]:
    """Return what fails where the second window's drive is changed."""
    window = sorted({event.window.start: event.window for event in made.events}.items())[1][1]
    inside = {event.id for event in made.events if event.window == window}
    drive, _ = soundfile.read(path.parent / "out" / "drive.wav")
    change(drive, window)
    soundfile.write(path.parent / "wrong.wav", drive, RATE_HZ, subtype="PCM_24")
    failed = failures(run.check(path.parent / "out", audio=path, drive=path.parent / "wrong.wav"))
    assert {event for _, event, _ in failed} <= inside
    return {name for name, _, _ in failed}


def made_right(path: Path, onsets: Sequence[int], drive: DriveChoice, phase: Phase) -> Timeline:
    made = rendered(path, onsets, RenderOptions(report=False, drive=drive, phase=phase))
    assert failures(made) == []
    assert not is_compared(made)
    return made


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@CHANGES
def test_a_shot_where_nothing_begins_is_held_to_its_drive(
    tmp_path: Path, drive: DriveChoice, phase: Phase, change: Change, name: str
) -> None:
    path = roar(tmp_path / "film.wav")
    assert name in wrong_with(path, made_right(path, IN_A_ROAR, drive, phase), change)


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
def test_a_soft_shot_where_nothing_begins_is_held_to_its_place(tmp_path: Path, drive: DriveChoice) -> None:
    """Within its limit a drive is as like the sound half a millisecond late, and no fade tells so soft a one."""
    path = roar(tmp_path / "film.wav", 0.001)
    assert "drive_as_rendered" in wrong_with(path, made_right(path, IN_A_ROAR, drive, "causal"), moved_whole)


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
def test_shots_that_cannot_be_compared_tell_nothing_of_the_whole_drive(tmp_path: Path, drive: DriveChoice) -> None:
    """Most of a film's shots are moved by hand within their windows: where the drive lies the one other tells."""
    path = roar(tmp_path / "film.wav", 0.01)
    samples, _ = soundfile.read(path)
    shot, _ = soundfile.read(film(tmp_path / "shot.wav", IN_A_ROAR[1:2], [0.9]))
    soundfile.write(path, samples + shot, RATE_HZ, subtype="PCM_24")
    made = rendered(path, IN_A_ROAR, RenderOptions(report=False, drive=drive))
    assert failures(made) == []
    written, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    others = made.events[::2]
    for event in others:
        moved(written, event.window)
    soundfile.write(tmp_path / "wrong.wav", written, RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav")
    assert is_compared(checked)
    assert {event for _, event, _ in failures(checked)} == {event.id for event in others}


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@CHANGES
def test_two_shots_that_are_too_close_to_compare_are_held_to_their_drive(
    tmp_path: Path, drive: DriveChoice, change: Change, name: str
) -> None:
    path, onsets = double_shots(tmp_path / "film.wav")
    assert name in wrong_with(path, made_right(path, onsets, drive, "causal"), change)


def test_a_shot_on_the_last_frame_that_does_not_move_fails(tmp_path: Path) -> None:
    samples = 1e-3 * np.random.default_rng(4).standard_normal(20_000)
    samples[-1] = 0.5
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_24")
    made_right(path, [19_999], "direct", "causal")
    soundfile.write(tmp_path / "rest.wav", np.zeros(20_000), RATE_HZ, subtype="PCM_24")
    failed = failures(run.check(tmp_path / "out", audio=path, drive=tmp_path / "rest.wav"))
    assert "peak_as_rendered" in {name for name, _, _ in failed}
