"""Soft shots beside louder ones and beside the film's own sound: held to their place and their gain."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from align_films import make_film
from blastline import run
from blastline.align.hearing import _relative_gain
from blastline.align.shots import parts_of
from blastline.model import Background, DriveChoice, Phase, Span, Timeline, Window
from blastline.render.heard import _gains
from blastline.render.windows import PlannedWindow
from blastline.ruleset import load_rules
from blastline.run import RenderOptions
from blastline.units import gain_from_db, samples_from_ms
from checked_films import RATE_HZ, Samples, failures, film, rendered, seat, with_booms

BEFORE_A_LOUDER = [14_400, 17_600, 24_000]
"""A direct drive is compared without delay, in a band that spreads what comes over what was before it."""


WITHIN_AND_LIMITED = pytest.mark.parametrize(
    "peaks", [[0.03, 0.03, 0.03], [0.01, 0.15, 0.01]], ids=["within the limit", "limited"]
)


@pytest.mark.parametrize("phase", ["causal", "zero"])
@WITHIN_AND_LIMITED
@pytest.mark.parametrize("gains_db", [[0.0, 24.0, 0.0], [-24.0, 0.0, -24.0]])
def test_a_direct_shot_before_one_that_is_asked_to_be_louder_passes(
    tmp_path: Path, phase: Phase, peaks: list[float], gains_db: list[float]
) -> None:
    path = film(tmp_path / "film.wav", BEFORE_A_LOUDER, peaks, decay_s=0.03)
    options = RenderOptions(report=False, drive="direct", phase=phase)
    assert failures(rendered(path, BEFORE_A_LOUDER, options, gains_db)) == []


def test_a_direct_shot_before_two_that_differ_passes(tmp_path: Path) -> None:
    """The band spreads the shot after the next over it as well, by what that was asked to be, not by the next one's."""
    onsets = [10_000, 15_000, 15_500]
    path = film(tmp_path / "film.wav", onsets, [0.07, 1.4, 1.4], decay_s=0.3)
    made = rendered(path, onsets, RenderOptions(report=False, drive="direct", quality="draft"), [-12.0, 4.0, -20.0])
    assert failures(made) == []
    assert len({event.window for event in made.events}) == 1


@given(
    st.lists(st.tuples(st.integers(0, 2_000), st.sampled_from([-20.0, -6.0, 0.0, 4.0])), min_size=1, max_size=8),
    st.integers(-500, 2_000),
    st.integers(1, 3_000),
)
def test_a_shot_is_held_to_the_gains_that_its_window_is_rendered_with(
    shots: list[tuple[int, float]], start: int, length: int
) -> None:
    window = Window(0, 2_500, 0, 100)
    gains = tuple(sorted(dict(shots).items()))
    rules = load_rules("standard").tier.render
    filters: Any = SimpleNamespace(rate_hz=RATE_HZ)
    made_with = _gains(PlannedWindow(window, tuple(range(len(gains))), gains), filters, rules)
    made = make_film(onsets_s=tuple(onset / RATE_HZ for onset, _ in gains), peaks=(0.1,) * len(gains), seconds=0.1)
    events = [
        msgspec.structs.replace(event, window=window, gain_db=gain_db)
        for event, (_, gain_db) in zip(made.timeline.events, gains, strict=True)
    ]
    shared: Any = SimpleNamespace(lead_ms=rules.lead_ms, samples=lambda ms: samples_from_ms(ms, RATE_HZ))
    span = Span(start, start + length)
    held_to = made_with[np.clip(np.arange(span.start, span.stop), 0, len(made_with) - 1)]
    for event, part in zip(events, parts_of(events, lead=shared.samples(rules.lead_ms)), strict=True):
        relative = _relative_gain(shared, event, part, span)
        np.testing.assert_allclose(relative * gain_from_db(event.gain_db), held_to, rtol=1e-9)


