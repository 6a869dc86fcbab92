"""What the haptic formats say is what the drive does: read by their own public rules, against its own power."""

import csv
import itertools
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from blastline.errors import TimelineError
from blastline.export import HAPTIC_FORMATS, haptic_track
from blastline.export.haptics.ahap import continuous_events
from blastline.export.haptics.curve import Curve, reduced
from blastline.export.haptics.reels import reel_edges
from blastline.export.haptics.sharing import shared
from blastline.export.haptics.track import VibrationSegment
from blastline.model import Span
from haptic_films import PROFILE, RATE_HZ, RULES, Samples, bang, drive_of, event, film, played, track_of, write
from haptic_rules import haptic_played, hjif_played

NAMES = tuple(HAPTIC_FORMATS)
TIME_MS = {"ahap": 0.001, "haptic": 0.1, "hjif": 0.5}
MS = RATE_HZ // 1000

SHOTS = [
    event(RATE_HZ, echoes=[RATE_HZ + 60 * MS]),
    event(2 * RATE_HZ + 17, burst=1, window=(2 * RATE_HZ - 300, 3 * RATE_HZ)),
    event(2 * RATE_HZ + 17 + 90 * MS, burst=1, window=(2 * RATE_HZ - 300, 3 * RATE_HZ)),
    event(2 * RATE_HZ + 17 + 181 * MS, burst=1, window=(2 * RATE_HZ - 300, 3 * RATE_HZ)),
    event(4 * RATE_HZ + 1001),
]
FILM = film(SHOTS, 5 * RATE_HZ)
ATTACKS = sorted([*(each.onset_sample for each in SHOTS), SHOTS[0].reflections[0].start])


def power_amplitude(drive: Samples, sample: int, *, start: int, attacks: list[int]) -> float:
    """Return the amplitude of a sine with the power of the drive around a sample, as it is defined, one by one."""
    average = round(RULES.average_ms * MS)
    last = max([start, *(attack for attack in attacks if attack <= sample)])
    following = min([len(drive), *(attack for attack in attacks if attack > sample)])
    first = max(last, sample - average)
    power = [drive[k] ** 2 for k in range(first, min(first + average, following))]
    return min(1.0, math.sqrt(2.0 * sum(power) / len(power)))


@pytest.mark.parametrize("name", NAMES)
def test_every_shot_and_strong_echo_is_a_pulse_at_its_time(tmp_path: Path, name: str) -> None:
    found = played(track_of(FILM, drive_of(FILM, peak=0.5)), tmp_path, name)
    times_s = [time_s for time_s, _ in found.pulses]
    np.testing.assert_allclose(times_s, np.array(ATTACKS) / RATE_HZ, rtol=0.0, atol=TIME_MS[name] / 1000.0 + 1e-12)
    shot, echo = found.pulses[:2]
    assert echo[1] < shot[1]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("peak", [0.05, 0.5])
def test_what_is_played_has_the_power_of_the_drive(tmp_path: Path, name: str, peak: float) -> None:
    drive = drive_of(FILM, peak=peak)
    track = track_of(FILM, drive)
    rounding = write(track, tmp_path / "again", name)
    found = played(track, tmp_path, name)
    attacks = [pulse.sample for pulse in track.pulses]
    late = math.ceil(rounding.time_ms * MS)
    checked = 0
    for start, stop in ((SHOTS[0].window.start, SHOTS[0].window.stop), (2 * RATE_HZ - 300, 3 * RATE_HZ)):
        own = [attack for attack in attacks if start <= attack < stop]
        for attack, following in itertools.pairwise([*own, stop]):
            for sample in range(attack, following - 3 * MS, MS):
                about = [
                    power_amplitude(drive[:stop], k, start=start, attacks=own)
                    for k in sorted({max(attack, sample - late), sample, sample + late})
                ]
                heard = float(found.amplitude_at(np.array([sample / RATE_HZ]))[0])
                # between the points that are read, a millisecond apart, the power runs on
                margin = rounding.amplitude + 1e-4 + (0.05 * peak if late else 0.0)
                assert min(about) - margin <= heard <= max(about) + margin, (sample - attack, heard, about)
                checked += 1
    assert checked > 900


