"""From a film whose channels play against each other to its drive: what the mix cancels is found, felt and checked."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.detect import find_shots, verifier_of
from blastline.errors import TimelineError
from blastline.model import Clip, Quality, Timeline, encode
from blastline.render import choose_made_of
from blastline.ruleset import load_rules
from blastline.run import RenderOptions
from blastline.soundtrack import open_soundtrack
from media import write_media
from sides_films import RATE_HZ, Samples, three_shots, written

RULES = load_rules("standard")


@pytest.fixture(scope="module")
def shots() -> Samples:
    return three_shots()


@pytest.fixture(scope="module")
def beyond(shots: Samples, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a film whose channels play the shots against each other, rendered, over what both play."""
    folder = tmp_path_factory.mktemp("against")
    middle = 0.002 * np.random.default_rng(1).standard_normal(len(shots))
    written(folder / "film.wav", [middle + shots, middle - shots])
    run.render(folder / "film.wav", folder / "out", RenderOptions(report=False))
    return folder


def timeline_of(folder: Path) -> Timeline:
    return msgspec.json.decode((folder / "timeline.json").read_bytes(), type=Timeline)


def drive_of(folder: Path) -> Samples:
    return np.asarray(soundfile.read(folder / "drive.wav")[0], np.float64)


def test_shots_that_cancel_in_the_mix_drive_as_they_do_by_themselves(
    beyond: Path, shots: Samples, tmp_path: Path
) -> None:
    alone = run.render(written(tmp_path / "alone.wav", [shots]), tmp_path / "out", RenderOptions(report=False))
    here = timeline_of(beyond / "out")
    assert len(here.events) == 3
    there = [event for event in alone.events if event.onset_sample in {e.onset_sample for e in here.events}]
    assert [event.peak_dbfs for event in here.events] == pytest.approx([e.peak_dbfs for e in there], abs=1e-4)
    for event in here.events:
        assert event.heard_in == "sides"
        assert event.drive is not None
        assert event.drive.made_of == "sides"
    assert all(check.passed for check in here.checks)
    made, expected = drive_of(beyond / "out"), drive_of(tmp_path / "out")
    for event in here.events:
        window = slice(event.window.start, event.window.stop)
        np.testing.assert_allclose(made[window], expected[window], atol=2e-5)


def test_the_checks_hold_the_drive_to_the_mix_that_it_is_made_of(beyond: Path) -> None:
    out = beyond / "out"
    found = timeline_of(out)
    events = [
        msgspec.structs.replace(e, drive=msgspec.structs.replace(e.drive, made_of="mains")) if e.drive else e
        for e in found.events
    ]
    claimed = out / "claimed.json"
    claimed.write_bytes(encode(msgspec.structs.replace(found, events=tuple(events))))
    again = run.check(out, audio=beyond / "film.wav")
    wrong = run.check(claimed, audio=beyond / "film.wav", drive=out / "drive.wav")
    assert all(check.passed for check in again.checks)
    assert not all(check.passed for check in wrong.checks)


def test_a_film_that_is_decoded_once_is_driven_like_a_file_of_samples(beyond: Path, tmp_path: Path) -> None:
    samples = np.round(soundfile.read(beyond / "film.wav")[0] * 32_768.0) / 32_768.0
    soundfile.write(tmp_path / "film.wav", samples, RATE_HZ, subtype="PCM_16")
    coded = write_media(tmp_path / "film.mkv", [samples.astype(np.float32)], codec="flac")
    for path in (tmp_path / "film.wav", coded):
        run.render(path, tmp_path / path.suffix[1:], RenderOptions(report=False))
    np.testing.assert_array_equal(drive_of(tmp_path / "mkv"), drive_of(tmp_path / "wav"))
    assert {event.heard_in for event in timeline_of(tmp_path / "mkv").events} == {"sides"}
    assert all(check.passed for check in run.check(tmp_path / "mkv", audio=coded).checks)


@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_a_shot_that_is_moved_by_hand_stays_in_the_sides(beyond: Path, tmp_path: Path, quality: Quality) -> None:
    found = timeline_of(beyond / "out")
    plain = msgspec.to_builtins(found)
    plain["events"][1]["onset_sample"] += 96
    plain["events"][1]["onset_s"] += 0.002
    edited = tmp_path / "edited.json"
    edited.write_bytes(msgspec.json.encode(plain))
    options = RenderOptions(report=False, timeline=edited, original=beyond / "out" / "timeline.json", quality=quality)
    made = run.render(beyond / "film.wav", tmp_path / "out", options)
    assert [event.origin for event in made.events] == ["found", "moved", "found"]
    assert {event.heard_in for event in made.events} == {"sides"}
    moved = made.events[1].window
    assert np.abs(drive_of(tmp_path / "out")[moved.start : moved.stop]).max() > 0.1
    assert made.events[1].peak_dbfs == pytest.approx(found.events[1].peak_dbfs, abs=1.0)


