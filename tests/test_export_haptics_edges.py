"""Haptic files where a window meets another or an end of the film, and how strong their pulses are."""

import csv
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from blastline.export import HAPTIC_FORMATS, HapticTrack, haptic_track
from blastline.export.haptics.envelope import amplitudes, frequencies
from haptic_films import PROFILE, RATE_HZ, RULES, bang, drive_of, event, film, played, track_of, write
from haptic_rules import hjif_played, strict_json

NAMES = tuple(HAPTIC_FORMATS)
MS = RATE_HZ // 1000
BEFORE_END = [1, 10, 40, 47, 48, 200]


def ending(before_end: int) -> HapticTrack:
    """Return a film of two seconds whose one attack is so many samples before its end."""
    frames, onset = 2 * RATE_HZ, 2 * RATE_HZ - before_end
    drive = np.zeros(frames)
    drive[onset:] = 0.8
    return track_of(film([event(onset, window=(onset - 288, frames))], frames), drive)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("before_end", BEFORE_END)
def test_every_format_ends_at_rest_however_late_the_last_attack_is(tmp_path: Path, name: str, before_end: int) -> None:
    """A player holds the last point that it was given."""
    found = played(ending(before_end), tmp_path, name)
    assert len(found.pulses) == 1
    assert found.amplitude[-1][1] == 0.0
    assert max(value for _, value in found.amplitude) > 0.5


