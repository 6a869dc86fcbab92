"""Films that break off: noticed in every container."""

import re
import struct
from fractions import Fraction
from pathlib import Path

import pytest
import soundfile

from blastline.errors import SoundtrackError
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.boxes import breaks_off_in_fragments, ends_before_its_index
from blastline.soundtrack.ending import stops_early
from blastline.soundtrack.matroska import stores_duration
from coded_films import FILM_RATE, FRAMES, LONG, LONG_SHOTS, SHOTS, is_broken_off, read
from media import RATE_HZ, impulses, onsets, write_media


@pytest.mark.parametrize(
    ("codec", "extension", "options"),
    [("aac", "mkv", {}), ("flac", "mkv", {}), ("flac", "flac", {}), ("aac", "mp4", {"movflags": "faststart"})],
)
def test_a_missing_end_is_noticed(tmp_path: Path, codec: str, extension: str, options: dict[str, str]) -> None:
    path = tmp_path / f"film.{extension}"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, container_options=options)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    samples, source = read(path)
    assert onsets(samples[:, 0])[:2] == pytest.approx(LONG_SHOTS[:2], abs=48)
    assert any(
        warning.startswith("the file declares 10.0") and "the end is missing, or a part before it" in warning
        for warning in source.warnings
    )


@pytest.mark.parametrize("picture_rate", [None, FILM_RATE])
@pytest.mark.parametrize("codec", ["pcm_s16le", "ac3", "libmp3lame"])
def test_a_missing_end_of_an_avi_is_noticed(tmp_path: Path, codec: str, picture_rate: Fraction | None) -> None:
    path = tmp_path / "film.avi"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec=codec, picture_rate=picture_rate)
    data = path.read_bytes()
    for whole in (data, data + bytes(5_000)):
        path.write_bytes(whole)
        assert read(path)[1].warnings == ()
        assert not stops_early(path, "avi")
    path.write_bytes(data[: data.rindex(b"idx1")])  # only the index is missing
    assert read(path)[1].warnings == ()
    path.write_bytes(data[: len(data) * 6 // 10])
    assert stops_early(path, "avi")
    warning = read(path)[1].warnings[-1]
    assert warning.startswith("the file declares 10.0")
    assert "the end is missing" in warning
    place = data.index(b"auds") + 32
    path.write_bytes((data[:place] + bytes(4) + data[place + 4 :])[: len(data) * 6 // 10])
    assert is_broken_off(read(path)[1])


def test_samples_that_an_avi_counts_and_does_not_have_are_told(tmp_path: Path) -> None:
    path = tmp_path / "film.avi"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec="pcm_s16le", picture_rate=FILM_RATE)
    data = bytearray(path.read_bytes())
    place = data.index(b"01wb", len(data) // 3)
    data[place : place + 9_000] = bytes(9_000)
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) < LONG
    assert any("or a part before it, and what follows plays early" in warning for warning in source.warnings)


@pytest.mark.parametrize("codec", ["libopus", "flac", "vorbis"])
def test_a_missing_end_of_an_ogg_is_noticed(tmp_path: Path, codec: str) -> None:
    path = tmp_path / "film.ogg"
    written = impulses(LONG, LONG_SHOTS, channels=2)
    if codec == "vorbis":
        with soundfile.SoundFile(path, "w", RATE_HZ, 2, format="OGG", subtype="VORBIS") as file:
            for start in range(0, LONG, 4_096):
                file.write(written[start : start + 4_096])
    else:
        write_media(path, [written], codec=codec, container_format="ogg")
    assert read(path)[1].warnings == ()
    data = path.read_bytes()
    for trailer in (b"TAG" + bytes(125), b"OggS"):
        path.write_bytes(data + trailer)
        assert read(path)[1].warnings == ()
    pages = [found.start() for found in re.finditer(rb"OggS\0", data)]
    spoilt = data[:-20] + bytes(20)  # FFmpeg drops a page whose checksum is wrong, and with it how long the sound is
    cuts = [data[:kept] for kept in (len(data) // 2, pages[len(pages) // 2], pages[-1], len(data) - 1)]
    for damaged in (spoilt, *cuts):
        path.write_bytes(damaged)
        assert is_broken_off(read(path)[1])


@pytest.mark.parametrize("flags", ["frag_keyframe+empty_moov", "frag_keyframe", "dash"])
def test_an_mp4_in_fragments_that_breaks_off_is_noticed(tmp_path: Path, flags: str) -> None:
    """Such a film declares no length, and after a damaged fragment nothing leads to the next one: half may be gone."""
    path = tmp_path / "film.mp4"
    options = {"movflags": flags, "frag_duration": "500000"}
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec="aac", picture_rate=FILM_RATE, container_options=options)
    data = path.read_bytes()
    for padding in (b"", bytes(5_000)):
        path.write_bytes(data + padding)
        assert read(path)[1].warnings == ()
    places = [found.start() - 4 for found in re.finditer(b"moof", data)]
    middle = places[len(places) // 2]
    lost = bytearray(data)
    lost[middle : middle + 2_000] = bytes(2_000)
    for damaged in (bytes(lost), data[: middle + 2_000], data[:middle] + data[middle + 1_000 :]):
        path.write_bytes(damaged)
        samples, source = read(path)
        assert len(samples) < 0.7 * LONG
        assert is_broken_off(source)


def box(name: bytes, *, size: int | None = None, wide: int | None = None) -> bytes:
    """Return a box of 40 bytes that says so, or another size; `wide` is one of 64 bits."""
    told = (1 if wide is not None else 40 if size is None else size).to_bytes(4, "big")
    return (told + name + (b"" if wide is None else wide.to_bytes(8, "big"))).ljust(40, b"x")


WHOLE = box(b"ftyp") + box(b"moov") + box(b"mdat")
FRAGMENTS = WHOLE + box(b"moof") + box(b"mdat")


@pytest.mark.parametrize(
    ("last", "leads_on"),
    [
        (box(b"mdat"), True),
        (box(b"mdat", wide=40), True),
        (box(b"mdat", size=0), True),  # up to the end of the file
        (box(b"junk", size=0), False),
        (box(b"mdat", size=1), False),
        *((box(b"mdat", size=size), False) for size in (2, 7)),
        *((box(b"mdat", wide=size), False) for size in (2, 7)),
        (box(b"free", size=8)[:8], True),
        (box(b"mdat", size=41), False),
        (box(b"mdat", wide=41), False),
    ],
)
def test_boxes_of_fragments_lead_to_the_end_of_the_file_and_one_piece_need_not(
    tmp_path: Path, last: bytes, *, leads_on: bool
) -> None:
    """A film in one piece declares its length, which tells what is missing."""
    path = tmp_path / "film.mp4"
    for film, breaks_off in ((FRAGMENTS, not leads_on), (WHOLE, False)):
        path.write_bytes(film + last)
        assert breaks_off_in_fragments(path) == breaks_off


@pytest.mark.parametrize(("before", "behind"), [(0, 0), (4, 0), (0, 16)])
def test_a_transport_stream_is_cut_where_its_last_packet_is_and_too_few_tell_nothing(
    tmp_path: Path, before: int, behind: int
) -> None:
    """Whatever a recorder puts before or behind a packet may be missing. Eight in a row are no chance."""
    path = tmp_path / "film.ts"
    packet = bytes(before) + b"\x47" + bytes(187) + bytes(behind)
    for packets in (1, 7, 8, 9, 40):
        for missing in (0, 1, 15, 16, 17, 50, 187, before + behind + 187):
            path.write_bytes((packets * packet)[: packets * len(packet) - missing])
            assert stops_early(path, "mpegts") == (packets >= 8 and behind < missing < behind + 188)


@pytest.mark.parametrize(("codec", "extension"), [("aac", "mp4"), ("pcm_s24le", "mov")])
def test_zeros_behind_a_fragment_are_padding_only_up_to_a_cluster(tmp_path: Path, codec: str, extension: str) -> None:
    """A copy that never finished leaves more of them, in a file that had its full size before."""
    path = tmp_path / f"film.{extension}"
    options = {"movflags": "frag_keyframe+empty_moov", "frag_duration": "500000"}
    noise = [impulses(LONG, LONG_SHOTS, channels=2)]
    write_media(path, noise, codec=codec, picture_rate=FILM_RATE, container_options=options)
    data, cluster = path.read_bytes(), 1 << 16
    path.write_bytes(data + bytes(cluster))
    assert read(path)[1].warnings == ()
    begins = [found.start() - 4 for found in re.finditer(b"moof", data)]
    for kept in (begins[1], begins[len(begins) // 2], begins[-1]):
        path.write_bytes(data[:kept] + bytes(max(cluster + 1, len(data) - kept)))
        samples, source = read(path)
        assert len(samples) < LONG
        assert is_broken_off(source)


@pytest.mark.parametrize(
    ("codec", "extension", "picture_rate"),
    [
        ("ac3", "mkv", None),
        ("ac3", "mkv", FILM_RATE),
        ("libmp3lame", "mkv", None),
        ("libmp3lame", "mkv", FILM_RATE),
        ("libopus", "webm", None),
    ],
)
def test_a_matroska_from_a_pipe_lacks_no_end(
    tmp_path: Path, codec: str, extension: str, picture_rate: Fraction | None
) -> None:
    """It says nowhere how long it is, and FFmpeg's guess is none that a file could fall short of."""
    path, live = tmp_path / f"film.{extension}", {"live": "1"}
    samples = [impulses(LONG, LONG_SHOTS, channels=2)]
    write_media(path, samples, codec=codec, picture_rate=picture_rate, container_options=live)
    assert b"\x44\x89\x88" not in path.read_bytes()[:4_096]
    with open_soundtrack(path) as track:
        assert track.expected_frames is None
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize(("codec", "extension"), [("ac3", "mkv"), ("libopus", "webm")])
@pytest.mark.parametrize("zeroed", [False, True])
def test_a_matroska_that_stores_its_length_is_held_to_it(
    tmp_path: Path, codec: str, extension: str, *, zeroed: bool
) -> None:
    path = tmp_path / f"film.{extension}"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec=codec)
    whole = path.read_bytes().replace(b"DURATION", b"DURATI0N")  # tags, by which streams say how long each is
    data = bytearray(whole[: len(whole) * 6 // 10])
    place = data.index(b"\x44\x89\x88") + 3  # a duration of 0 is none
    data[place : place + 8] = bytes(8) if zeroed else data[place : place + 8]
    path.write_bytes(data)
    with open_soundtrack(path) as track:
        assert (track.expected_frames is None) == zeroed
    told = [warning for warning in read(path)[1].warnings if warning.startswith("the file declares 10.0")]
    assert len(told) == (not zeroed)


@pytest.mark.parametrize("picture_rate", [None, FILM_RATE])
@pytest.mark.parametrize("codec", ["pcm_s16le", "flac", "aac"])
@pytest.mark.parametrize("live", [False, True])
def test_a_matroska_that_breaks_off_shortly_before_its_end_is_noticed(
    tmp_path: Path, codec: str, picture_rate: Fraction | None, *, live: bool
) -> None:
    path, options = tmp_path / "film.mkv", {"live": "1"} if live else {}
    samples = [impulses(LONG, LONG_SHOTS, channels=2)]
    write_media(path, samples, codec=codec, picture_rate=picture_rate, container_options=options)
    data = path.read_bytes()
    behind = len(data) if live else data.rindex(b"\x1c\x53\xbb\x6b")  # the index
    for whole in (data, data[:behind], data + bytes(5_000)):
        path.write_bytes(whole)
        assert read(path)[1].warnings == ()
        assert not stops_early(path, "matroska,webm")
    path.write_bytes(data[: behind - 1])
    assert stops_early(path, "matroska,webm")
    found, source = read(path)
    assert len(found) < LONG
    assert len(source.warnings) == 1
    assert "the end of the sound is missing" in source.warnings[0] or "the end is missing" in source.warnings[0]


@pytest.mark.parametrize("codec", ["pcm_s16le", "flac", "aac"])
def test_a_matroska_that_gives_one_length_for_all_its_streams_is_noticed_to_break_off(
    tmp_path: Path, codec: str
) -> None:
    """With a picture its sound may be meant to end earlier, but some of this one is gone, be it only 16 ms."""
    path = tmp_path / "film.mkv"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec=codec, picture_rate=FILM_RATE)
    data = path.read_bytes().replace(b"DURATION", b"PURPOSES")
    path.write_bytes(data)
    assert read(path)[1].warnings == ()
    path.write_bytes(data[: data.rindex(b"\x1c\x53\xbb\x6b") - 1])
    (told,) = read(path)[1].warnings
    assert told.endswith("some of it may be missing")


def test_a_matroska_stores_its_length_from_where_that_is_written_on_however_it_is_cut(tmp_path: Path) -> None:
    whole = write_media(tmp_path / "film.mkv", [impulses(1_000, [10])], codec="pcm_s16le").read_bytes()
    begins = whole.index(b"\x44\x89\x88") + 3
    told = []
    for size in range(begins + 8 + 20):
        (tmp_path / "cut.mkv").write_bytes(whole[:size])
        told.append(stores_duration(tmp_path / "cut.mkv"))
    assert not any(told[:begins])
    assert all(told[begins + 8 :])


@pytest.mark.parametrize("codec", ["pcm_s16le", "libmp3lame"])
def test_a_missing_end_of_a_nut_is_noticed(tmp_path: Path, codec: str) -> None:
    path = write_media(tmp_path / "film.nut", [impulses(LONG, LONG_SHOTS)], codec=codec, container_format="nut")
    data = path.read_bytes()
    assert read(path)[1].warnings == ()
    for kept in (len(data) * 6 // 10, len(data) - 1):
        path.write_bytes(data[:kept])
        assert is_broken_off(read(path)[1])


def test_a_nut_from_a_pipe_has_no_index_to_lack(tmp_path: Path) -> None:
    options = {"syncpoints": "none", "strict": "experimental"}
    path = write_media(
        tmp_path / "film.nut",
        [impulses(LONG, LONG_SHOTS)],
        codec="flac",
        container_format="nut",
        container_options=options,
    )
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize("extension", ["mp4", "mov"])
def test_a_film_cut_before_its_index_is_refused(tmp_path: Path, extension: str) -> None:
    path = write_media(tmp_path / f"film.{extension}", [impulses(FRAMES, SHOTS)], codec="aac")
    whole = path.read_bytes()
    for kept in (len(whole) // 2, 60):
        path.write_bytes(whole[:kept])
        with pytest.raises(SoundtrackError, match=r"film\.\w+: breaks off before its index \(moov\), without which"):
            open_soundtrack(path)
    path.write_bytes(b"\0" * 4_000)
    with pytest.raises(SoundtrackError, match="is not a sound file or film that can be read"):
        open_soundtrack(path)


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("moov", [False, True])
def test_a_film_lacks_its_index_where_no_box_leads_to_it_however_sizes_are_written(
    tmp_path: Path, wide: bool, moov: bool
) -> None:
    """Of more than 4 GB a box has its size in 64 bits behind its name."""
    sound = bytes(3_000)
    head = struct.pack(">I4sQ", 1, b"mdat", 16 + len(sound)) if wide else struct.pack(">I4s", 8 + len(sound), b"mdat")
    film = struct.pack(">I4s4sI", 16, b"ftyp", b"qt  ", 0) + head + sound
    (tmp_path / "film.mov").write_bytes(film + struct.pack(">I4s", 8, b"moov") * moov)
    assert ends_before_its_index(tmp_path / "film.mov") != moov
