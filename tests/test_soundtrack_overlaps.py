"""Sound that a file hands over twice is heard once, to the sample; an edit list of an unchanged film is no change."""

import struct
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from blastline.soundtrack.decode import packed
from blastline.soundtrack.stamped import Gap, Overlap
from coded_films import LONG, LONG_SHOTS, read, shots_in_film
from media import LAYOUTS, RATE_HZ, Samples, impulses, write_media

TS_PACKET = 188


def frame_of(samples: Samples) -> av.AudioFrame:
    packed_samples = np.ascontiguousarray(samples).reshape(1, -1)
    frame = av.AudioFrame.from_ndarray(packed_samples, format="flt", layout=LAYOUTS[samples.shape[1]])
    frame.sample_rate = RATE_HZ
    return frame


@pytest.mark.parametrize("channels", [1, 2, 6])
@pytest.mark.parametrize("cut", [1, 500, 1023])
def test_the_first_part_of_a_frame_is_cut_off_to_the_sample(channels: int, cut: int) -> None:
    sound = impulses(10 * 1024, [3_000], channels=channels)
    frames = [frame_of(block) for block in np.split(sound, 10)]
    placed: list[av.AudioFrame | Gap | Overlap] = [
        *frames[:4],
        Overlap(cut),
        *frames[4:6],
        Gap(70),
        *frames[6:8],
        Overlap(cut),
        *frames[8:],
    ]
    found = np.concatenate(list(packed(placed, rate_hz=RATE_HZ, channels=channels)))
    silence = np.zeros((70, channels), np.float32)
    expected = [sound[:4096], sound[4096 + cut : 6144], silence, sound[6144:8192], sound[8192 + cut :]]
    np.testing.assert_array_equal(found, np.concatenate(expected))


def sound_starts(data: bytes) -> list[int]:
    """Return where in a transport stream whose one programme is a track of sound its packets of sound begin."""
    starts = []
    for place in range(0, len(data), TS_PACKET):
        is_begun, number = bool(data[place + 1] & 0x40), int.from_bytes(data[place + 1 : place + 3], "big") & 0x1FFF
        if is_begun and number == 0x100:
            starts.append(place)
    return starts


@pytest.mark.parametrize("codec", ["ac3", "aac"])
@pytest.mark.parametrize("again", [1, 3])
def test_a_block_that_is_there_again_changes_nothing_and_is_told(tmp_path: Path, codec: str, again: int) -> None:
    path = write_media(tmp_path / "film.ts", [impulses(LONG, LONG_SHOTS)], codec=codec)
    data = path.read_bytes()
    whole, before = read(path)
    starts = sound_starts(data)
    assert len(starts) > 20
    for place in (len(starts) // 3, len(starts) * 2 // 3):
        begin, end = starts[place], starts[place + again]
        path.write_bytes(data[:end] + data[begin:])
        samples, source = read(path)
        assert len(samples) == len(whole)
        assert shots_in_film(samples, source) == shots_in_film(whole, before)
        assert [line for line in source.warnings if line.startswith("1 overlap was dropped, ")]
        assert not any("jump" in line for line in source.warnings)


def with_edits(path: Path, pieces: list[tuple[int, int]]) -> None:
    """Give the one track of a MOV, whose index comes last, an edit list of (first sample, samples)."""
    data = bytearray(path.read_bytes())
    rows = b"".join(struct.pack(">IIi", length, start, 1 << 16) for start, length in pieces)
    table = struct.pack(">I4sII", len(rows) + 16, b"elst", 0, len(pieces)) + rows
    edits = struct.pack(">I4s", len(table) + 8, b"edts") + table
    index, movie, track = (data.index(name) - 4 for name in (b"moov", b"mvhd", b"trak"))
    if (old := data.find(b"edts")) >= 0:
        data[old : old + 4] = b"free"
    header = data.index(b"tkhd") - 4
    behind = header + int.from_bytes(data[header : header + 4], "big")
    data[behind:behind] = edits
    for place in (index, track):
        data[place : place + 4] = (int.from_bytes(data[place : place + 4], "big") + len(edits)).to_bytes(4, "big")
    data[movie + 20 : movie + 24] = RATE_HZ.to_bytes(4, "big")  # the units of lengths in the list
    path.write_bytes(data)


@pytest.mark.parametrize(("codec", "extension"), [("pcm_s16le", "mov"), ("flac", "mp4")])
@pytest.mark.parametrize("length", [9_600, 24_000, 48_000])
def test_an_edit_list_that_plays_the_film_unchanged_changes_nothing(
    tmp_path: Path, codec: str, extension: str, length: int
) -> None:
    path = write_media(tmp_path / f"film.{extension}", [impulses(LONG, LONG_SHOTS)], codec=codec)
    whole, _ = read(path)
    with_edits(path, [(start, length) for start in range(0, LONG, length)])
    with av.open(str(path)) as container:
        stamps = [Fraction(packet.pts) for packet in container.demux(audio=0) if packet.pts is not None]
    assert any(stamp % 1024 for stamp in stamps)
    samples, source = read(path)
    assert not source.warnings
    np.testing.assert_array_equal(samples[:LONG], whole[:LONG])
