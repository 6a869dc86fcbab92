"""The parts of the report: which shots are shown, curves that look the same, spectra, and words."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from align_films import PROFILE, make_film
from blastline import dsp
from blastline.model import Check, Clip, Event, Phase, Rejection, Window
from blastline.report.bode import BodeCurve, _measured_column
from blastline.report.choice import MAX_FIGURES, pictured
from blastline.report.figures import ShotPictures, _bands_hz, _centres, _shade
from blastline.report.overview import Overview, OverviewMeter
from blastline.report.sounds import envelope, event_sound, spectrum_db
from blastline.report.style import SERIES
from blastline.report.summary import heading, tiles, verdict, warnings
from blastline.report.tables import origin_list, rejections_table, shots_table
from blastline.report.track import film_track
from blastline.report.words import allowed, duration, figure, measured
from blastline.timecode import frame_scale, frame_time, timecode_at
from timelines import timeline


def figures_in(text: str) -> list[float]:
    return [float(found.replace("−", "-")) for found in re.findall(r"−?\d+(?:\.\d+)?", text)]


def many(count: int) -> tuple[Event, ...]:
    (event,) = make_film(onsets_s=(0.1,), peaks=(0.01,), seconds=0.5).timeline.events
    return tuple(
        msgspec.structs.replace(
            event, id=f"s{n:03d}", onset_sample=1000 * n, confidence=0.99 - 0.001 * (n % 50), peak_dbfs=-40.0 + 0.1 * n
        )
        for n in range(count)
    )


def test_few_shots_are_all_shown() -> None:
    events = many(MAX_FIGURES)
    assert list(pictured(events, ())) == [event.id for event in events]


def test_of_many_the_failed_the_unsure_and_the_strongest_are_shown() -> None:
    events = list(many(300))
    events[17] = msgspec.structs.replace(events[17], confidence=0.51)
    checks = (Check("peak", "s100", False, 2.0, 1.0, ""), Check("peak", "s200", True, 0.5, 1.0, ""))
    why = pictured(events, checks)
    assert len(why) == MAX_FIGURES
    assert why["s100"] == "a check failed"
    assert why["s017"] == "among the least sure"
    assert why["s299"] == "among the strongest"
    assert list(why) == sorted(why)


def test_failures_everywhere_still_leave_room_for_the_others() -> None:
    events = many(300)
    why = pictured(events, tuple(Check("peak", event.id, False, 2.0, 1.0, "") for event in events))
    assert set(why.values()) == {"a check failed", "among the least sure", "among the strongest"}
    assert len(why) == MAX_FIGURES


def test_of_many_some_that_were_set_by_hand_are_shown() -> None:
    events = list(many(300))
    events[100] = msgspec.structs.replace(events[100], origin="added", confidence=1.0)
    events[101] = msgspec.structs.replace(events[101], gain_db=-6.0)
    why = pictured(events, tuple(Check("peak", event.id, False, 2.0, 1.0, "") for event in events[150:]))
    assert why["s100"] == why["s101"] == "set by hand"
    assert set(why.values()) == {"a check failed", "set by hand", "among the least sure", "among the strongest"}
    assert len(why) == MAX_FIGURES
    all_set = [msgspec.structs.replace(event, origin="added") for event in events]
    assert set(pictured(all_set, ()).values()) == {"set by hand", "among the least sure", "among the strongest"}


@pytest.mark.parametrize("length", [1, 2, 50, 999, 1_259, 20_000])
@pytest.mark.parametrize("late", [0.0, 9.0])
def test_an_envelope_keeps_ends_and_extremes(length: int, late: float) -> None:
    values = np.random.default_rng(length).standard_normal(length)
    values[-2:-1] += late
    index, kept = envelope(values, 100)
    assert kept == pytest.approx(values[index.astype(int)])
    assert np.all(np.diff(index) > 0)
    assert kept.max() == values.max()
    if length >= 50:
        assert kept.min() == values.min()
    width = -(-length // 100)
    for first in range(0, length, width):
        seen, column = kept[(index >= first) & (index < first + width)], values[first : first + width]
        assert (seen.min(), seen.max()) == (column.min(), column.max()), "it looks the same in each column"
    assert (index[0], index[-1]) == (0, length - 1)
    assert len(kept) <= max(2 * 100 + 2, length if length <= 200 else 0)


def test_a_spectrum_has_parsevals_energy() -> None:
    rate_hz = 8000
    noise = np.random.default_rng(1).standard_normal(4000)
    edges_hz = np.linspace(0.0, rate_hz / 2, 41)
    density = 10.0 ** (spectrum_db(noise, rate_hz, edges_hz) / 10.0)
    energy = 2.0 * float(np.sum(density * np.diff(edges_hz)))
    assert energy == pytest.approx(float(np.sum(noise**2)) / rate_hz, rel=0.01)


@pytest.mark.parametrize("level_db", [0.0, -20.0])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_what_is_shown_as_felt_is_the_drive_through_the_response(phase: Phase, level_db: float) -> None:
    """And it follows what is shown as what should be felt, as nothing limits this drive."""
    film = make_film(onsets_s=(0.6,), peaks=(0.05,), seconds=1.5, phase=phase, level_db=level_db)
    timeline = msgspec.structs.replace(film.timeline, phase=phase, level_db=level_db)
    (event,) = timeline.events
    sound = event_sound(event, timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
    whole = dsp.run_filter(dsp.discretise(dsp.felt_response(PROFILE), 48_000), film.drive.samples)
    assert sound.felt_drive == pytest.approx(whole[sound.span.start : sound.span.stop], abs=1e-9)
    at_onset = int(np.argmin(np.abs(sound.times_ms)))
    assert sound.span.start + at_onset == event.onset_sample
    core = slice(at_onset, at_onset + 4800)
    assert sound.felt_drive[core] == pytest.approx(sound.target[core], abs=0.02 * np.abs(sound.target).max())


@pytest.mark.parametrize(("resonance_hz", "q"), [(20.0, 30.0), (8.0, 12.0), (60.0, 30.0)])
def test_what_a_seat_that_rings_on_still_feels_of_earlier_sound_is_shown(resonance_hz: float, q: float) -> None:
    """The felt curves are those of the whole film through the response, however long its poles ring."""
    w = 2.0 * np.pi * resonance_hz
    pole = (-w / (2.0 * q), w * np.sqrt(1.0 - 0.25 / q**2))
    response = msgspec.structs.replace(
        PROFILE.response, gain=w / q, zeros_rad_s=((-20.0, 0.0),), poles_rad_s=(pole, (pole[0], -pole[1]))
    )
    seat = msgspec.structs.replace(PROFILE, response=response)
    film = make_film(onsets_s=(11.0,), peaks=(0.1,), seconds=12.0, bed=0.1)
    (event,) = film.timeline.events
    drive = film.with_drive(np.clip(0.2 * np.random.default_rng(1).standard_normal(12 * 48_000), -1.0, 1.0)).drive
    sound = event_sound(event, film.timeline, audio=film.audio, drive=drive, profile=seat)
    felt = dsp.discretise(dsp.felt_response(seat), 48_000)
    for shown, played in ((sound.felt_drive, drive.samples), (sound.felt_direct, film.audio.samples)):
        whole = dsp.run_filter(felt, np.clip(played, -1.0, 1.0))[sound.span.start : sound.span.stop]
        assert shown == pytest.approx(whole, abs=1e-6 * np.max(np.abs(whole)))


def test_a_spectrum_is_drawn_where_its_bands_are() -> None:
    edges_hz, centres_hz = _bands_hz(), _centres()
    assert np.all((edges_hz[:-1] < centres_hz) & (centres_hz < edges_hz[1:]))


def test_equal_ratios_of_frequency_are_equally_far_apart_below_a_spectrum() -> None:
    film = make_film(onsets_s=(0.1,), peaks=(0.5,), seconds=0.5)
    sound = event_sound(film.timeline.events[0], film.timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
    ticks = re.findall(r'<text[^>]* x="([\d.]+)"[^>]*>(10|100|1k)</text>', ShotPictures().drawn(sound))[-3:]
    assert [said for _, said in ticks] == ["10", "100", "1k"]
    low, middle, high = (float(x) for x, _ in ticks)
    assert middle - low == pytest.approx(high - middle, abs=0.01)
    assert middle > low


@pytest.mark.parametrize("raised", [0.5, 1.0, 10.0])
def test_what_should_be_felt_fits_into_its_picture_however_far_it_is_raised(raised: float) -> None:
    film = make_film(onsets_s=(0.1,), peaks=(0.5,), seconds=0.5)
    sound = event_sound(film.timeline.events[0], film.timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
    pictures = ShotPictures()
    pictures.drawn(replace(sound, target=raised * sound.audio))
    for row in (0, 1, 3):
        low, high = pictures._grid[row][0].get_ylim()
        assert low < -raised * np.abs(sound.audio).max()
        assert high > raised * np.abs(sound.audio).max()


def test_the_wedge_below_a_shot_is_whole_between_its_fades_and_nothing_at_the_windows_ends() -> None:
    film = make_film(onsets_s=(0.1,), peaks=(0.5,), seconds=0.5)
    sound = event_sound(film.timeline.events[0], film.timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
    event, window = sound.event, sound.event.window
    assert window.fade_in_samples != window.fade_out_samples
    (wedge,) = (each for each in _shade(Figure().subplots(), sound) if isinstance(each, PolyCollection))
    corners = np.asarray(wedge.get_paths()[0].vertices, np.float64)
    shape = {
        window.start: 0.0,
        window.start + window.fade_in_samples: 1.0,
        window.stop - window.fade_out_samples: 1.0,
        window.stop: 0.0,
    }
    high = corners[:, 1].max()
    for sample, weight in shape.items():
        at_ms = 1000.0 * (sample - event.onset_sample) / sound.rate_hz
        assert np.interp(at_ms, *_outline(corners)) == pytest.approx(weight * high)
    assert corners[:, 0].min() == pytest.approx(1000.0 * (window.start - event.onset_sample) / sound.rate_hz)
    assert corners[:, 0].max() == pytest.approx(1000.0 * (window.stop - event.onset_sample) / sound.rate_hz)


def _outline(corners: NDArray[np.floating]) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Return the upper edge of a polygon: its times in order, and how high it is there."""
    times = np.unique(corners[:, 0])
    return times, np.array([corners[corners[:, 0] == time, 1].max() for time in times])