def test_a_shot_of_the_mains_that_is_moved_by_hand_stays_in_the_mains(shots: Samples, tmp_path: Path) -> None:
    """Also where it stands out more in the sides: it was found, or set, in what all the loudspeakers play."""
    middle = 0.01 * np.random.default_rng(1).standard_normal(len(shots))
    path = written(tmp_path / "film.wav", [middle + shots, middle - 0.2 * shots])
    onsets, table, made = [round(at_s * RATE_HZ) for at_s in (2.0, 5.5, 9.0)], tmp_path / "hand.csv", []
    for late in (0, 96):
        table.write_text("\n".join(["id,onset_sample", *(f"{n},{onset + late}" for n, onset in enumerate(onsets))]))
        options = RenderOptions(report=False, quality="draft", timeline=table, overwrite=True)
        before = replace(options, original=tmp_path / "before.json") if late else options
        made.append(run.render(path, tmp_path / "out", before))
        (tmp_path / "before.json").write_bytes(encode(made[-1]))
    assert [[event.onset_sample for event in each.events] for each in made] == [onsets, [at + 96 for at in onsets]]
    assert [{event.heard_in for event in each.events} for each in made] == [{"mains"}, {"mains"}]


def test_who_names_the_low_channel_gets_the_low_channel(shots: Samples, tmp_path: Path) -> None:
    voice = 0.2 * np.random.default_rng(2).standard_normal(len(shots)).clip(-3.0, 3.0)
    none = np.zeros_like(shots)
    path = written(tmp_path / "film.wav", [shots, none, voice, 0.1 * shots, none, none])
    made = run.render(path, tmp_path / "out", RenderOptions(report=False, mix="lfe"))
    assert "sides" in {event.heard_in for event in made.events}
    assert {event.drive.made_of for event in made.events if event.drive} == {"mains"}


def test_what_is_left_beside_the_middle_far_under_it_changes_nothing(shots: Samples) -> None:
    """A mixer's balance that is off by 0.1 dB leaves a copy at -45 dB in the sides."""
    verifier = verifier_of(RULES.tier)
    heard = shots.astype(np.float32)[:, None]
    for sides in (np.zeros_like(heard), np.float32(0.006) * heard):
        clip = Clip(heard, RATE_HZ, sides=sides[:, 0])
        beside = find_shots([clip], rate_hz=RATE_HZ, tier=RULES.tier, verifier=verifier)
        assert beside == find_shots([Clip(heard, RATE_HZ)], rate_hz=RATE_HZ, tier=RULES.tier, verifier=verifier)
        assert beside.shots


def shots_at(places: Sequence[int], frames: int = 48_000) -> Samples:
    """Return decaying swings at 200 Hz from some samples on."""
    samples, time_s = np.zeros(frames), np.arange(9_600) / RATE_HZ
    for at in places:
        samples[at : at + 9_600] += 0.5 * np.sin(2.0 * np.pi * 200.0 * time_s) * np.exp(-time_s / 0.03)
    return samples


def clip_of(left: Samples, right: Samples) -> Clip:
    return Clip(0.5 * (left + right)[:, None], RATE_HZ, 500, sides=0.5 * (left - right))


def test_a_window_is_made_of_the_mains_unless_they_lack_a_shot() -> None:
    here, there = shots_at([12_000]), shots_at([30_000])
    voice = 0.2 * np.convolve(np.random.default_rng(3).standard_normal(len(here)), np.full(48, 1.0 / 7.0), "same")
    first, second = 12_500, 30_500
    for bed in (0.0 * voice, voice):
        pairs = (here, -here), (here, here), (0.0 * here, here)
        against, both, aside = (clip_of(bed + left, bed + right) for left, right in pairs)
        assert choose_made_of(against, [first]) == "sides"
        assert choose_made_of(both, [first]) == choose_made_of(aside, [first]) == "mains"
        mixed = clip_of(bed + here + there, bed - here + there)
        assert choose_made_of(mixed, [first, second]) in ("left", "right")
        lopsided = clip_of(bed + here, bed - here + there)
        assert choose_made_of(lopsided, [first, second]) == "right"
    assert choose_made_of(Clip(here[:, None], RATE_HZ, 500), [first]) == "mains"
    assert choose_made_of(Clip(np.zeros((48_000, 2)), RATE_HZ, 500, sides=here), [first]) == "mains"


