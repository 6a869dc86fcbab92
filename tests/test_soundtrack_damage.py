"""Damage inside a film: what follows it is not shifted, and what is lost is told."""

import re
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import soundfile

from blastline.errors import SoundtrackError
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.decode import Tally, _frames
from blastline.soundtrack.dropouts import Dropouts
from blastline.soundtrack.facts import origin_of
from coded_films import FILM_RATE, LONG, LONG_SHOTS, damaged, read, shots_in_film
from media import RATE_HZ, impulses, onsets, write_media


@pytest.mark.parametrize(("codec", "kind"), [("ac3", 0xBD), ("aac", 0xC0)])
@pytest.mark.parametrize("stamp", [2**33 - 480, 5 * 90_000])
def test_a_wild_first_time_stamp_moves_nothing(tmp_path: Path, codec: str, kind: int, stamp: int) -> None:
    path = tmp_path / "film.ts"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, picture_rate=FILM_RATE, audio_delay_s=0.5)
    data = bytearray(path.read_bytes())
    place = data.index(bytes([0, 0, 1, kind])) + 9
    parts = stamp >> 30 << 33 | (stamp >> 15 & 0x7FFF) << 17 | (stamp & 0x7FFF) << 1
    data[place : place + 5] = (0x21_0001_0001 | parts).to_bytes(5, "big")  # with the marks between the parts
    path.write_bytes(data)
    with open_soundtrack(path) as track:
        assert len(track.read_approximately(5.0, 1.0)) >= RATE_HZ
    samples, source = read(path)
    expected = [shot + 0.5 * RATE_HZ for shot in LONG_SHOTS]
    np.testing.assert_allclose(shots_in_film(samples, source), expected, atol=48)
    (warning,) = source.warnings
    assert warning.endswith(" s off those that follow; these were believed")


@pytest.mark.parametrize(("codec", "extension"), [("flac", "flac"), ("flac", "mkv"), ("flac", "mp4"), ("alac", "m4a")])
def test_damage_does_not_shift_what_follows(tmp_path: Path, codec: str, extension: str) -> None:
    written = impulses(LONG, LONG_SHOTS, channels=2)
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec)
    data = bytearray(path.read_bytes())
    place = len(data) * 3 // 10
    data[place : place + 100] = np.random.default_rng(5).bytes(100)
    path.write_bytes(data)
    samples, source = read(path, mix="0")
    assert len(samples) == LONG
    np.testing.assert_array_equal(samples[200_000:, 0], written[200_000:, 0])
    changed = np.flatnonzero(samples[:, 0] != written[:, 0])
    assert changed.size
    assert changed[-1] - changed[0] < 10_000
    if codec == "flac":
        assert any("filled with silence" in warning for warning in source.warnings)


def test_a_damaged_beginning_does_not_shift_what_follows(tmp_path: Path) -> None:
    written = impulses(LONG, LONG_SHOTS)
    path = write_media(tmp_path / "film.mp4", [written], codec="flac")
    data = bytearray(path.read_bytes())
    place = data.index(b"mdat") + 4
    data[place : place + 100] = np.random.default_rng(5).bytes(100)
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) == LONG
    assert not samples[:4_000].any()
    np.testing.assert_array_equal(samples[5_000:], written[5_000:])
    assert len(source.warnings) == 2


@pytest.mark.parametrize(
    ("frame", "packet", "told", "failed", "begins"),
    [
        (7, 5, None, 1, 5),  # two seconds were lost
        (7, 5, 3, 1, 5),
        (7, 5, 6, 1, 6),  # what a decoder needs before the beginning is not played
        (7, 5, 9, 1, 7),  # what is there is played, whatever is told
        (7, 8, None, 1, 7),
        (7, 5, 3, 0, 7),  # nothing was lost: it is the decoder's delay
        (7, None, 3, 1, 7),
        (None, 5, 3, 1, None),
    ],
)
def test_a_film_of_which_the_first_frames_are_lost_begins_where_they_were_due(
    frame: int | None, packet: int | None, told: int | None, failed: int, begins: int | None
) -> None:
    second = Fraction(1)
    codec = SimpleNamespace(codec=SimpleNamespace(lossless=False, lossy=True))
    container = SimpleNamespace(format=SimpleNamespace(name="mp4"))
    stream = SimpleNamespace(codec_context=codec, container=container, start_time=told, time_base=second)
    tally = Tally(packets=9, failed=failed, first_time=None if packet is None else Fraction(packet))
    first = SimpleNamespace(pts=frame, time_base=second)
    assert origin_of(cast("Any", first), cast("Any", stream), tally) == begins


