"""Files that do not say how long they are: a missing beginning or end, and sound that goes on elsewhere, are told."""

from pathlib import Path

import pytest

from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.reach import Reach
from coded_films import FILM_RATE, LONG, LONG_SHOTS, is_broken_off, read
from media import impulses, write_media

SOUND = impulses(LONG, LONG_SHOTS, channels=2)


def streamed(path: Path, codec: str, *, tracks: int = 1, options: dict[str, str] | None = None) -> bytes:
    """Write a stream, with a picture where its format can have one, and return its bytes."""
    kind = {"ts": "mpegts", "m2ts": "mpegts", "mpg": "mpeg", "aac": "adts", "ac3": "ac3"}[path.suffix[1:]]
    options = {**(options or {}), **({"mpegts_m2ts_mode": "1"} if path.suffix == ".m2ts" else {})}
    picture = FILM_RATE if kind.startswith("mpeg") else None
    write_media(
        path,
        [SOUND] * tracks,
        codec=codec,
        container_format=kind,
        picture_rate=picture,
        audio_delay_s=0.5 if picture else 0.0,  # no time stamp before 0, which a transport stream has no place for
        container_options=options,
    )
    return path.read_bytes()


@pytest.mark.parametrize(("codec", "extension"), [("ac3", "ts"), ("mp2", "ts"), ("ac3", "m2ts"), ("mp2", "mpg")])
def test_a_stream_that_is_cut_in_a_packet_is_told(tmp_path: Path, codec: str, extension: str) -> None:
    path = tmp_path / f"film.{extension}"
    data = streamed(path, codec)
    assert read(path)[1].warnings == ()
    packet = {"ts": 188, "m2ts": 192, "mpg": 2_048}[extension]
    assert len(data) % packet == 0
    whole = len(data) // packet * 6 // 10 * packet
    for kept in (whole + packet // 3, whole + packet - 1, len(data) - 1):
        path.write_bytes(data[:kept])
        assert is_broken_off(read(path)[1])
    for kept in (whole, whole + packet):  # as a recorder that is stopped leaves it
        path.write_bytes(data[:kept])
        assert not is_broken_off(read(path)[1])
    path.write_bytes(data + b"what some program left behind")
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize(("codec", "extension"), [("ac3", "ts"), ("mp2", "mpg"), ("ac3", "ac3"), ("aac", "aac")])
def test_an_end_that_was_never_written_is_told(tmp_path: Path, codec: str, extension: str) -> None:
    path = tmp_path / f"film.{extension}"
    data = streamed(path, codec)
    assert read(path)[1].warnings == ()
    kept = len(data) * 6 // 10
    path.write_bytes(data[:kept] + bytes(len(data) - kept))  # as a copy into a file of the final size that broke off
    assert any("% of the file holds nothing of this sound" in line for line in read(path)[1].warnings)


def test_an_ogg_in_which_damage_hides_all_that_follows_is_told(tmp_path: Path) -> None:
    """Where its last page, which says how long it is, is damaged too, FFmpeg ends at a bad page as if at the end."""
    path = write_media(tmp_path / "film.ogg", [SOUND], codec="flac", container_format="ogg")
    data = bytearray(path.read_bytes())
    for place in range(len(data) // 5, len(data), 1_000):
        data[place] ^= 0x55
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) < 0.3 * LONG
    assert any("% of the file holds nothing of this sound" in line for line in source.warnings)


@pytest.mark.parametrize("extension", ["ts", "aac"])
def test_a_beginning_that_is_lost_is_told(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"film.{extension}"
    data = streamed(path, "aac")
    start = 3_000 if extension == "ts" else 0
    path.write_bytes(data[:start] + bytes(len(data) * 4 // 10) + data[start + len(data) * 4 // 10 :])
    samples, source = read(path)
    assert len(samples) < 0.75 * LONG
    assert any("% of the file holds no sound" in line for line in source.warnings)


@pytest.mark.parametrize("tag", [b"ID3\4\0\0\0\x06\x1a\0" + bytes(100_608), b"APETAGEX" + bytes(100_000)])
def test_the_tags_of_a_bare_stream_are_no_lost_sound(tmp_path: Path, tag: bytes) -> None:
    path = tmp_path / "film.aac"
    data = streamed(path, "aac")
    path.write_bytes(tag + data if tag.startswith(b"ID3") else data + tag)
    assert read(path)[1].warnings == ()


def test_sound_that_goes_on_in_streams_that_began_on_the_way_is_told(tmp_path: Path) -> None:
    """Recordings of broadcasts name their streams anew where a programme does; nothing but the bytes shows it."""
    path = tmp_path / "film.ts"
    first = streamed(path, "ac3")
    second = streamed(path, "ac3", tracks=30, options={"mpegts_start_pid": "512"})
    path.write_bytes(first + second)
    with open_soundtrack(path) as track:
        heard = sum(len(block.span) for block in track.blocks())
        source = track.source()
    assert heard < 1.2 * LONG
    assert any("goes on in another stream" in line for line in source.warnings)


@pytest.mark.parametrize(("silent", "share"), [(99_600, "100 %"), (34_000, "34 %"), (9_940, "9.9 %"), (310, "0.31 %")])
def test_shares_of_a_file_are_plain_numbers(tmp_path: Path, silent: int, share: str) -> None:
    path = tmp_path / "film.ts"
    path.write_bytes(bytes(100_000))
    reach = Reach()
    for place in range(silent, 100_000, 20):
        reach.note(place, 20)
    lines = reach.warnings(path, played_s=3600.0)
    assert lines == [f"the first {share} of the file holds no sound: where it should, the beginning is missing"]