@pytest.mark.parametrize("onset", [0, 1, 10, 23, 24, 25, 12_000])
@pytest.mark.parametrize("constant", [(0.0, 0.0), (0.3, 0.3), (-0.3, 0.0), (0.2, -0.2)])
def test_a_constant_does_not_change_what_a_window_is_made_of(onset: int, constant: tuple[float, float]) -> None:
    """However little of the film is before the shot to tell it by."""
    swing = shots_at([onset])
    for right, expected in ((-swing, "sides"), (swing, "mains")):
        clip = clip_of(constant[0] + swing, constant[1] + right)
        assert choose_made_of(clip, [clip.start + onset]) == expected


@pytest.mark.parametrize("onset", [192, 320, 500, 960, 12_000])
def test_a_hum_does_not_change_what_a_window_is_made_of(onset: int) -> None:
    """However little of the film is before the shot to tell by how much is the hum's."""
    hum = 0.4 * np.sin(2.0 * np.pi * 500.0 * np.arange(48_000) / RATE_HZ)
    swing = shots_at([onset])
    for right, expected in ((-swing, "sides"), (swing, "mains")):
        clip = clip_of(hum + swing, hum + right)
        assert choose_made_of(clip, [clip.start + onset]) == expected


def test_a_shot_that_is_wide_keeps_the_body_that_the_mains_hold() -> None:
    """Its highs are in antiphase, and loud; what is felt is its lows, and these are in the middle."""
    body = shots_at([12_000])
    rng = np.random.default_rng(4)
    crack = np.zeros_like(body)
    crack[12_000:12_960] = np.diff(rng.standard_normal(961)) * np.exp(-np.arange(960) / 200.0)
    wide = clip_of(0.3 * body + crack, 0.3 * body - crack)
    assert wide.sides is not None
    assert np.abs(wide.sides).max() > 2.0 * np.abs(wide.heard).max()
    assert choose_made_of(wide, [12_500]) == "mains"


def test_one_channel_of_a_pair_is_the_mains_with_or_without_the_sides() -> None:
    left, right = np.random.default_rng(5).uniform(-1.0, 1.0, (2, 100))
    clip = clip_of(left, right)
    np.testing.assert_allclose(clip.driving_of("left"), left, atol=1e-15)
    np.testing.assert_allclose(clip.driving_of("right"), right, atol=1e-15)
    with pytest.raises(ValueError, match="needs a clip with sides"):
        Clip(left[:, None], RATE_HZ).driving_of("sides")


def test_a_film_keeps_its_own_sound_beside_a_window_that_is_made_of_the_sides(shots: Samples, tmp_path: Path) -> None:
    hum = 0.1 * np.sin(2.0 * np.pi * 100.0 / RATE_HZ * np.arange(len(shots)))
    film = written(tmp_path / "film.wav", [hum + shots, hum - shots])
    made = run.render(film, tmp_path / "out", RenderOptions(report=False, background="direct"))
    drive = drive_of(tmp_path / "out")
    assert {event.drive.made_of for event in made.events if event.drive} == {"sides"}
    assert all(check.passed for check in made.checks)
    for event in made.events:
        start = event.window.start
        np.testing.assert_allclose(drive[start - 50 : start + 5], hum[start - 50 : start + 5], atol=1e-3)


def test_what_somebody_adds_where_the_channels_cancel_is_felt(beyond: Path, tmp_path: Path) -> None:
    """Without its original, a table is all that is known: each of its rows is new."""
    table = tmp_path / "events.csv"
    table.write_bytes((beyond / "out" / "timeline.csv").read_bytes())
    made = run.render(beyond / "film.wav", tmp_path / "out", RenderOptions(report=False, timeline=table))
    found = timeline_of(beyond / "out")
    assert [event.heard_in for event in made.events] == ["sides"] * 3
    assert [e.peak_dbfs for e in made.events] == pytest.approx([e.peak_dbfs for e in found.events], abs=0.1)
    drive = drive_of(tmp_path / "out")
    for event in made.events:
        assert np.abs(drive[event.window.start : event.window.stop]).max() > 0.5