@pytest.mark.parametrize("name", NAMES)
def test_an_attack_is_whole_at_its_onset_and_absent_a_millisecond_before(tmp_path: Path, name: str) -> None:
    """Nothing is smeared across the onset and nothing is late."""
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ : RATE_HZ + 4800] = 0.6 * np.sin(2.0 * np.pi * 100.0 * np.arange(4800) / RATE_HZ)
    whole = film([event(RATE_HZ, window=(RATE_HZ - 480, RATE_HZ + 4800))], 2 * RATE_HZ)
    found = played(track_of(whole, drive), tmp_path, name)
    before, at, after = found.amplitude_at(np.array([0.9985, 1.0, 1.05]))
    assert before == 0.0
    assert (at, after) == (pytest.approx(0.6, abs=0.015), pytest.approx(0.6, abs=0.015))
    assert found.amplitude_at(np.array([1.1015]))[0] == 0.0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("lead", [1, MS // 2, MS])
def test_nothing_is_played_while_the_drive_is_still_at_rest(tmp_path: Path, name: str, lead: int) -> None:
    """A solved drive begins up to a millisecond before its shot."""
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ - lead : RATE_HZ + 4800] = 0.5
    whole = film([event(RATE_HZ, window=(RATE_HZ - 480, RATE_HZ + 4800))], 2 * RATE_HZ)
    found = played(track_of(whole, drive), tmp_path, name)
    assert np.all(found.amplitude_at(np.linspace(0.9, 1.0 - 1.001e-3, 300)) == 0.0)
    assert found.amplitude_at(np.array([1.0]))[0] == pytest.approx(0.5 * math.sqrt(2.0), abs=0.015)


def test_what_comes_with_an_attack_changes_nothing_before_it() -> None:
    whole = film([event(RATE_HZ), event(RATE_HZ + 120 * MS, window=(RATE_HZ, 2 * RATE_HZ))], 2 * RATE_HZ)
    one, other = (drive_of(whole), drive_of(whole))
    other[RATE_HZ + 120 * MS :] = bang(RATE_HZ - 120 * MS, tone_hz=400.0, seed=7)
    [first], [second] = (track_of(whole, drive).segments for drive in (one, other))
    before = np.arange(RATE_HZ, RATE_HZ + 119 * MS)
    np.testing.assert_allclose(first.amplitude.at(before), second.amplitude.at(before), rtol=1e-6)
    np.testing.assert_allclose(first.frequency_hz.at(before), second.frequency_hz.at(before), rtol=1e-6)
    assert second.frequency_hz.at(before + 2 * MS)[-1] > 2.0 * first.frequency_hz.at(before + 2 * MS)[-1]


def test_a_pulse_is_as_strong_as_its_own_attack_and_not_the_next_ones() -> None:
    whole = film([event(RATE_HZ), event(RATE_HZ + 10 * MS)], 2 * RATE_HZ)
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ : RATE_HZ + 9 * MS] = 0.2
    drive[RATE_HZ + 9 * MS : RATE_HZ + 60 * MS] = 0.9  # a drive may begin a millisecond before its shot
    assert [pulse.amplitude for pulse in track_of(whole, drive).pulses] == [0.2, 0.9]


def test_an_echo_that_the_drive_does_not_rise_at_is_no_pulse() -> None:
    whole = film([event(RATE_HZ, echoes=[RATE_HZ + 80 * MS])], 2 * RATE_HZ)
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ:] = 0.9 * np.exp(-np.arange(RATE_HZ) / (0.1 * RATE_HZ))
    assert [pulse.is_echo for pulse in track_of(whole, drive).pulses] == [False]
    drive[RATE_HZ + 80 * MS :] *= 2.0
    assert [pulse.is_echo for pulse in track_of(whole, drive).pulses] == [False, True]


def test_a_wave_leaves_room_to_a_transient_of_the_window_before(tmp_path: Path) -> None:
    onsets = RATE_HZ, RATE_HZ + 40 * MS
    windows = (RATE_HZ - 6 * MS, RATE_HZ + 8 * MS), (RATE_HZ + 12 * MS, RATE_HZ + 100 * MS)
    whole = film([event(at, window=reach) for at, reach in zip(onsets, windows, strict=True)], 2 * RATE_HZ)
    drive = np.zeros(2 * RATE_HZ)
    for start, stop in windows:
        drive[start:stop] = 0.7  # a sine of this power is as strong as 0.99
    drive[RATE_HZ - 6 * MS : RATE_HZ] = 0.0
    track = track_of(whole, drive)
    assert len(track.segments) == 2
    assert played(track, tmp_path, "hjif").pulses, "the player has checked that all together keeps within 1"