@pytest.mark.parametrize("before_end", BEFORE_END)
def test_reels_in_a_row_are_the_film_however_late_the_last_attack_is(tmp_path: Path, before_end: int) -> None:
    write(ending(before_end), tmp_path, "haptic")
    with (tmp_path / "timeline.reels.csv").open(newline="") as table:
        assert [row["stop_s"] for row in csv.DictReader(table)] == ["2.0"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("apart", [0, 1, 20, 47, 48, 49, 95, 96, 97])
def test_windows_within_two_milliseconds_of_each_other_keep_to_the_rules(tmp_path: Path, name: str, apart: int) -> None:
    """Both windows vibrate up to their ends, where a line of a millisecond leads up to an attack."""
    windows = (20_000, 29_000), (29_000 + apart, 38_000)
    drive = np.zeros(RATE_HZ)
    for start, stop in windows:
        drive[start:stop] = 0.6
    shots = [event(start, window=(start, stop)) for start, stop in windows]
    found = played(track_of(film(shots, RATE_HZ), drive), tmp_path, name)
    times_s = [time_s for time_s, _ in found.pulses]
    np.testing.assert_allclose(times_s, [start / RATE_HZ for start, _ in windows], rtol=0.0, atol=5.1e-4)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("onset", [0, 1, 20, 47, 48, 49])
def test_nothing_is_earlier_than_the_film(tmp_path: Path, name: str, onset: int) -> None:
    """A trailer that is cut to its first bang, in a window without a lead."""
    drive = np.zeros(RATE_HZ)
    drive[onset:9000] = bang(9000 - onset)
    found = played(track_of(film([event(onset, window=(onset, 9000))], RATE_HZ), drive), tmp_path, name)
    assert min(time_s for time_s, _ in [*found.pulses, *found.amplitude, *found.frequency]) >= 0.0
    assert [time_s for time_s, _ in found.pulses] == pytest.approx([onset / RATE_HZ], abs=5.1e-4)


@pytest.mark.parametrize(("low_hz", "high_hz"), [(5.0, 1000.0), (30.5, 250.5)])
def test_the_band_that_is_declared_is_the_actuators_and_every_tone_is_in_it(
    tmp_path: Path, low_hz: float, high_hz: float
) -> None:
    profile = msgspec.structs.replace(
        PROFILE,
        highpass=msgspec.structs.replace(PROFILE.highpass, corner_hz=low_hz),
        lowpass=msgspec.structs.replace(PROFILE.lowpass, corner_hz=high_hz),
    )
    shots = [event(RATE_HZ // 4), event(RATE_HZ)]
    drive = np.zeros(3 * RATE_HZ // 2)
    for shot, tone_hz in zip(shots, (20.0, 400.0), strict=True):
        drive[shot.onset_sample : shot.window.stop] = bang(RATE_HZ // 5, tone_hz=tone_hz)
    whole = film(shots, len(drive))
    track = haptic_track(whole, lambda span: drive[span.start : span.stop], profile=profile, rules=RULES)
    assert (track.low_hz, track.high_hz) == (low_hz, high_hz)
    write(track, tmp_path, "hjif")
    hjif_played(tmp_path / "timeline.hjif")
    [perception] = strict_json(tmp_path / "timeline.hjif")["perceptions"]
    for device in perception["reference_devices"]:
        assert (device["minimum_frequency"], device["maximum_frequency"]) == (low_hz, high_hz)
    bands = [band for channel in perception["channels"] for band in channel["bands"]]
    limits = {(band["lower_frequency_limit"], band["upper_frequency_limit"]) for band in bands}
    assert limits == {(math.floor(low_hz), math.ceil(high_hz))}
    frames = [frame for band in bands for effect in band["effects"] for frame in effect["keyframes"]]
    tones_hz = [frame["frequency_modulation"] for frame in frames if "frequency_modulation" in frame]
    assert low_hz - 1.0 <= min(tones_hz) < max(tones_hz) <= high_hz + 1.0


def test_a_pulse_is_as_strong_as_the_attack_that_begins_a_millisecond_before_its_onset() -> None:
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ - 2 * MS] = 1.0  # too early to be the shot's
    drive[RATE_HZ - MS // 2 : RATE_HZ] = 0.9
    drive[RATE_HZ : RATE_HZ + 60 * MS] = 0.3
    [pulse] = track_of(film([event(RATE_HZ)], 2 * RATE_HZ), drive).pulses
    assert (pulse.sample, pulse.amplitude) == (RATE_HZ, 0.9)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_played_at_a_pulse_is_as_strong_as_the_drives_attack(tmp_path: Path, name: str) -> None:
    """Clicks far apart, each above the wave of its own power; a transient of HJIF is played on top of that."""
    peaks = [0.1, 0.3, 0.9]
    shots = [event(place * RATE_HZ // 2) for place in (1, 2, 3)]
    drive = np.zeros(2 * RATE_HZ)
    for shot, peak in zip(shots, peaks, strict=True):
        drive[shot.onset_sample : shot.onset_sample + 20] = peak
    track = track_of(film(shots, 2 * RATE_HZ), drive)
    found = played(track, tmp_path, name)
    times_s, strengths = (np.array(column) for column in zip(*found.pulses, strict=True))
    waves = found.amplitude_at(times_s)
    assert np.all(waves < np.array(peaks) / 2.0)
    together = strengths + waves if name == "hjif" else strengths
    np.testing.assert_allclose(together, peaks, rtol=0.0, atol=1e-3 + (track.amplitude_error if name == "hjif" else 0))


@pytest.mark.parametrize("peak", [1e-2, 1e-3, 1e-4, 1e-5])
def test_no_pulse_is_lost_however_soft_the_drive_is(tmp_path: Path, peak: float) -> None:
    """The binary form of HJIF has 8 bits for an amplitude: one step of them is the least that is played."""
    whole = film([event(place * RATE_HZ // 2) for place in (1, 2, 3)], 2 * RATE_HZ)
    write(track_of(whole, drive_of(whole, peak=peak)), tmp_path, "hjif")
    for channel in hjif_played(tmp_path / "timeline.hjif"):
        assert len(channel.pulses) == 3
        assert min(round(255.0 * strength) for _, strength in channel.pulses) >= 1


@pytest.mark.parametrize("after_ms", [30, 60, 100])
def test_an_echo_well_before_the_next_shot_is_a_pulse_as_it_is_without_that(after_ms: int) -> None:
    echo, following = RATE_HZ + 60 * MS, RATE_HZ + (60 + after_ms) * MS
    first = event(RATE_HZ, window=(RATE_HZ - 6 * MS, following), echoes=[echo])
    drive = np.zeros(2 * RATE_HZ)
    for place in (RATE_HZ, echo, following):
        drive[place : place + 10 * MS] = 0.5
    for shots in ([first], [first, event(following)]):
        pulses = track_of(film(shots, len(drive)), drive).pulses
        assert [pulse.sample for pulse in pulses if pulse.is_echo] == [echo]


def test_of_two_tones_the_one_that_sounds_at_a_point_says_what_is_felt_there() -> None:
    size = math.ceil(RULES.spectrum_ms * RATE_HZ / 1000.0)
    time_s = np.arange(size // 2) / RATE_HZ
    tones = [np.sin(2.0 * np.pi * hz * time_s) for hz in (100.0, 300.0)]
    felt_hz = [
        frequencies(np.concatenate(order), np.array([0]), [0], rate_hz=RATE_HZ, rules=RULES, band=(20.0, 1000.0)).item()
        for order in (tones, tones[::-1])
    ]
    assert felt_hz[0] < 160.0
    assert felt_hz[1] > 240.0


@pytest.mark.parametrize("level", [0.25, 0.5])
def test_a_steady_drive_is_as_strong_at_a_films_beginning_as_anywhere(level: float) -> None:
    points = np.array([0, 10, 48, 500, 990])
    found = amplitudes(np.full(1_000, level), points, [0], average=48)
    assert found == pytest.approx(np.full(len(points), math.sqrt(2.0) * level))
