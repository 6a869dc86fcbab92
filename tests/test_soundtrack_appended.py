"""Files joined end to end: the second is not taken for sound of the first, and not lost without a word."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import soundfile

from coded_films import FILM_RATE, LONG, LONG_SHOTS
from media import impulses, write_media
from sound_files import RATE_HZ, noise, read

Writer = Callable[[Path], object]


def sound(container: str, subtype: str, frames: int = 20_001) -> Writer:
    return lambda path: soundfile.write(path, noise(frames), RATE_HZ, format=container, subtype=subtype)


def film(codec: str, container: str, *, has_picture: bool = False, movflags: str = "") -> Writer:
    return lambda path: write_media(
        path,
        [impulses(LONG, LONG_SHOTS)],
        codec=codec,
        container_format=container,
        picture_rate=FILM_RATE if has_picture else None,
        container_options={"movflags": movflags} if movflags else {},
    )


KINDS = {
    "WAV": sound("WAV", "PCM_16"),
    "WAV, odd": sound("WAV", "PCM_24"),
    "WAV, A-law": sound("WAV", "ALAW"),
    "RF64": sound("RF64", "PCM_24"),
    "W64": sound("W64", "PCM_16"),
    "AIFF": sound("AIFF", "PCM_16"),
    "AIFF, odd": sound("AIFF", "PCM_24"),
    "CAF": sound("CAF", "PCM_24"),
    "CAF, even": sound("CAF", "PCM_24", frames=20_000),
    "CAF, ALAC": sound("CAF", "ALAC_16"),
    "MP4": film("aac", "mp4", has_picture=True),
    "MP4, index first": film("aac", "mp4", movflags="faststart"),
    "MOV": film("pcm_s16le", "mov", has_picture=True),
    "TTA": film("tta", "tta"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_behind_another_is_told(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "film.sound"
    KINDS[kind](path)
    whole, data = path.read_bytes(), read(path)[0]
    assert read(path)[1].warnings == ()
    tag = b"TAG" + bytes(125) if kind == "TTA" else b""
    for appended in (whole, whole[: len(whole) * 3 // 4], tag + whole):
        path.write_bytes(whole + appended)
        found, source = read(path)
        np.testing.assert_array_equal(found, data)
        (line,) = source.warnings
        place = len(path.read_bytes()) - len(appended) + (len(tag) if appended.startswith(b"TAG") else 0)
        share = 100.0 * (1.0 - place / path.stat().st_size)
        assert line == (
            f"another file begins at byte {place}, behind the sound: "
            f"only the first is read, not the last {share:.0f} % of the bytes"
        )


@pytest.mark.parametrize("before", ["neither", "the second", "both"])
def test_a_tag_with_a_picture_hides_no_second_file(tmp_path: Path, before: str) -> None:
    path, size = tmp_path / "film.tta", 100_000
    KINDS["TTA"](path)
    whole, data = path.read_bytes(), read(path)[0]
    tag = b"ID3\3\0\0" + bytes(size >> shift & 0x7F for shift in (21, 14, 7, 0)) + b"\x55" * size
    first, second = (tag + whole if before in names else whole for names in (["both"], ["both", "the second"]))
    path.write_bytes(first + second)
    found, source = read(path)
    np.testing.assert_array_equal(found, data)
    (line,) = source.warnings
    assert line.startswith(f"another file begins at byte {len(first + second) - len(whole)}, behind")


@pytest.mark.parametrize("kind", ["WAV", "AIFF, odd", "CAF, even"])
@pytest.mark.parametrize("share", [0.7, 1.0])
def test_a_file_behind_the_chunks_of_another_is_told(tmp_path: Path, kind: str, share: float) -> None:
    path = tmp_path / "film.sound"
    KINDS[kind](path)
    whole, data = path.read_bytes(), read(path)[0]
    size = {"W": struct.pack("<I", 5_000), "A": struct.pack(">I", 5_000), "C": struct.pack(">q", 5_000)}[kind[0]]
    first = whole + b"mine" + size + b"\3" * 5_000
    path.write_bytes(first + whole[: int(share * len(whole))])
    found, source = read(path)
    np.testing.assert_array_equal(found, data)
    (line,) = source.warnings
    assert line.startswith(f"another file begins at byte {len(first)}, behind")


@pytest.mark.parametrize("kind", ["WAV, odd", "CAF"])
def test_padding_that_was_forgotten_hides_no_second_file(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "film.sound"
    KINDS[kind](path)
    whole, data = path.read_bytes(), read(path)[0]
    assert whole[-1] == 0
    path.write_bytes(whole[:-1] + whole)
    found, source = read(path)
    np.testing.assert_array_equal(found, data)
    (line,) = source.warnings
    assert line.startswith(f"another file begins at byte {len(whole) - 1}, behind")


def test_a_film_of_quicktime_without_ftyp_behind_another_is_told(tmp_path: Path) -> None:
    path = tmp_path / "film.mov"
    KINDS["MOV"](path)
    whole = path.read_bytes()
    old = whole.replace(b"ftyp", b"free", 1)
    path.write_bytes(old + old)
    assert [line.split(",")[0] for line in read(path)[1].warnings] == [f"another file begins at byte {len(old)}"]
    path.write_bytes(old + old[old.rindex(b"moov") - 4 :])  # a second index, for safety, is no second film
    assert read(path)[1].warnings == ()


def test_what_of_a_second_film_in_fragments_is_read_is_not_told_to_be_lost(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    film("aac", "mp4", has_picture=True, movflags="frag_keyframe+empty_moov")(path)
    once = len(read(path)[0])
    path.write_bytes(2 * path.read_bytes())
    found, source = read(path)
    assert len(found) > 1.9 * once
    assert not any("another file" in line for line in source.warnings)


@pytest.mark.parametrize("kind", ["WAV", "RF64"])
@pytest.mark.parametrize("start", [b"RIFF\x10\x20\0\0AVIX", b"RIFF\x10\x20\0\0INFO", b"caff"])
def test_what_is_no_sound_file_is_none(tmp_path: Path, kind: str, start: bytes) -> None:
    path = tmp_path / "film.sound"
    KINDS[kind](path)
    whole, data = path.read_bytes(), read(path)[0]
    path.write_bytes(whole + start + bytes(range(1, 101)) * 82 + bytes(8))
    found, source = read(path)
    np.testing.assert_array_equal(found, data)
    assert source.warnings == ()