@pytest.mark.parametrize("name", NAMES)
def test_an_impulse_loses_no_power(tmp_path: Path, name: str) -> None:
    """A sine of the amplitude that is played has the energy of what drives the seat."""
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ : RATE_HZ + 20] = 0.8
    whole = film([event(RATE_HZ)], 2 * RATE_HZ)
    found = played(track_of(whole, drive), tmp_path, name)
    times_s = np.arange(0.98, 1.1, 1e-5)
    energy = float(np.sum(found.amplitude_at(times_s) ** 2) / 2.0 * 1e-5)
    assert energy == pytest.approx(float(np.sum(drive**2)) / RATE_HZ, rel=0.15)


@pytest.mark.parametrize("tone_hz", [100.0, 180.0, 280.0])
def test_the_frequency_is_that_of_the_drive(tmp_path: Path, tone_hz: float) -> None:
    drive = np.zeros(2 * RATE_HZ)
    drive[RATE_HZ : RATE_HZ + 9600] = 0.6 * np.sin(2.0 * np.pi * tone_hz * np.arange(9600) / RATE_HZ)
    track = track_of(film([event(RATE_HZ)], 2 * RATE_HZ), drive)
    about_s = np.array([1.02, 1.05, 1.1])
    lowest_highest = {"ahap": (65.0, 300.0), "haptic": (30.0, 600.0), "hjif": (0.0, 1.0)}
    for name, (low, high) in lowest_highest.items():
        heard = low + (high - low) * played(track, tmp_path, name).frequency_at(about_s)
        np.testing.assert_allclose(heard, tone_hz, rtol=0.1 + RULES.frequency_error)


def test_an_hour_later_everything_is_an_hour_later(tmp_path: Path) -> None:
    hour = 3600 * RATE_HZ
    drive = drive_of(FILM)
    moved = film(
        [
            event(
                each.onset_sample + hour,
                window=(each.window.start + hour, each.window.stop + hour),
                echoes=[echo.start + hour for echo in each.reflections],
                burst=each.burst,
            )
            for each in SHOTS
        ],
        FILM.source.frames + hour,
    )

    def late(span: Span) -> Samples:
        return drive[span.start - hour : span.stop - hour]

    for name in NAMES:
        write(track_of(FILM, drive), tmp_path / "first", name)
        write(haptic_track(moved, late, profile=PROFILE, rules=RULES), tmp_path / "moved", name)
    for name in ("timeline.continuous.ahap", "timeline.transients.ahap"):
        for here, there in zip(
            *(_ahap_entries(tmp_path / folder / name) for folder in ("first", "moved")), strict=True
        ):
            assert there.pop("Time") == pytest.approx(here.pop("Time") + 3600.0, abs=1.1e-6)
            if "EventDuration" in here:
                assert there.pop("EventDuration") == pytest.approx(here.pop("EventDuration"), abs=2.1e-6)
            if "ParameterCurveControlPoints" in here:
                ours, theirs = (each.pop("ParameterCurveControlPoints") for each in (here, there))
                assert [p["ParameterValue"] for p in ours] == [p["ParameterValue"] for p in theirs]
                np.testing.assert_allclose([p["Time"] for p in ours], [p["Time"] for p in theirs], rtol=0, atol=2.1e-6)
            assert there == here
    first, moved_hjif = (json.loads((tmp_path / f / "timeline.hjif").read_bytes()) for f in ("first", "moved"))
    for effect in _hjif_effects(first):
        effect["position"] += 3_600_000
    assert moved_hjif == first
    assert (tmp_path / "moved" / "timeline.reel-05.haptic").read_bytes() == (
        tmp_path / "first" / "timeline.reel-01.haptic"
    ).read_bytes()
    assert [f.name for f in sorted((tmp_path / "moved").glob("*.haptic"))] == [
        f"timeline.reel-0{number}.haptic" for number in range(1, 6)
    ]


def _ahap_entries(path: Path) -> list[dict[str, Any]]:
    return [content for entry in json.loads(path.read_bytes())["Pattern"] for content in entry.values()]