def test_a_measured_response_is_drawn_faintly_as_a_whole_and_in_full_where_it_is_known() -> None:
    frequencies_hz = np.geomspace(5.0, 2000.0, 50)
    level_db, phase_deg = -0.01 * frequencies_hz, -0.2 * frequencies_hz
    known = (frequencies_hz >= 20.0) & (frequencies_hz <= 500.0)
    curve = BodeCurve(frequencies_hz, level_db, phase_deg=phase_deg, band_hz=(20.0, 500.0))
    level, phase = Figure().subplots(2)
    _measured_column(curve, "direct")(level, phase)
    faint, full = level.get_lines()
    assert (faint.get_alpha() or 1.0) < (full.get_alpha() or 1.0)
    np.testing.assert_array_equal(faint.get_xydata(), np.column_stack([frequencies_hz, level_db]))
    np.testing.assert_array_equal(full.get_xydata(), np.column_stack([frequencies_hz, level_db])[known])
    (turning,) = phase.get_lines()
    np.testing.assert_array_equal(turning.get_xdata(), frequencies_hz[known])
    turns = (np.asarray(turning.get_ydata(), np.float64) - phase_deg[known]) / 360.0
    np.testing.assert_allclose(turns, round(turns[0]), atol=1e-9)
    assert faint.get_color() == full.get_color() == turning.get_color() == SERIES["direct"]