def test_a_film_without_two_channels_is_not_what_such_a_drive_was_made_of(
    beyond: Path, shots: Samples, tmp_path: Path
) -> None:
    alone = written(tmp_path / "alone.wav", [shots])
    with pytest.raises(TimelineError, match=r"alone\.wav: .*the drive of shot-0001 .*'sides'"):
        run.check(beyond / "out", audio=alone)


@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_a_pair_drives_alike_from_every_container_and_again_from_its_timeline(
    beyond: Path, tmp_path: Path, quality: Quality
) -> None:
    samples, _ = soundfile.read(beyond / "film.wav")
    soundfile.write(tmp_path / "film.flac", samples, RATE_HZ, subtype="PCM_24")
    found = timeline_of(beyond / "out")
    for film, folder in ((beyond / "film.wav", "wav"), (tmp_path / "film.flac", "flac")):
        (tmp_path / "edited.csv").write_text("onset_s\n" + "".join(f"{event.onset_s}\n" for event in found.events))
        options = RenderOptions(report=False, timeline=tmp_path / "edited.csv", quality=quality)
        run.render(film, tmp_path / folder, options)
        again = RenderOptions(report=False, timeline=tmp_path / folder / "timeline.json", quality=quality)
        run.render(film, tmp_path / f"{folder} again", again)
        np.testing.assert_array_equal(drive_of(tmp_path / f"{folder} again"), drive_of(tmp_path / folder))
    np.testing.assert_array_equal(drive_of(tmp_path / "flac"), drive_of(tmp_path / "wav"))


def test_an_untouched_timeline_of_a_compressed_pair_drives_as_it_did_in_draft(
    beyond: Path, shots: Samples, tmp_path: Path
) -> None:
    film = tmp_path / "film.flac"
    soundfile.write(film, np.stack([shots, -0.4 * shots], axis=1), RATE_HZ, subtype="PCM_24")
    made = run.render(film, tmp_path / "out", RenderOptions(report=False, quality="draft"))
    assert made.events
    edited = RenderOptions(report=False, quality="draft", timeline=tmp_path / "out" / "timeline.json")
    run.render(film, tmp_path / "again", edited)
    np.testing.assert_array_equal(drive_of(tmp_path / "again"), drive_of(tmp_path / "out"))


def test_a_moved_shot_of_compressed_sides_is_measured_in_them(shots: Samples, tmp_path: Path) -> None:
    voice = 0.2 * np.random.default_rng(2).standard_normal(len(shots)).clip(-3.0, 3.0)
    none = np.zeros_like(shots)
    made = {}
    for name in ("film.wav", "film.flac"):
        soundfile.write(
            tmp_path / name, np.stack([0.3 * shots, none, voice, none, none, none], axis=1), RATE_HZ, subtype="PCM_24"
        )
        found = run.detect(tmp_path / name)
        aside = [event for event in found.events if event.heard_in == "sides"]
        assert aside
        plain = msgspec.to_builtins(found)
        for event in plain["events"]:
            event["onset_sample"], event["onset_s"] = event["onset_sample"] + 48, event["onset_s"] + 0.001
        (tmp_path / "edited.json").write_bytes(msgspec.json.encode(plain))
        options = RenderOptions(report=False, timeline=tmp_path / "edited.json", overwrite=True)
        made[name] = run.render(tmp_path / name, tmp_path / "out", options)
    for one, other in zip(made["film.wav"].events, made["film.flac"].events, strict=True):
        assert one.heard_in == other.heard_in
        assert other.peak_dbfs == pytest.approx(one.peak_dbfs, abs=0.01)
        assert other.window == one.window


def test_a_timeline_of_another_mix_is_refused_with_the_way_to_give_it(beyond: Path, tmp_path: Path) -> None:
    timeline = beyond / "out" / "timeline.json"
    with pytest.raises(TimelineError, match="give --mix mains"):
        run.render(beyond / "film.wav", tmp_path / "out", RenderOptions(report=False, timeline=timeline, mix="0"))
    driven = RenderOptions(report=False, timeline=timeline, mix="all")
    assert run.render(beyond / "film.wav", tmp_path / "out", driven).events


def test_listening_alone_keeps_nothing_of_a_compressed_film(beyond: Path, tmp_path: Path) -> None:
    samples, _ = soundfile.read(beyond / "film.wav")
    soundfile.write(tmp_path / "film.flac", samples, RATE_HZ, subtype="PCM_24")
    with open_soundtrack(tmp_path / "film.flac", rereadable=False, spool_folder=tmp_path / "nowhere") as track:
        assert sum(len(block.span) for block in track.blocks()) == len(samples)