def _hjif_effects(whole: dict[str, Any]) -> list[dict[str, Any]]:
    channels = whole["perceptions"][0]["channels"]
    return [effect for channel in channels for band in channel["bands"] for effect in band["effects"]]


@pytest.mark.parametrize("index", range(len(SHOTS)))
def test_a_deleted_event_takes_just_its_own_effects(tmp_path: Path, index: int) -> None:
    drive = drive_of(FILM, peak=0.5)
    rest = film([each for k, each in enumerate(SHOTS) if k != index], FILM.source.frames)
    gone = {SHOTS[index].onset_sample, *(echo.start for echo in SHOTS[index].reflections)}
    whole_track, rest_track = track_of(FILM, drive), track_of(rest, drive)
    assert rest_track.pulses == tuple(pulse for pulse in whole_track.pulses if pulse.sample not in gone)
    for name in NAMES:
        before, after = played(whole_track, tmp_path / "a", name), played(rest_track, tmp_path / "b", name)
        left = [pulse for pulse in before.pulses if min(abs(pulse[0] - sample / RATE_HZ) for sample in gone) > 0.001]
        assert after.pulses == left
        alone = SHOTS[index].burst is None
        start_s, stop_s = (edge / RATE_HZ for edge in (SHOTS[index].window.start, SHOTS[index].window.stop))
        elsewhere = [point for point in before.amplitude if not start_s - 0.002 < point[0] < stop_s + 0.002]
        assert [point for point in after.amplitude if not start_s - 0.002 < point[0] < stop_s + 0.002] == elsewhere
        if alone:
            assert np.all(after.amplitude_at(np.linspace(start_s, stop_s, 100)) == 0.0)


def test_weak_echoes_and_those_too_soon_are_no_pulses() -> None:
    shot = event(RATE_HZ, echoes=[RATE_HZ + 15 * MS, RATE_HZ + 60 * MS, RATE_HZ + 100 * MS])
    whole = film([shot], 2 * RATE_HZ)
    drive = drive_of(whole)
    assert [pulse.sample for pulse in track_of(whole, drive).pulses] == [
        RATE_HZ,
        RATE_HZ + 60 * MS,
        RATE_HZ + 100 * MS,
    ]
    quiet = 0.04 * drive / np.max(np.abs(drive[RATE_HZ + 60 * MS :]))
    assert [pulse.sample for pulse in track_of(whole, quiet).pulses] == [RATE_HZ]


def test_beside_a_transient_the_wave_leaves_room(tmp_path: Path) -> None:
    """A drive at its limit: `hjif_played` adds up what sounds together."""
    drive = np.zeros(3 * RATE_HZ)
    drive[RATE_HZ : 2 * RATE_HZ] = np.sign(np.sin(2.0 * np.pi * 50.0 * np.arange(RATE_HZ) / RATE_HZ))
    shots = [event(RATE_HZ + k * 12 * MS, window=(RATE_HZ - 480, 2 * RATE_HZ), name=f"s{k}") for k in range(9)]
    track = track_of(film(shots, 3 * RATE_HZ), drive)
    rounding = write(track, tmp_path, "hjif")
    assert "leaves it room" in str(rounding)
    [found, _] = hjif_played(tmp_path / "timeline.hjif")
    assert len(found.pulses) == 9
    assert found.amplitude_at(np.array([1.5]))[0] == pytest.approx(1.0, abs=0.011)


@given(
    st.lists(st.tuples(st.integers(0, 60), st.integers(1, 1000)), max_size=20).map(sorted),
    st.sampled_from([5, 22]),
)
def test_what_sounds_together_keeps_within_the_room_and_in_order(pulses: list[tuple[int, int]], length: int) -> None:
    positions, asked = [at for at, _ in pulses], [strength for _, strength in pulses]
    given_ = shared(positions, asked, length=length, room=1000)
    for place, (at, strength) in enumerate(pulses):
        sounding = [k for k, other in enumerate(positions) if other <= at <= other + length]
        assert sum(given_[k] for k in sounding) <= 1000 + len(sounding)  # one step each, where it would be 0
        assert 1 <= given_[place] <= strength
        if sum(asked[k] for k in sounding) > 1000:
            assert all(given_[k] <= given_[j] for k in sounding for j in sounding if asked[k] <= asked[j])
    if all(sum(s for at, s in pulses if at <= place <= at + length) <= 1000 for place in positions):
        assert given_ == asked