def test_a_picture_does_not_depend_on_those_before_it() -> None:
    """All shots are drawn on one set of axes: nothing of a louder, longer or more crowded one may be left on it."""
    film = make_film(onsets_s=(0.6, 0.68, 1.4), peaks=(0.05, 0.9, 0.2), seconds=2.5)
    sounds = [
        event_sound(event, film.timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
        for event in film.timeline.events
    ]
    draw = ShotPictures()
    assert [draw.drawn(sound) for sound in sounds] == [ShotPictures().drawn(sound) for sound in sounds]


def test_a_window_of_the_films_first_sample_is_drawn_without_a_warning() -> None:
    film = make_film(onsets_s=(0.0,), peaks=(0.5,), seconds=1.0)
    (event,) = film.timeline.events
    event = msgspec.structs.replace(event, window=Window(0, 1, 0, 0))
    sound = event_sound(event, film.timeline, audio=film.audio, drive=film.drive, profile=PROFILE)
    assert len(sound.drive) == 1
    assert ShotPictures().drawn(sound).startswith("<svg")


def test_marks_lie_where_the_shots_are() -> None:
    film = make_film()
    overview = Overview(960, np.full(300, 0.1, np.float32))
    svg = film_track(film.timeline, overview, failed={"shot-0002"}, linked={"shot-0001"})
    assert svg.count("<a ") == len(film.timeline.events)
    assert 'href="#shot-shot-0001"' in svg
    assert 'href="#row-shot-0002"' in svg
    [failed] = [mark for mark in svg.split("<a ")[1:] if "a check failed" in mark]
    assert ("shot-0002" in failed, "l10 10m0 -10l-10 10" in failed, "<circle" in failed) == (True, True, False)
    assert svg.count("<circle") == len(film.timeline.events) - 1, "all others are discs"
    assert "01:00:05" in svg


@pytest.mark.parametrize(("shots", "told"), [(0, "0 shots"), (1, "1 shot"), (2, "2 shots")])
def test_the_overview_is_read_out_with_its_shots_counted(shots: int, told: str) -> None:
    timeline = make_film().timeline
    timeline = msgspec.structs.replace(timeline, events=timeline.events[:shots])
    svg = film_track(timeline, Overview(960, np.full(300, 0.1, np.float32)), failed=(), linked=())
    assert f'aria-label="The film from start to end: its level, and {told}"' in svg


def test_a_burst_of_which_one_shot_is_left_has_one_shot() -> None:
    timeline = make_film().timeline
    event = msgspec.structs.replace(timeline.events[0], burst=3, shot_in_burst=0)
    timeline = msgspec.structs.replace(timeline, events=(event,))
    svg = film_track(timeline, Overview(960, np.full(300, 0.1, np.float32)), failed=(), linked=())
    assert "<title>Burst 3: 1 shot</title>" in svg


def test_a_film_without_shots_is_not_said_to_rest_where_its_sound_plays_on() -> None:
    timeline = msgspec.structs.replace(make_film(onsets_s=(0.1,), peaks=(0.01,), seconds=0.5).timeline, events=())
    for name, said in (
        ("silence_outside_windows", "the drive is at rest from start to end"),
        ("sound_outside_windows", "the drive is the film's own sound from start to end"),
    ):
        checked = msgspec.structs.replace(timeline, checks=(Check(name, None, True, 0.0, 0.0, "samples"),))
        assert said in verdict(checked)


@pytest.mark.parametrize("at_s", [0.71239, 59.97, 754.80321, 14_399.96])
def test_what_was_nearly_a_shot_can_be_added_at_the_time_that_the_page_tells(at_s: float) -> None:
    """Who types it puts the event on the sound that was turned down, however long the film: within a millisecond."""
    source = make_film(onsets_s=(0.1,), peaks=(0.01,), seconds=0.5).timeline.source
    turned_down = Rejection(round(at_s * source.sample_rate_hz), "below the threshold", {"probability": 0.4})
    [(timecode, told_s)] = re.findall(
        r">([\d:;]+), ([\d.]+) s \(probability 0.4\)<", rejections_table([turned_down], source)
    )
    assert abs(float(told_s) - turned_down.at_sample / source.sample_rate_hz) < 0.001
    assert timecode == timecode_at(source, turned_down.at_sample)


@pytest.mark.parametrize(
    ("count", "told"), [(0, "0 samples"), (1, "1 sample"), (-1, "\N{MINUS SIGN}1 sample"), (2, "2 samples")]
)
def test_one_sample_is_no_samples(count: int, told: str) -> None:
    assert measured(Check("drive_shift", None, False, count, 1.0, "samples")) == told
    assert "1 sample " in allowed(Check("drive_shift", None, False, count, 1.0, "samples"))


@pytest.mark.parametrize(("excess", "told"), [(0, "as many as the film"), (3, "3 more than"), (-5, "5 fewer than")])
def test_frames_are_told_as_a_difference(excess: int, told: str) -> None:
    check = Check("frames", None, excess == 0, excess, 0.0, "frames")
    assert told in measured(check)
    assert allowed(check) == "exactly as many"


@pytest.mark.parametrize(
    ("name", "unit", "limit", "text"),
    [
        ("lag_as_rendered", "ms", 0.1, "up to 0.1 ms either way"),
        ("level_as_rendered", "dB", 0.5, "up to 0.5 dB either way"),
        ("peak_as_rendered", "dB", 0.5, "up to 0.5 dB either way"),
        ("drive_shift", "samples", 0.5, "up to 0.5 samples either way"),
        ("felt_lag", "ms", 0.5, "up to 0.5 ms either way"),
        ("felt_onset", "ms", 1.0, "up to 1 ms late, up to that and the lead of the drive early"),
        ("drive_speed", "ratio", 1.0000087, "from 0.9999913 to 1.0000087"),
        ("drive_peak", "of the limit", 1.0, "up to 1 of the limit"),
    ],
)
def test_a_figure_that_fails_below_is_not_said_to_be_allowed(name: str, unit: str, limit: float, text: str) -> None:
    """A drive of half its level is 6 dB short: it must not read "-6 dB, up to 1.5 dB"."""
    assert allowed(Check(name, None, False, -6.0, limit, unit)) == text


@pytest.mark.parametrize(
    ("name", "unit", "value", "limit"),
    [
        ("felt_lag", "ms", 0.5004, 0.5),
        ("felt_lag", "ms", -0.50001, 0.5),
        ("drive_peak", "of the limit", 1.0000004, 1.0),
        ("felt_correlation", "", 0.89996, 0.9),
        ("pre_echo", "dB", -39.9999, -40.0),
        ("level_as_rendered", "dB", 1.23464, 1.23456),
        ("drive_speed", "ratio", 1.00000871, 1.0000087),
        ("drive_speed", "ratio", 0.99999129, 1.0000087),
    ],
)
def test_a_figure_that_just_fails_reads_as_one_that_fails(name: str, unit: str, value: float, limit: float) -> None:
    """What is beyond a limit must not be rounded to it: "0.5 ms, up to 0.5 ms either way" is no failure."""
    check = Check(name, None, False, value, limit, unit)
    said, bounds = figures_in(measured(check)), figures_in(allowed(check))
    assert (value > limit) == (said[0] > bounds[-1])
    assert all(abs(said[0]) != abs(bound) for bound in bounds)
    assert measured(msgspec.structs.replace(check, passed=True)) == measured(
        msgspec.structs.replace(check, passed=True, limit=None)
    )


@pytest.mark.parametrize("length_s", [1, 60, 420, 7200, 24 * 3600])
def test_the_speeds_that_a_film_of_any_length_allows_are_told_from_one(length_s: int) -> None:
    """Half a sample of two hours is 1 in 10^9: "from 1 to 1" would allow nothing."""
    limit = 1.0 + 0.5 / (48_000 * length_s)
    low, high = figures_in(allowed(Check("drive_speed", None, True, 1.0, limit, "ratio")))
    assert high - 1.0 == pytest.approx(limit - 1.0, rel=0.1)
    assert 1.0 - low == pytest.approx(limit - 1.0, rel=0.1)


@pytest.mark.parametrize(("count", "told"), [(1, "1 channel"), (2, "2 channels")])
def test_the_head_of_the_page_and_its_end_tell_the_channels_alike(count: int, told: str) -> None:
    film = make_film(onsets_s=(0.1,), peaks=(0.01,), seconds=0.5).timeline
    film = msgspec.structs.replace(film, source=msgspec.structs.replace(film.source, channels=count))
    for text in (heading(film), origin_list(film, {})):
        assert re.findall(r"\d+ channels?", text) == [told]


@pytest.mark.parametrize(
    ("rate", "start", "told"),
    [
        ("24000/1001", "10:00:00:00", "23.976 frames a second"),
        ("60000/1001", "10:00:00:00", "59.94 frames a second"),
        ("30000/1001", "10:00:00;00", "29.97 frames a second, drop-frame"),
        ("25", None, "25 frames a second"),
        ("27/2", None, "13.5 frames a second"),
    ],
)
def test_the_head_of_the_page_calls_a_rate_as_people_do(rate: str, start: str | None, told: str) -> None:
    film = make_film(onsets_s=(0.1,), peaks=(0.01,), seconds=0.5).timeline
    source = msgspec.structs.replace(film.source, frame_rate=rate, start_timecode=start)
    assert told in re.split(" · |<", heading(msgspec.structs.replace(film, source=source)))


@pytest.mark.parametrize("seconds", [0.0, 9.96, 59.949, 59.951, 59.99, 60.0, 60.4, 119.6, 3599.7, 14_400.2])
def test_a_duration_is_the_nearest_of_its_kind(seconds: float) -> None:
    said = duration(seconds)
    if " s" in said:
        assert abs(float(said.removesuffix(" s")) - seconds) <= 0.0500001
        assert float(said.removesuffix(" s")) < 60.0
    else:
        hours, minutes, whole = (int(part) for part in said.split(":"))
        assert abs(3600 * hours + 60 * minutes + whole - seconds) <= 0.5
        assert minutes < 60
        assert whole < 60


def test_what_had_to_be_mended_is_told_and_nothing_is_where_nothing_was() -> None:
    film = timeline()
    assert (film.source.warnings, warnings(film)) == ((), "")
    lost = ("2 packets lost", "3 samples were not numbers")
    told = warnings(msgspec.structs.replace(film, source=msgspec.structs.replace(film.source, warnings=lost)))
    assert re.findall("<li>(.*?)</li>", told) == [*lost]
    assert "The film was not read without trouble." in told


def test_a_table_of_shots_has_a_column_for_where_they_come_from_where_any_tells() -> None:
    shot, other = timeline().events
    assert (shot.azimuth_deg, other.azimuth_deg) == (-29.7, None)
    for events, told in (((shot, other), ["\u221230", "–"]), ((other,), [])):
        table = shots_table(events, failed={}, linked=())
        heads = re.findall(r"<th [^>]*>(.*?)</th>", table)
        rows = [re.findall(r"<td [^>]*>(.*?)</td>", row) for row in table.split("<tr ")[1:]]
        assert [len(row) for row in rows] == [len(heads)] * len(events)
        assert [row[heads.index("Azimuth,&nbsp;°")] for row in rows if told] == told


@pytest.mark.parametrize("rate_hz", [8_000, 48_000])
@pytest.mark.parametrize("block", [1_000, 100_000])
def test_the_level_of_a_film_is_kept_for_every_20_ms_whatever_its_rate_and_its_blocks(rate_hz: int, block: int) -> None:
    samples = np.random.default_rng(2).uniform(-1.0, 1.0, 2 * rate_hz).astype(np.float32)
    meter = OverviewMeter(rate_hz)
    for _ in meter.watch(Clip(samples[at : at + block, None], rate_hz, at) for at in range(0, len(samples), block)):
        pass
    assert meter.overview().columns(100) == pytest.approx(np.abs(samples).reshape(100, -1).max(axis=1))
    assert meter.overview().step == rate_hz // 50
    assert len(meter.overview().peaks) == 100


def seconds_in(said: str) -> float:
    return sum(float(part) * 60.0**n for n, part in enumerate(reversed(said.removesuffix(" s").split(":"))))


@pytest.mark.parametrize("length_s", [0.5, 4.0, 47.0, 600.0, 7200.0, 20_000.0])
def test_times_below_the_film_are_few_and_stand_where_they_are(length_s: float) -> None:
    source = msgspec.structs.replace(timeline().source, frames=round(length_s * 48_000), start_timecode=None)
    film = msgspec.structs.replace(timeline(), source=source, events=())
    svg = film_track(film, Overview(960, np.zeros(0, np.float32)), failed=(), linked=())
    left, right = (float(edge) for edge in re.findall(r'<line x1="([\d.]+)" x2="([\d.]+)"', svg)[0])
    times = re.findall(r'<text x="([\d.]+)"[^>]*text-anchor="(?:start|middle)"[^>]*>([^<]*)', svg)
    assert re.findall(r'text-anchor="end"[^>]*>([^<]*)', svg) == ["0 dB", "−20", "−40", "−60"]
    assert 3 <= len(times) <= 11
    assert {place for place, _ in times} <= {
        x for x, end in re.findall(r'<line x1="([\d.]+)" x2="([\d.]+)"', svg) if x == end
    }
    for place, said in times:
        assert float(place) == pytest.approx(left + (right - left) * seconds_in(said) / length_s, abs=0.06)


@pytest.mark.parametrize("length_s", [12.0, 95.0, 1300.0])
@pytest.mark.parametrize(
    ("rate", "start", "offset_s"),
    [
        ("24000/1001", "01:00:00:00", 0.0),
        ("24000/1001", "00:59:58:10", 0.015),
        ("25", "23:59:53:00", -0.015),
        ("30000/1001", "00:08:58;02", 0.0),
        ("60000/1001", "23:59:00;00", 0.0),
        ("30000/1001", "01:00:00:00", 0.0),
    ],
)
def test_times_below_a_film_with_timecode_are_round_and_stand_at_their_first_frame(
    rate: str, start: str, offset_s: float, length_s: float
) -> None:
    told = {"start_timecode": start, "frame_rate": rate, "start_offset_s": offset_s}
    source = msgspec.structs.replace(timeline().source, frames=round(length_s * 48_000), **told)
    film = msgspec.structs.replace(timeline(), source=source, events=())
    svg = film_track(film, Overview(960, np.zeros(0, np.float32)), failed=(), linked=())
    left, right = (float(edge) for edge in re.findall(r'<line x1="([\d.]+)" x2="([\d.]+)"', svg)[0])
    times = re.findall(r'<text x="([\d.]+)"[^>]*text-anchor="(?:start|middle)"[^>]*>([^<]*)', svg)
    step_s = (seconds_in(times[1][1]) - seconds_in(times[0][1])) % 86_400
    assert 3 <= len(times) <= 11
    # another way: the label of every frame of the film, and where its second is another than that before
    scale = frame_scale(source)
    assert scale is not None
    first, last = (frame_time(source, sample, scale).frame for sample in (0, source.frames))
    labels = {frame: scale.label(frame)[:8] for frame in range(first - 1, last + 1)}
    starts = [n for n in range(first, last + 1) if labels[n] != labels[n - 1] and seconds_in(labels[n]) % step_s == 0]
    assert [said for _, said in times] == [labels[frame] for frame in starts[: len(times)]]
    assert len(starts) - len(times) <= 1  # that at the very end has no room
    for (place, _), frame in zip(times, starts, strict=False):
        elapsed_s = float((frame - scale.start) / scale.rate) - offset_s
        assert float(place) == pytest.approx(left + (right - left) * max(0.0, elapsed_s) / length_s, abs=0.06)


def test_what_has_no_figure_is_said_to_be_missing_where_that_fails_and_not_needed_where_it_passes() -> None:
    failed, passed = (measured(Check("felt_lag", "shot-0001", good, None, 0.5, "ms")) for good in (False, True))
    assert (failed, passed) == ("could not be measured", "nothing to measure")


@pytest.mark.parametrize("singles", [0, 1, 3])
@pytest.mark.parametrize("bursts", [0, 1, 2])
def test_the_key_figures_count_shots_alone_and_bursts(singles: int, bursts: int) -> None:
    numbers = [None] * singles + [number for number in range(1, bursts + 1) for _ in range(3)]
    events = tuple(
        msgspec.structs.replace(timeline().events[1], id=f"s{n}", burst=burst) for n, burst in enumerate(numbers)
    )
    [(count, said)] = re.findall(
        r"<dt>Shots</dt><dd>(\d+)<small>(.*?)</small>", tiles(msgspec.structs.replace(timeline(), events=events))
    )
    assert int(count) == singles + 3 * bursts
    assert figures_in(said) == ([singles, bursts] if bursts else [])
    assert ("bursts" in said) == (bursts > 1)


@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), -float("inf")])
def test_what_is_no_number_is_a_dash(value: float | None) -> None:
    assert figure(value) == "–"


def test_what_was_nearly_a_shot_stands_beside_the_reason_that_it_was_turned_down_for() -> None:
    reasons = ("below the threshold", "an echo", "below the threshold", "in a loop", "an echo", "an echo")
    rejections = [Rejection(48_000 * n, reason, {"probability": 0.1 * n}) for n, reason in enumerate(reasons)]
    table = rejections_table(rejections, timeline().source)
    rows = re.findall(r"<tr><td>(.*?)</td><td[^>]*>(\d+)</td><td[^>]*>(.*?)</td>", table)
    assert {why: int(count) for why, count, _ in rows} == {why: reasons.count(why) for why in reasons}
    for why, _, shown in rows:
        places = [float(at_s) for at_s in re.findall(r"([\d.]+) s \(", shown)]
        own = [n for n, reason in enumerate(reasons) if reason == why]
        assert places == sorted(own, reverse=True)[: len(places)]
        assert len(places) >= min(3, len(own))
