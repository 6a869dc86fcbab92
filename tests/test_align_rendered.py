"""What `render` makes of a timeline passes its checks; what somebody else did to the drive fails, without a crash."""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray
from scipy.signal import resample_poly

from blastline import dsp, run
from blastline.errors import RuleError
from blastline.model import DriveChoice, Phase, Quality, Timeline
from blastline.ruleset import load_actuator, rules_path
from blastline.run import RenderOptions

Samples = NDArray[np.float64]
RATE_HZ = 48_000


def film(path: Path, onsets: Sequence[int], peaks: Sequence[float], *, decay_s: float = 0.05, seed: int = 1) -> Path:
    """Write blasts with noisy decays, as 24-bit sound."""
    rng = np.random.default_rng(seed)
    samples = 1e-5 * rng.standard_normal(70_000)
    for onset, peak in zip(onsets, peaks, strict=True):
        t = np.arange(min(samples.size - onset, round(0.4 * RATE_HZ))) / RATE_HZ
        blast = (1.0 - t / 0.002) * np.exp(-t / 0.002)
        samples[onset : onset + t.size] += peak * (blast + 0.2 * rng.standard_normal(t.size) * np.exp(-t / decay_s))
    soundfile.write(path, np.clip(samples, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


def rendered(path: Path, onsets: Sequence[int], options: RenderOptions, gains_db: Sequence[float] = ()) -> Timeline:
    """Render shots at given onsets, each as much softer or louder as asked, beside their film."""
    edited = path.with_suffix(".csv")
    rows = zip(onsets, gains_db or [0.0] * len(onsets), strict=True)
    edited.write_text("onset_sample,gain_db\n" + "".join(f"{onset},{gain}\n" for onset, gain in rows))
    return run.render(path, path.parent / "out", replace(options, timeline=edited))


def failures(made: Timeline) -> list[tuple[str, str | None, float | None]]:
    return [(check.name, check.event, check.measured) for check in made.checks if not check.passed]


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("gap_ms", [50, 100])
@pytest.mark.parametrize("peak", [0.01, 0.03])
def test_a_faint_shot_before_a_loud_one_passes(tmp_path: Path, phase: Phase, gap_ms: int, peak: float) -> None:
    onsets = [14_400, 14_400 + gap_ms * 48, 48_000]
    path = film(tmp_path / "film.wav", onsets, [peak, 1.0, 0.5])
    assert failures(rendered(path, onsets, RenderOptions(report=False, phase=phase))) == []


@pytest.mark.parametrize("gain_db", [-12.0, -20.0, -28.0])
def test_a_shot_that_is_asked_to_be_softer_than_the_one_before_passes(tmp_path: Path, gain_db: float) -> None:
    onsets = [14_400, 19_200, 24_000]
    path = film(tmp_path / "film.wav", onsets, [0.03] * 3, decay_s=0.03)
    assert failures(rendered(path, onsets, RenderOptions(report=False), [0.0, 0.0, gain_db])) == []


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_direct_drive_that_is_raised_into_the_limit_passes(tmp_path: Path, phase: Phase, seed: int) -> None:
    onsets = [14_400, 26_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.6] * 3, seed=seed)
    options = RenderOptions(report=False, drive="direct", level_db=12.0, phase=phase)
    assert failures(rendered(path, onsets, options)) == []


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
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    window = made.events[1].window
    own = slice(window.start + window.fade_in_samples, window.stop - window.fade_out_samples)

    def wrong_with(within: Samples) -> set[str]:
        other = samples.copy()
        other[own] = within
        soundfile.write(tmp_path / "other.wav", other, RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out" / "timeline.json", audio=path, drive=tmp_path / "other.wav")
        return {name for name, event, _ in failures(checked) if event == "shot-0002"}

    moved, softer = wrong_with(np.roll(samples[own], 12)), wrong_with(0.7 * samples[own])
    assert moved & {"lag_as_rendered", "drive_as_rendered"}
    assert "level_as_rendered" in softer


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("share", [0.9, 0.5])
def test_a_clipped_drive_fails_by_as_much_as_its_peak_lacks(tmp_path: Path, drive: DriveChoice, share: float) -> None:
    onsets = [14_400, 26_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.5, 0.3, 0.1])
    made = rendered(path, onsets, RenderOptions(report=False, drive=drive))
    assert failures(made) == []
    out = tmp_path / "out"
    samples, _ = soundfile.read(out / "drive.wav")
    peaks = [event.drive.peak for event in made.events if event.drive]
    limit = share * max(peaks)
    soundfile.write(tmp_path / "clipped.wav", np.clip(samples, -limit, limit), RATE_HZ, subtype="PCM_24")
    checked = run.check(out / "timeline.json", audio=path, drive=tmp_path / "clipped.wav")
    measured = {check.event: check for check in checked.checks if check.name == "peak_as_rendered"}
    for event, peak in zip(made.events, peaks, strict=True):
        assert measured[event.id].measured == pytest.approx(20.0 * np.log10(min(1.0, limit / peak)), abs=0.01)
        assert measured[event.id].passed == (limit >= 0.944 * peak)


def ended(drive: Samples, since: int) -> None:
    drive[since:] = 0.0


def turned_over(drive: Samples, since: int) -> None:
    drive[since:] *= -1.0


def with_a_hole(drive: Samples, since: int) -> None:
    drive[since : since + 240] = 0.0


def noisy(drive: Samples, since: int) -> None:
    drive[since:] += 0.05 * np.random.default_rng(5).standard_normal(drive[since:].size)


def in_8_bits(drive: Samples, since: int) -> None:
    drive[since:] = np.round(drive[since:] * 128) / 128


@pytest.mark.parametrize(
    ("change", "drive", "since_ms"),
    [
        *((change, drive, 250) for change in (ended, turned_over) for drive in ("direct", "filter", "constrained")),
        (ended, "direct", 100),
        *((with_a_hole, drive, 30) for drive in ("direct", "filter", "constrained")),
        *((noisy, drive, 30) for drive in ("direct", "filter", "constrained")),
        *((in_8_bits, drive, 30) for drive in ("direct", "filter")),
    ],
)
def test_what_is_wrong_with_a_drive_after_its_attack_fails_by_name(
    tmp_path: Path, change: Callable[[Samples, int], None], drive: DriveChoice, since_ms: int
) -> None:
    path = film(tmp_path / "film.wav", [14_400], [0.9], decay_s=0.15)
    made = rendered(path, [14_400], RenderOptions(report=False, drive=drive))
    assert failures(made) == []
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    window = made.events[0].window
    change(samples[: window.stop - window.fade_out_samples], 14_400 + 48 * since_ms)
    soundfile.write(tmp_path / "wrong.wav", np.clip(samples, -1.0, 1.0), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav")
    names = {name for name, _, _ in failures(checked)}
    assert "drive_as_rendered" in names
    assert names.isdisjoint({"drive_onset", "felt_onset", "drive_shift", "lag_as_rendered", "pre_echo"})


@pytest.mark.parametrize(("frequency_hz", "amplitude"), [(3000.0, 0.2), (8000.0, 0.5)])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_a_tone_above_the_band_fails_by_name(
    tmp_path: Path, frequency_hz: float, amplitude: float, phase: Phase, quality: Quality
) -> None:
    """It is hardly felt, and a drive at its limit has as much energy there by itself."""
    path = film(tmp_path / "film.wav", [14_400], [0.9])
    made = rendered(path, [14_400], RenderOptions(report=False, drive="constrained", phase=phase, quality=quality))
    assert failures(made) == []
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    window = made.events[0].window
    inside = np.arange(window.start + window.fade_in_samples, window.stop - window.fade_out_samples)
    samples[inside] += amplitude * np.sin(2 * np.pi * frequency_hz * inside / RATE_HZ)
    soundfile.write(tmp_path / "wrong.wav", np.clip(samples, -1.0, 1.0), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav")
    assert "drive_above_band" in {name for name, _, _ in failures(checked)}


@pytest.mark.parametrize("rate_hz", [96_000, 192_000])
def test_a_coarse_drive_passes_at_any_rate(tmp_path: Path, rate_hz: int) -> None:
    onsets = [round(at * rate_hz / RATE_HZ) for at in (14_400, 26_400, 40_000)]
    path = film(tmp_path / "film.wav", [14_400, 26_400, 40_000], [0.9] * 3)
    samples, _ = soundfile.read(path)
    soundfile.write(path, resample_poly(0.9 * samples, rate_hz // RATE_HZ, 1), rate_hz, subtype="PCM_24")
    options = RenderOptions(report=False, quality="draft", drive="constrained", phase="zero")
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize("level_db", [30.0, 36.0])
def test_a_burst_far_beyond_the_limit_is_as_calm_before_its_shots_in_draft(tmp_path: Path, level_db: float) -> None:
    """There a drive is at its limit most of the time, and a coarse one turns over at the wrong moments."""
    onsets = [14_400 + number * 60 * 48 for number in range(6)]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.8, 0.9, 0.7, 0.9, 0.8])
    options = RenderOptions(report=False, quality="draft", drive="constrained", level_db=level_db)
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize(("corner_hz", "order"), [(1000, 3), (1000, 4), (700, 3), (1000, 8), (300, 4)])
def test_a_drive_may_be_as_late_as_its_band_has_to_be_and_no_later(tmp_path: Path, corner_hz: int, order: int) -> None:
    """A low-pass of 700 Hz delays by .48 ms, and the actuator's limit bends that beyond the .5 ms of the rules."""
    shipped = rules_path("actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(shipped.replace("1000.0\norder = 3", f"{corner_hz}.0\norder = {order}"), encoding="utf-8")
    onsets = [14_400, 26_400, 40_000, 52_000]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.3, 0.1, 0.6])
    options = RenderOptions(report=False, actuator=str(seat), quality="draft", level_db=18.0)
    assert failures(rendered(path, onsets, options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    bend = 0.1 * max(1.0, 1000.0 / corner_hz) * RATE_HZ / 1000
    for by in (round(2.2 * bend), -round(2.2 * bend)):
        soundfile.write(tmp_path / "wrong.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav", actuator=str(seat))
        names = {name for name, _, _ in failures(checked)}
        assert {"drive_shift", "felt_lag"} <= names if by > 0 else "drive_shift" in names


RINGING_SEAT = """
schema = 1
name = "rings"
source = "a seat that rings at 60 Hz, behind the skin's thresholds"
[response]
source = "a fit"
gain = 4222.0
zeros_rad_s = [[-46.3, 0.0], [-85.5, 93.9], [-85.5, -93.9], [-140.2, 0.0], [-162.2, 3240.0], [-162.2, -3240.0]]
poles_rad_s = [
    [-11.6, 378.4], [-11.6, -378.4], [-256.6, 813.6], [-256.6, -813.6],
    [-240.2, 1333.0], [-240.2, -1333.0], [-270.5, 1967.0], [-270.5, -1967.0],
]
[lowpass]
source = "where the fit ends"
corner_hz = 523.5
order = 3
[highpass]
source = "where the fit begins"
corner_hz = 21.0
order = 2
"""


def with_booms(path: Path, onsets: Sequence[int], boom_hz: float, *, peak: float) -> Path:
    """Put a tone that dies away under each shot of a film, clipped where it is too much."""
    samples, _ = soundfile.read(path)
    for onset in onsets:
        t = np.arange(samples.size - onset) / RATE_HZ
        samples[onset:] += peak * np.sin(2.0 * np.pi * boom_hz * t) * np.exp(-t / 0.1)
    soundfile.write(path, np.clip(samples, -1.0, 1.0 - 2.0**-23), RATE_HZ, subtype="PCM_24")
    return path


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize(("boom_hz", "gap"), [(25.0, 9_000), (30.0, 5_000), (40.0, 7_000)])
def test_shots_with_a_boom_under_them_are_calm_before_the_next_in_draft(
    tmp_path: Path, phase: Phase, boom_hz: float, gap: int
) -> None:
    onsets = [24_000, 24_000 + gap, 24_000 + 2 * gap]
    path = with_booms(film(tmp_path / "film.wav", onsets, [0.6, 0.6, 0.6]), onsets, boom_hz, peak=0.6)
    options = RenderOptions(report=False, quality="draft", phase=phase)
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize("boom_hz", [15.0, 20.0, 25.0, 40.0, 60.0])
def test_a_drive_leads_with_a_boom_by_what_its_band_brings_it_forward_and_no_more(
    tmp_path: Path, boom_hz: float
) -> None:
    """A high-pass turns the phase of a tone forward, a low-pass back; a boom that dies away is a tone to both."""
    with_booms(film(tmp_path / "film.wav", [24_000], [0.3]), [24_000], boom_hz, peak=0.4)
    made = rendered(tmp_path / "film.wav", [24_000], RenderOptions(level_db=-6.0))
    assert failures(made) == []
    (lag_ms,) = (check.measured for check in made.checks if check.name == "felt_lag")
    band = dsp.band(load_actuator("crowson-t108sm")[0]).at(np.array([boom_hz]))
    due_ms = -1000.0 * float(np.angle(band)[0]) / (2.0 * np.pi * boom_hz)
    assert lag_ms == pytest.approx(due_ms, abs=0.25)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "aside.wav", np.roll(drive, -96), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=tmp_path / "film.wav", drive=tmp_path / "aside.wav")
    assert {"lag_as_rendered", "felt_lag"} <= {name for name, *_ in failures(checked)}


@pytest.mark.parametrize(
    ("boom_hz", "level_db", "quality"), [(15.0, 0.0, "standard"), (25.0, 6.0, "standard"), (40.0, 6.0, "draft")]
)
def test_a_boom_at_the_limit_displaces_no_right_drive_and_hides_no_displaced_one(
    tmp_path: Path, boom_hz: float, level_db: float, quality: Quality
) -> None:
    """Likeness rises on beyond what the limit bends a lag by, so that its largest within that is at the end of it."""
    path = with_booms(film(tmp_path / "film.wav", [24_000], [0.6]), [24_000], boom_hz, peak=0.9)
    options = RenderOptions(report=False, quality=quality, level_db=level_db)
    assert failures(rendered(path, [24_000], options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    for by, told in ((-48, "drive_shift"), (48, "drive_shift"), (-3, "lag_as_rendered"), (3, "lag_as_rendered")):
        soundfile.write(tmp_path / "aside.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "aside.wav")
        assert told in {name for name, *_ in failures(checked)}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_a_seat_that_rings_through_a_burst_a_right_drive_passes_and_a_wrong_one_fails(
    tmp_path: Path, seed: int
) -> None:
    """There a shot's drive may be more like the sound elsewhere than at its place, where it is as like as predicted."""
    seat = tmp_path / "rings.toml"
    seat.write_text(RINGING_SEAT, encoding="utf-8")
    onsets = [14_400 + number * 85 * 48 for number in range(5)]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.8, 0.9, 0.7, 0.9], decay_s=0.02, seed=seed)
    made = rendered(path, onsets, RenderOptions(report=False, actuator=str(seat)))
    assert failures(made) == []
    assert all(event.drive is not None and event.drive.fidelity < 0.7 for event in made.events)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    third = slice(onsets[2] - 48, onsets[3] - 48)
    for wrong in (np.roll(drive[third], 96), np.zeros_like(drive[third]), drive[third][::-1]):
        changed = drive.copy()
        changed[third] = wrong
        soundfile.write(tmp_path / "wrong.wav", changed, RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav", actuator=str(seat))
        assert "shot-0003" in {event for _, event, _ in failures(checked)}


def test_a_seat_whose_name_is_no_line_is_refused(tmp_path: Path) -> None:
    shipped = rules_path("actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(shipped.replace('"crowson-t108sm"', '"a\\nb"'), encoding="utf-8")
    with pytest.raises(RuleError, match=r"mine\.toml: name = 'a\\nb': expected printable characters alone"):
        load_actuator(str(seat))


def test_a_seat_that_fits_no_film_of_this_rate_is_named_before_the_film_is_heard(tmp_path: Path) -> None:
    shipped = (rules_path("actuators/crowson-t108sm.toml")).read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(re.sub(r"(\[lowpass\][^\[]*corner_hz = )[\d.]+", r"\g<1>30000.0", shipped), encoding="utf-8")
    path = film(tmp_path / "film.wav", [14_400], [0.9])
    heard: list[str] = []
    with pytest.raises(RuleError, match=r"mine\.toml: crowson-t108sm: lowpass\.corner_hz: 30000 Hz: expected"):
        run.render(path, tmp_path / "out", RenderOptions(actuator=str(seat)), lambda stage, *_: heard.append(stage))
    assert heard == []
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_film_that_begins_with_a_shot_passes(tmp_path: Path, phase: Phase) -> None:
    onsets = [0, 24_000, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.9] * 3)
    assert failures(rendered(path, onsets, RenderOptions(report=False, phase=phase))) == []


def test_a_lead_longer_than_the_checks_search_is_checked_as_well(tmp_path: Path) -> None:
    rules = tmp_path / "rules" / "quality" / "standard.toml"
    rules.parent.mkdir(parents=True)
    rules.write_text('schema = 1\nsource = "a test"\n[render]\nsource = "a test"\nlead_ms = 30.0\n')
    path = film(tmp_path / "film.wav", [14_400, 40_000], [0.9, 0.05])
    made = rendered(path, [14_400, 40_000], RenderOptions(report=False, rules=tmp_path / "rules"))
    assert {check.event for check in made.checks} > {"shot-0001", "shot-0002"}


def first_half(drive: Samples) -> Samples:
    return np.concatenate([drive[:20_000], np.zeros(drive.size - 20_000)])


def swapped(drive: Samples) -> Samples:
    return np.roll(drive, drive.size // 2)


def constant(drive: Samples) -> Samples:
    return np.full_like(drive, 0.3)


@pytest.mark.parametrize("wrong", [first_half, swapped, constant, np.flip])
def test_a_drive_that_is_not_this_films_fails_and_nothing_else_happens(
    tmp_path: Path, wrong: Callable[[Samples], Samples]
) -> None:
    onsets = [10_000, 30_000, 50_000]
    path = film(tmp_path / "film.wav", onsets, [0.3] * 3)
    rendered(path, onsets, RenderOptions(report=False, drive="direct"))
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "wrong.wav", wrong(drive), RATE_HZ, subtype="PCM_24")
    assert failures(run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav"))


STREET = """
schema = 1
rate_hz = 48000
duration_s = 30.0
seed = 77
[[beds]]
kind = "ambience"
level_dbfs = -46.0
[[beds]]
kind = "dialogue"
level_dbfs = -34.0
start_s = 4.0
stop_s = 20.0
"""
STREET_SHOTS = (
    (2.5, "pistol", 4.0, 34.0),
    (6.1, "shotgun", 12.0, 28.0),
    (10.0, "rifle", 35.0, 28.0),
    (14.2, "smg", 7.0, 30.0),
    (14.32, "smg", 7.0, 30.0),
    (14.44, "smg", 7.0, 30.0),
    (20.0, "pistol", 20.0, 34.0),
    (25.3, "rifle", 30.0, 34.0),
)


@pytest.mark.parametrize("kept", [(1, 7), (0, 7), (2, 7)])
def test_a_draft_solved_at_few_corners_has_no_drift(tmp_path: Path, kept: tuple[int, ...]) -> None:
    """The last shot, at the limit, is followed by 0.998, but 0.7 samples beside its place."""
    shots = "".join(
        f'[[shots]]\nat_s = {at_s}\nweapon = "{weapon}"\nenvironment = "street"\ndistance_m = {metres}\nsnr_db = {db}\n'
        for at_s, weapon, metres, db in STREET_SHOTS
    )
    (tmp_path / "street.toml").write_text(STREET + shots)
    run.synthesise(tmp_path / "street.toml", tmp_path)
    truth = json.loads((tmp_path / "street.truth.json").read_text())
    onsets = [truth["shots"][index]["onset_sample"] for index in kept]
    made = rendered(tmp_path / "street.wav", onsets, RenderOptions(report=False, quality="draft"))
    assert failures(made) == []


def resonant(path: Path, resonance_hz: float, q: float, up_to_hz: float) -> str:
    """Write the profile of a seat with one resonance, up to a frequency; a full drive is felt by half at most."""
    pole = 2.0 * np.pi * resonance_hz * complex(-0.5 / q, (1.0 - 0.25 / q**2) ** 0.5)
    at = 2.0j * np.pi * np.geomspace(1.0, up_to_hz, 2000)
    gain = 0.5 / float(np.abs(1.0 / ((at - pole) * (at - pole.conjugate()))).max())
    path.write_text(
        f"""schema = 1
name = "seat"
source = "a test"
lowpass = {{ source = "a test", corner_hz = {up_to_hz}, order = 4 }}
highpass = {{ source = "a test", corner_hz = 5.0, order = 1 }}
[response]
source = "a resonance"
gain = {gain}
zeros_rad_s = []
poles_rad_s = [[{pole.real}, {pole.imag}], [{pole.real}, {-pole.imag}]]
""",
        encoding="utf-8",
    )
    return str(path)


@pytest.mark.parametrize(
    ("resonance_hz", "q", "up_to_hz", "quality", "phase", "boom_hz"),
    [
        (25.0, 1.0, 500.0, "draft", "zero", 0.0),
        (25.0, 1.0, 500.0, "reference", "causal", 0.0),
        (25.0, 3.0, 500.0, "draft", "causal", 25.0),
        (25.0, 8.0, 1000.0, "reference", "causal", 25.0),
        (40.0, 1.0, 80.0, "draft", "zero", 0.0),
        (40.0, 3.0, 150.0, "reference", "zero", 0.0),
        (40.0, 3.0, 500.0, "draft", "causal", 25.0),
        (58.0, 1.0, 500.0, "reference", "causal", 0.0),
    ],
)
def test_how_well_a_lag_is_known_decides_what_it_is_held_to(
    tmp_path: Path, resonance_hz: float, q: float, up_to_hz: float, quality: Quality, phase: Phase, boom_hz: float
) -> None:
    """What is slow, or at the limit, tells its lag badly; so do the shots of a burst on a seat that rings for long."""
    onsets = [14_400, 21_000, 40_000, 52_000]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.3, 0.1, 0.6])
    if boom_hz:
        with_booms(path, onsets, boom_hz, peak=0.5)
    seat = resonant(tmp_path / "seat.toml", resonance_hz, q, up_to_hz)
    options = RenderOptions(report=False, actuator=seat, quality=quality, phase=phase)
    assert failures(rendered(path, onsets, options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    for by in (-960, 960):
        soundfile.write(tmp_path / "aside.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "aside.wav", actuator=seat)
        assert {"drive_shift", "lag_as_rendered"} & {name for name, *_ in failures(checked)}