@pytest.mark.parametrize(
    ("codec", "extension"), [("flac", "mkv"), ("aac", "mkv"), ("ac3", "mkv"), ("aac", "mp4"), ("ac3", "ts")]
)
def test_lost_packets_do_not_shift_what_follows(tmp_path: Path, codec: str, extension: str) -> None:
    written = impulses(LONG, LONG_SHOTS, channels=2)
    path = tmp_path / f"film.{extension}"
    whole, _ = read(write_media(path, [written], codec=codec, picture_rate=FILM_RATE))
    lost = [(2.0, 2.3), (2.35, 2.4), (6.0, 6.05)]
    samples, source = read(write_media(path, [written], codec=codec, picture_rate=FILM_RATE, lost_s=lost))
    assert len(samples) == len(whole)
    np.testing.assert_allclose(shots_in_film(samples, source), LONG_SHOTS, atol=48)
    assert any("filled with silence" in warning for warning in source.warnings)
    assert not samples[int(2.1 * RATE_HZ) : int(2.2 * RATE_HZ)].any()


@pytest.mark.parametrize(("codec", "extension"), [("ac3", "ts"), ("flac", "ogg")])
def test_what_lies_behind_a_hole_in_which_no_packet_begins_is_read_where_it_plays(
    tmp_path: Path, codec: str, extension: str
) -> None:
    """FFmpeg gives up after so many bytes without a packet; a film must not end there."""
    shots = [20_000, 300_000, 520_000]
    path = write_media(tmp_path / f"film.{extension}", [impulses(12 * RATE_HZ, shots, channels=6)], codec=codec)
    data, hole = path.read_bytes(), 300_000
    whole, before = read(path, mix="0")
    start = len(data) // 4
    assert start + hole < len(data)
    path.write_bytes(data[:start] + bytes(hole) + data[start + hole :])
    samples, source = read(path, mix="0")
    assert len(samples) == len(whole)
    assert shots_in_film(samples, source)[-1] == shots_in_film(whole, before)[-1]
    assert any("filled with silence" in warning for warning in source.warnings)
    assert any("went on behind the damage" in warning for warning in source.warnings)
    path.write_bytes(data[:start] + bytes(len(data) - start))  # nothing follows
    _, nothing_more = read(path, mix="0")
    assert nothing_more.frames < len(whole) // 2
    assert nothing_more.warnings
    assert not any("went on" in warning for warning in nothing_more.warnings)


@pytest.mark.parametrize("codec", ["aac", "ac3", "eac3"])
def test_what_damage_displaces_in_a_file_without_time_stamps_is_told(tmp_path: Path, codec: str) -> None:
    """Nothing says how much was lost: at what was one frame, half a second may be."""
    path = tmp_path / f"film.{codec}"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, container_format="adts" if codec == "aac" else codec)
    data = path.read_bytes()
    whole = read(path)[0]
    start, length = len(data) * 7 // 10, len(data) // 20
    path.write_bytes(data[:start] + bytes(length) + data[start + length :])
    samples, source = read(path)
    displaced = onsets(whole[:, 0])[-1] - onsets(samples[:, 0])[-1]
    assert displaced > 0.3 * RATE_HZ
    assert any("if more is missing there, what follows plays early" in line for line in source.warnings)
    path.write_bytes(data[:start])  # nothing follows
    assert not any("plays early" in line for line in read(path)[1].warnings)


@pytest.mark.parametrize("every", [1, 3])
def test_sound_that_is_mostly_damaged_is_refused(tmp_path: Path, every: int) -> None:
    path = write_media(tmp_path / "film.mp4", [impulses(LONG, LONG_SHOTS)], codec="flac")
    data = path.read_bytes()
    start, rng = data.index(b"mdat") + 4, np.random.default_rng(0)
    stop = data.index(b"moov") - 4
    size = (stop - start) // 100
    damaged = bytearray(data)
    for place in range(start, stop - size, every * size):
        damaged[place : place + size] = rng.bytes(size)
    path.write_bytes(damaged)
    with pytest.raises(SoundtrackError, match=r"film\.mp4: (\d+ of \d+ packets of sound cannot|no sound could)"):
        read(path)