@pytest.mark.parametrize("phase", ["causal", "zero"])
@WITHIN_AND_LIMITED
def test_a_direct_shot_before_a_louder_one_is_held_to_its_place_and_its_gain(
    tmp_path: Path, phase: Phase, peaks: list[float]
) -> None:
    path = film(tmp_path / "film.wav", BEFORE_A_LOUDER, peaks, decay_s=0.03)
    options = RenderOptions(report=False, drive="direct", phase=phase)
    made = rendered(path, BEFORE_A_LOUDER, options, [0.0, 24.0, 0.0])
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    own = slice(made.events[0].window.start, BEFORE_A_LOUDER[1] - RATE_HZ // 1000)

    def wrong_with(samples: Samples) -> set[tuple[str, str | None]]:
        soundfile.write(tmp_path / "other.wav", samples, RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out" / "timeline.json", audio=path, drive=tmp_path / "other.wav")
        return {(name, event) for name, event, _ in failures(checked)}

    moved, softer = drive.copy(), drive.copy()
    moved[own] = np.roll(drive[own], -3)
    softer[own] *= 0.8
    assert ("drive_shift", None) in wrong_with(np.roll(drive, 1))
    wrong = wrong_with(moved)
    assert ("lag_as_rendered", "shot-0001") in wrong or ("drive_as_rendered", "shot-0001") in wrong
    assert ("level_as_rendered", "shot-0001") in wrong_with(softer)


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("gap_ms", [60, 120])
def test_a_filtered_shot_after_one_that_is_asked_to_be_louder_passes_where_it_is_and_not_beside(
    tmp_path: Path, phase: Phase, gap_ms: int
) -> None:
    """What the louder one leaves ringing has no say in how late the softer one is meant to be."""
    onsets = [14_400 + number * gap_ms * RATE_HZ // 1000 for number in range(7)]
    path = film(tmp_path / "film.wav", onsets, [0.1] * 7, decay_s=0.03)
    options = RenderOptions(report=False, drive="filter", phase=phase)
    made = rendered(path, onsets, options, [0.0, 24.0] * 3 + [0.0])
    assert failures(made) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    own = slice(onsets[2] - RATE_HZ // 1000, onsets[3] - RATE_HZ // 1000)
    drive[own] = np.roll(drive[own], 5)
    soundfile.write(tmp_path / "moved.wav", drive, RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out" / "timeline.json", audio=path, drive=tmp_path / "moved.wav")
    assert ("lag_as_rendered", "shot-0003") in {(name, event) for name, event, _ in failures(checked)}


def film_in_noise(path: Path, onsets: Sequence[int]) -> Path:
    """Write blasts over noise that is heard and felt as well."""
    samples, _ = soundfile.read(film(path, onsets, [0.5] * len(onsets)))
    noise = 0.03 * np.random.default_rng(2).standard_normal(samples.size)
    soundfile.write(path, np.clip(samples + noise, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


def second_window(
    made: Timeline, path: Path, actuator: str | None = None
) -> tuple[Samples, Callable[[Samples], set[str]]]:
    """Return the drive of the second shot between its fades, and what of that shot fails with another one there."""
    samples, _ = soundfile.read(path.parent / "out" / "drive.wav")
    window = made.events[1].window
    own = slice(window.start + window.fade_in_samples, window.stop - window.fade_out_samples)

    def wrong_with(within: Samples) -> set[str]:
        other = samples.copy()
        other[own] = within
        soundfile.write(path.parent / "other.wav", other, RATE_HZ, subtype="PCM_24")
        checked = run.check(path.parent / "out", audio=path, drive=path.parent / "other.wav", actuator=actuator)
        return {name for name, event, _ in failures(checked) if event == "shot-0002"}

    return samples[own].copy(), wrong_with


IN_NOISE = [14_400, 36_000, 57_600]


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("gain_db", [-29.0, -60.0])
@pytest.mark.parametrize("before", [None, 0, 48])
def test_a_soft_shot_beside_the_films_own_sound_passes_wherever_its_window_opens(
    tmp_path: Path, drive: DriveChoice, phase: Phase, gain_db: float, before: int | None
) -> None:
    path = film_in_noise(tmp_path / "film.wav", IN_NOISE)
    rows = [f"{onset},{gain_db},{'' if before is None else onset - before}" for onset in IN_NOISE]
    path.with_suffix(".csv").write_text("\n".join(["onset_sample,gain_db,window_start_sample", *rows]))
    options = RenderOptions(report=False, drive=drive, phase=phase, background="direct")
    made = run.render(path, tmp_path / "out", replace(options, timeline=path.with_suffix(".csv")))
    assert failures(made) == []


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_soft_shot_beside_the_films_own_sound_is_held_to_its_place_and_its_gain(
    tmp_path: Path, drive: DriveChoice, phase: Phase
) -> None:
    path = film_in_noise(tmp_path / "film.wav", IN_NOISE)
    options = RenderOptions(report=False, drive=drive, phase=phase, background="direct")
    made = rendered(path, IN_NOISE, options, [-20.0] * 3)
    own, wrong_with = second_window(made, path)
    moved, softer = wrong_with(np.roll(own, 12)), wrong_with(0.7 * own)
    assert moved & {"lag_as_rendered", "drive_as_rendered"}
    assert "level_as_rendered" in softer


@pytest.mark.parametrize("drive", ["filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("background", ["mute", "direct"])
def test_a_softer_shot_on_a_seat_that_rings_with_the_window_before_is_held_to_its_own_drive(
    tmp_path: Path, drive: DriveChoice, phase: Phase, background: Background
) -> None:
    onsets = [14_400, 26_400, 38_400]
    path = with_booms(film(tmp_path / "film.wav", onsets, [0.6, 0.9, 0.3], decay_s=0.03), onsets, 30.0, peak=0.5)
    actuator = seat(tmp_path / "seat.toml", 15.0, 6.0)
    gains_db = zip(onsets, [0.0, -23.0, -20.0], strict=True)
    rows = [f"{onset},{gain_db},{onset + 8_000}" for onset, gain_db in gains_db]
    path.with_suffix(".csv").write_text("\n".join(["onset_sample,gain_db,window_stop_sample", *rows]))
    options = RenderOptions(report=False, drive=drive, phase=phase, background=background, actuator=actuator)
    made = run.render(path, tmp_path / "out", replace(options, timeline=path.with_suffix(".csv"), level_db=-6.0))
    assert failures(made) == []
    own, wrong_with = second_window(made, path, actuator)
    for wrong in (0.5 * own, -own, np.roll(own, 240)):
        assert wrong_with(wrong)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "late.wav", np.roll(drive, 240), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "late.wav", actuator=actuator)
    assert [check.passed for check in checked.checks if check.name == "drive_shift"] == [False]