@pytest.mark.parametrize("apart_ms", [2, 7, 12, 20])
def test_no_round_of_dense_fire_is_lost_and_the_stronger_stays_the_stronger(tmp_path: Path, apart_ms: int) -> None:
    drive = np.zeros(2 * RATE_HZ)
    onsets = [RATE_HZ + k * apart_ms * MS for k in range(20)]
    for number, onset in enumerate(onsets):
        drive[onset] = 0.9 if number % 3 else 0.6
    shots = [event(onset, window=(RATE_HZ - 480, RATE_HZ * 3 // 2), burst=1) for onset in onsets]
    track = track_of(film(shots, 2 * RATE_HZ), drive)
    rounding = write(track, tmp_path, "hjif")
    assert "are weakened" in str(rounding)
    [found, _] = hjif_played(tmp_path / "timeline.hjif")
    strengths = [strength for _, strength in found.pulses]
    assert min(strengths) > 0.0
    weak = [strengths[k] for k in range(len(onsets)) if k % 3 == 0]
    strong = [strengths[k] for k in range(len(onsets)) if k % 3]
    assert len(strengths) == len(onsets)
    assert max(weak) < min(strong)


@pytest.mark.parametrize(("late_ms", "is_late"), [(-400, False), (0, False), (1, True), (400, True)])
def test_hjif_refuses_what_is_later_than_it_can_count(tmp_path: Path, late_ms: int, is_late: bool) -> None:
    onset = (2**25 - 1 + late_ms) * MS
    whole = film([event(onset)], onset + RATE_HZ)
    track = haptic_track(whole, lambda span: bang(len(span)), profile=PROFILE, rules=RULES)
    if is_late:
        with pytest.raises(
            TimelineError, match=r"^hjif: an effect at 09:19:1\d\.\d+: expected none after 09:19:14\.431"
        ):
            write(track, tmp_path, "hjif")
        assert not [*tmp_path.iterdir()]
    else:
        write(track, tmp_path, "hjif")
        assert [len(channel.pulses) for channel in hjif_played(tmp_path / "timeline.hjif")] == [1, 1]


def test_automatic_fire_has_a_keyword_of_its_own(tmp_path: Path) -> None:
    write(track_of(FILM, drive_of(FILM)), tmp_path, "hjif")
    band = json.loads((tmp_path / "timeline.hjif").read_bytes())["perceptions"][0]["channels"][0]["bands"][0]
    assert [effect.get("semantic_keywords") for effect in band["effects"]] == [
        "WeaponCombat/Gun",
        None,
        *["WeaponCombat/Machinegun"] * 3,
        "WeaponCombat/Gun",
    ]


def test_a_long_stretch_is_cut_where_a_format_must(tmp_path: Path) -> None:
    """Seventy seconds of vibration: more than a continuous event, than a curve and than a wave may last."""
    rate = RATE_HZ
    drive = np.zeros(80 * rate)
    time_s = np.arange(70 * rate) / rate
    drive[5 * rate : 75 * rate] = (
        0.5 * np.sin(2 * np.pi * 100.0 * time_s) * (1.0 + 0.5 * np.sin(2 * np.pi * 0.7 * time_s))
    )
    track = track_of(film([event(5 * rate, window=(5 * rate - 300, 75 * rate))], 80 * rate), drive)
    about_s = np.linspace(6.0, 74.0, 500)
    expected = 0.5 * (1.0 + 0.5 * np.sin(2 * np.pi * 0.7 * (about_s - 5.005)))
    for name in NAMES:
        np.testing.assert_allclose(played(track, tmp_path, name).amplitude_at(about_s), expected, rtol=0.0, atol=0.03)


@pytest.mark.parametrize(("start", "seconds"), [(3141, 300), (3141, 30), (0, 60), (1, 90)])
def test_a_stretch_of_whole_half_minutes_has_no_event_longer_than_one(start: int, seconds: int) -> None:
    """Where an event begins and ends is rounded, and how long it lasts must still be within 30 s."""
    events = [each["Event"] for each in continuous_events(start / RATE_HZ, start / RATE_HZ + seconds)]
    assert max(each["EventDuration"] for each in events) <= 30.0
    for each, following in itertools.pairwise(events):
        assert each["Time"] + each["EventDuration"] == pytest.approx(following["Time"], abs=1e-9)
    assert events[0]["Time"] == pytest.approx(start / RATE_HZ, abs=5.1e-7)
    assert events[-1]["Time"] + events[-1]["EventDuration"] == pytest.approx(start / RATE_HZ + seconds, abs=5.1e-7)


def test_a_long_film_comes_in_reels_within_a_tenth_of_a_millisecond(tmp_path: Path) -> None:
    rate, length_s = RATE_HZ, 9000
    random = np.random.default_rng(3)
    onsets = np.sort(random.integers(rate, (length_s - 2) * rate, 300))
    onsets[100] = 1800 * rate - 100  # vibrates across a cut
    whole = film([event(int(onset), name=f"shot-{k}") for k, onset in enumerate(np.sort(onsets))], length_s * rate)
    sound = bang(rate // 2)

    def drive(span: Span) -> Samples:
        made = np.zeros(len(span))
        for onset in onsets[(onsets >= span.start) & (onsets < span.stop)]:
            start = int(onset) - span.start
            part = sound[: max(0, min(rate // 5, len(made) - start))]
            made[start : start + len(part)] = part
        return made

    track = haptic_track(whole, drive, profile=PROFILE, rules=RULES)
    rounding = write(track, tmp_path, "haptic")
    assert rounding.time_ms <= 0.1
    with (tmp_path / "timeline.reels.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["file"] for row in rows] == sorted(path.name for path in tmp_path.glob("*.haptic"))
    assert pandas.read_csv(tmp_path / "timeline.reels.csv")["pulses"].sum() == len(onsets)
    assert (rows[0]["start_s"], rows[1]["start"], rows[-1]["stop_s"]) == ("0.0", "0:15:00", f"{length_s}.0")
    assert rows[2]["start_s"] == "1799.0"
    found: list[float] = []
    for row, following in itertools.pairwise([*rows, None]):
        assert row is not None
        reel = haptic_played(tmp_path / row["file"])
        assert reel.amplitude[-1][0] <= 1024.0
        assert float(row["stop_s"]) == float(following["start_s"] if following else length_s)
        assert reel.amplitude[-1][0] == pytest.approx(float(row["stop_s"]) - float(row["start_s"]), abs=1e-4)
        assert (reel.amplitude[0][1], reel.amplitude[-1][1]) == (0.0, 0.0)
        found += [int(row["start_sample"]) / rate + time_s for time_s, _ in reel.pulses]
    np.testing.assert_allclose(found, np.sort(onsets) / rate, rtol=0.0, atol=1e-4)


@pytest.mark.parametrize("reel_s", [10.0, 20.0, 59.6])
@pytest.mark.parametrize(("start_s", "stop_s"), [(0.0, 59.0), (0.5, 61.0), (4.5, 64.0), (15.5, 130.0), (9.0, 10.0)])
def test_every_reel_lasts_and_none_more_than_a_minute_beyond_its_length(
    reel_s: float, start_s: float, stop_s: float
) -> None:
    """A stretch that goes on over several places for a cut has one before it, not one for each."""
    rate = 8000
    silence = track_of(film([], 200 * rate, rate), np.zeros(200 * rate))
    ends = np.array([start_s, stop_s]) * rate
    segment = VibrationSegment(Curve(ends.astype(np.int64), np.zeros(2)), Curve(ends.astype(np.int64), np.ones(2)))
    edges = reel_edges(replace(silence, segments=(segment,), reel_s=reel_s))
    assert (edges[0], edges[-1]) == (0, 200 * rate)
    lengths_s = np.diff(edges) / rate
    assert lengths_s.min() > 0.0
    assert lengths_s.max() <= round(reel_s) + 60.0
    assert not [edge for edge in edges if edge % rate]


def test_a_stretch_too_long_to_spare_is_cut_where_it_vibrates(tmp_path: Path) -> None:
    rate = 8000
    frames = 1000 * rate
    whole = film([event(700 * rate, window=(700 * rate, 950 * rate), rate_hz=rate)], frames, rate)
    drive = np.zeros(frames)
    drive[700 * rate : 950 * rate] = 0.5 * np.sin(2 * np.pi * 50.0 * np.arange(250 * rate) / rate)
    track = track_of(whole, drive)
    assert reel_edges(track) == [0, 900 * rate, frames]
    write(track, tmp_path, "haptic")
    first, second = (haptic_played(path) for path in sorted(tmp_path.glob("*.haptic")))
    assert first.amplitude[-1] == pytest.approx((900.0, 0.5), abs=0.011)
    assert second.amplitude[0] == pytest.approx((0.0, 0.5), abs=0.011)


@pytest.mark.parametrize("name", NAMES)
def test_a_film_without_shots_is_a_valid_file_that_moves_nothing(tmp_path: Path, name: str) -> None:
    found = played(track_of(film([], 5 * RATE_HZ), np.zeros(5 * RATE_HZ)), tmp_path, name)
    assert all(strength == 0.0 for _, strength in found.pulses)
    assert np.all(found.amplitude_at(np.linspace(0.0, 5.0, 50)) ** 2 == 0.0) or name == "ahap"
    if name == "ahap":
        assert [entry["EventType"] for entry in _ahap_entries(tmp_path / "timeline.continuous.ahap")] == [
            "HapticContinuous"
        ]


def test_a_shot_without_vibration_is_named_and_gets_nothing(tmp_path: Path) -> None:
    drive = drive_of(FILM)
    drive[4 * RATE_HZ :] = 0.0
    track = track_of(FILM, drive)
    assert track.silent == (SHOTS[-1].id,)
    for name in NAMES:
        found = played(track, tmp_path, name)
        assert max(time_s for time_s, _ in found.pulses) < 4.0
        assert np.all(found.amplitude_at(np.linspace(4.0, 5.0, 50)) == 0.0)


def test_an_onset_behind_the_end_of_the_film_is_refused() -> None:
    with pytest.raises(
        TimelineError, match=r"events\[0\]\.onset_sample = 96000: expected a frame of the film, .* 48000"
    ):
        track_of(film([event(2 * RATE_HZ)], RATE_HZ), np.zeros(RATE_HZ))


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.data())
def test_whatever_the_events_the_files_keep_to_the_rules(tmp_path: Path, data: st.DataObject) -> None:
    """Windows of one sample, overlaps, onsets outside their window or too near, the first and the last frame."""
    rate = data.draw(st.sampled_from([8000, 11_025, 44_100, 48_000]))
    frames = data.draw(st.integers(1, rate))
    place = st.integers(0, frames - 1)
    events = []
    for index in range(data.draw(st.integers(0, 5))):
        start = data.draw(place)
        stop = data.draw(st.integers(start, frames + 100))
        echoes = data.draw(st.lists(place, max_size=2))
        events.append(event(data.draw(place), window=(start, stop), echoes=echoes, name=f"e{index}", rate_hz=rate))
    drive = data.draw(st.sampled_from([0.0, 1e-6, 0.3, 1.0])) * np.random.default_rng(0).uniform(-1.0, 1.0, frames)
    drive[data.draw(place) :] = 0.0
    track = track_of(film(events, frames, rate), drive)
    folder = tmp_path / str(len([*tmp_path.iterdir()]))
    for name in NAMES:
        found = played(track, folder, name)
        if track.pulses:
            expected = np.array([pulse.sample / rate for pulse in track.pulses])
            times_s = [time_s for time_s, _ in found.pulses]
            np.testing.assert_allclose(times_s, expected, rtol=0.0, atol=TIME_MS[name] / 1000.0 + 1e-12)


@given(st.lists(st.floats(0.0, 1.0), min_size=2, max_size=60), st.floats(0.001, 0.5))
def test_fewer_points_stay_within_the_error(values: list[float], tolerance: float) -> None:
    curve = Curve(np.cumsum(np.arange(1, len(values) + 1)), np.array(values))
    few = reduced(curve, tolerance)
    assert (few.samples[0], few.samples[-1]) == (curve.samples[0], curve.samples[-1])
    assert set(few.samples.tolist()) <= set(curve.samples.tolist())
    assert np.max(np.abs(few.at(curve.samples) - curve.values)) <= tolerance + 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_the_same_drive_gives_the_same_files(tmp_path: Path, name: str) -> None:
    track = track_of(FILM, drive_of(FILM))
    for folder in ("a", "b"):
        write(track, tmp_path / folder, name)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()
        assert b"\r" not in path.read_bytes()