@pytest.mark.parametrize(
    ("codec", "extension"),
    [
        ("ac3", "ac3"),
        ("ac3", "mkv"),
        ("ac3", "mp4"),
        ("eac3", "eac3"),
        ("eac3", "mkv"),
        ("flac", "mkv"),
        ("flac", "mp4"),
        ("tta", "mkv"),
        ("wavpack", "wv"),
    ],
)
def test_frames_with_a_wrong_checksum_are_lost_and_told(tmp_path: Path, codec: str, extension: str) -> None:
    frames = 40 * RATE_HZ if codec == "tta" else LONG  # its packets last a second
    path = write_media(tmp_path / f"film.{extension}", [impulses(frames, LONG_SHOTS, channels=2)], codec=codec)
    whole, intact = read(path, mix="0")
    assert intact.warnings == ()
    one, place_s = damaged(path, [0.35])
    every, _ = damaged(path, np.linspace(0.0, 1.0, 1_000).tolist())
    path.write_bytes(one)
    samples, source = read(path, mix="0")
    assert len(samples) == len(whole)
    assert onsets(samples[:, 0]) == onsets(whole[:, 0])
    failed, filled = source.warnings
    assert re.match(r"1 of \d+ packets of sound could not be decoded .*, first at \d+\.\d+ s$", failed)
    assert float(failed.split()[-2]) == pytest.approx(place_s, abs=0.006)  # the delay of AC-3 is cut off
    assert filled.startswith("1 gap was filled with silence")
    path.write_bytes(every)
    place = "" if extension == "eac3" else r", first at 0\.0\d\d s"  # its stamps come from what can be decoded
    told = rf"(\d\d+) of \1 packets of sound cannot be decoded \(.*\){place}; expected no more than 10%"
    with pytest.raises(SoundtrackError, match=told):
        read(path)


def test_a_place_is_told_from_the_first_sample_however_late_the_sound_begins(tmp_path: Path) -> None:
    places_s = []
    for delay_s in (0.0, 1.5):
        path = tmp_path / f"late-{delay_s}.mkv"
        write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec="flac", audio_delay_s=delay_s)
        bytes_damaged, place_s = damaged(path, [0.35])
        path.write_bytes(bytes_damaged)
        _, source = read(path, mix="0")
        (told,) = re.findall(r"first at (\S+) s$", source.warnings[0])
        places_s.append(float(told))
        assert float(told) == pytest.approx(place_s, abs=0.006)
    assert places_s[0] == places_s[1] > 1.0


def broken_off(tmp_path: Path, spans: list[tuple[int, int]], *, subtype: str = "PCM_16") -> list[str]:
    """Return the warnings about a stereo file of noise in which spans of bytes of its sound are lost."""
    path, size = tmp_path / "film.wav", 2 * {"PCM_16": 2, "FLOAT": 4}[subtype]
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, (6 * RATE_HZ, 2))
    soundfile.write(path, noise, RATE_HZ, subtype=subtype)
    data = bytearray(path.read_bytes())
    sound = len(data) - size * len(noise)
    for start, stop in spans:
        data[sound + start : sound + stop] = bytes(stop - start)
    path.write_bytes(data)
    return [line for line in read(path)[1].warnings if "breaks off" in line]


@pytest.mark.parametrize(("subtype", "block"), [("PCM_16", 4_096), ("FLOAT", 8_192)])
def test_blocks_of_a_file_that_are_lost_are_told(tmp_path: Path, subtype: str, block: int) -> None:
    (one,) = broken_off(tmp_path, [(100 * block, 101 * block)], subtype=subtype)
    assert f"once and comes back as abruptly, first at {100 * 1024 / RATE_HZ:.3f} s: a part" in one
    spans = [(n * block, (n + 10) * block) for n in (0, 20, 30, 60)]
    (some,) = broken_off(tmp_path, spans, subtype=subtype)
    assert "2 times" in some  # what is missing from the first sample on never broke off


@pytest.mark.parametrize("extension", ["mov", "mkv", "avi"])
def test_blocks_of_uncompressed_sound_that_a_film_has_lost_are_told(tmp_path: Path, extension: str) -> None:
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, (2 * RATE_HZ, 2)).astype(np.float32)
    noise[RATE_HZ : RATE_HZ + 2_000] = 0.0
    path = write_media(tmp_path / f"film.{extension}", [noise], codec="pcm_s24le", picture_rate=FILM_RATE)
    (one,) = read(path)[1].warnings
    assert "breaks off into zeros once and comes back as abruptly, first at 1.000 s" in one


@pytest.mark.parametrize(("codec", "extension"), [("flac", "flac"), ("alac", "mov"), ("flac", "mkv")])
def test_zeros_in_what_was_coded_without_loss_are_meant(tmp_path: Path, codec: str, extension: str) -> None:
    """Their decoder tells of what is lost: these zeros have been coded, and were in the film."""
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, (2 * RATE_HZ, 2)).astype(np.float32)
    noise[RATE_HZ : RATE_HZ + 2_000] = 0.0
    path = write_media(tmp_path / f"film.{extension}", [noise], codec=codec)
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize("codec", ["libmp3lame", "ac3", "mp2"])
def test_an_avi_that_has_lost_packets_is_told_where_the_others_close_up(tmp_path: Path, codec: str) -> None:
    """FFmpeg counts the packets of an AVI that it finds, and the stamps of those after the loss are too early."""
    path = write_media(tmp_path / "film.avi", [impulses(LONG, LONG_SHOTS)], codec=codec, picture_rate=FILM_RATE)
    whole, source = read(path)
    assert source.warnings == ()
    data = bytearray(path.read_bytes())
    start, size = len(data) // 2, len(data) // 12
    data[start : start + size] = np.random.default_rng(1).bytes(size)
    path.write_bytes(data)
    samples, damaged_source = read(path)
    assert len(samples) < len(whole)
    assert any("what follows plays early" in line for line in damaged_source.warnings)


@pytest.mark.parametrize("extension", ["asf", "nut"])
def test_sound_that_ends_before_its_picture_is_not_called_damaged(tmp_path: Path, extension: str) -> None:
    """There a stream has no length of its own."""
    path, length_s = tmp_path / f"film.{extension}", LONG / RATE_HZ
    ended = [(length_s - 3.0, length_s + 1.0)]
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec="mp2", picture_rate=FILM_RATE, lost_s=ended)
    (one,) = read(path)[1].warnings
    assert re.fullmatch(r"the file lasts for .* s but its sound for .* s: some of it may be missing", one)


@pytest.mark.parametrize("size", [1, 7, 240, 1_000, 7_201])
def test_lost_blocks_are_found_in_blocks_of_any_size(size: int) -> None:
    samples = np.random.default_rng(7).uniform(-0.5, 0.5, (24_000, 2)).astype(np.float32)
    for start, stop in ((4_800, 5_100), (7_000, 7_240), (14_400, 14_500), (20_000, 24_000)):
        samples[start:stop] = 0.0
    seen = Dropouts(RATE_HZ)
    for start in range(0, len(samples), size):
        seen.hear(samples[start : start + size])
    assert (seen.count, seen.first) == (2, 4_800)


def test_silence_that_a_film_means_is_no_loss(tmp_path: Path) -> None:
    noise = np.random.default_rng(7).uniform(-0.5, 0.5, 6 * RATE_HZ)
    for start, stop in ((0, RATE_HZ), (2 * RATE_HZ, 3 * RATE_HZ), (4 * RATE_HZ, 4 * RATE_HZ + 100)):
        noise[start:stop] = 0.0
    noise[3 * RATE_HZ : 3 * RATE_HZ + 480] *= np.linspace(0.0, 1.0, 480)  # a fade on one side is enough
    noise[5 * RATE_HZ :] = 0.0
    soundfile.write(tmp_path / "film.wav", noise, RATE_HZ, subtype="PCM_16")
    assert not read(tmp_path / "film.wav")[1].warnings


def test_sound_that_its_decoder_knows_to_be_wrong_is_no_sound() -> None:
    """A decoder that conceals an error plays on and marks the frame; what is placed instead is silence."""
    stereo = SimpleNamespace(name="stereo")
    frames = [SimpleNamespace(is_corrupt=corrupt, layout=stereo) for corrupt in (False, True, False)]
    tally = Tally(packets=len(frames))
    for pts, frame in enumerate(frames):
        packet = SimpleNamespace(pts=pts, time_base=Fraction(3, 2), decode=lambda frame=frame: [frame])
        assert _frames(cast("Any", packet), tally) == ([] if frame.is_corrupt else [frame])
    assert (tally.failed, tally.last_error, tally.first_failed_time) == (1, "damaged", Fraction(3, 2))
