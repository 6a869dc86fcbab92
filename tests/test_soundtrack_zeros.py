"""Long zeros after a hard cut: told where storage would leave them, and meant everywhere else."""

import re
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.soundtrack.dropouts import Dropouts
from blastline.soundtrack.track import Stored
from media import write_media
from sound_files import read

RATE_HZ = 16_000
BLOCK = 4_096
SECONDS = 8
WIDTHS = {"PCM_S8": 1, "PCM_16": 2, "PCM_24": 3, "PCM_32": 4, "FLOAT": 4, "DOUBLE": 8}
FILES = [
    ("WAV", "PCM_16", 1),
    ("WAV", "PCM_16", 2),
    ("WAV", "PCM_24", 1),
    ("WAV", "PCM_24", 6),
    ("WAV", "PCM_32", 1),
    ("WAV", "FLOAT", 2),
    ("WAV", "DOUBLE", 1),
    ("RF64", "PCM_24", 2),
    ("W64", "PCM_16", 2),
    ("AIFF", "PCM_S8", 1),
    ("AIFF", "PCM_16", 1),
    ("AIFF", "PCM_24", 2),
    ("CAF", "PCM_24", 1),
    ("CAF", "FLOAT", 8),
]


def loud(channels: int, frames: int = SECONDS * RATE_HZ) -> NDArray[np.float64]:
    """Return noise that is never soft, so that every cut is abrupt, unless it is scaled."""
    rng = np.random.default_rng(11)
    samples = rng.uniform(0.1, 0.5, (frames, channels))
    samples[rng.random((frames, channels)) < 0.5] *= -1.0
    return samples


class Film:
    """A file of loud sound, of which some bytes are lost."""

    def __init__(self, path: Path, container: str, subtype: str, channels: int, *, gain_db: float = 0.0) -> None:
        self.path, self.frame_bytes = path, WIDTHS[subtype] * channels
        samples = loud(channels) * 10.0 ** (gain_db / 20.0)
        soundfile.write(path, samples, RATE_HZ, format=container, subtype=subtype)
        self.whole = path.read_bytes()
        self.first_byte = len(self.whole) - len(samples) * self.frame_bytes  # nothing follows the sound

    def block_at(self, time_s: float) -> int:
        """Return the last byte before a time at which a block begins."""
        return (self.first_byte + round(time_s * RATE_HZ) * self.frame_bytes) // BLOCK * BLOCK

    def losing(self, start: int, stop: int | None = None) -> list[str]:
        """Return the warnings where the bytes from one to before another, or to the end, are zeros."""
        stop = len(self.whole) if stop is None else stop
        self.path.write_bytes(self.whole[:start] + bytes(stop - start) + self.whole[stop:])
        return list(read(self.path)[1].warnings)

    def second_of(self, byte: int) -> float:
        """Return when the first frame begins that a byte and all behind it hold."""
        return -(-(byte - self.first_byte) // self.frame_bytes) / RATE_HZ


@pytest.mark.parametrize(("container", "subtype", "channels"), FILES)
def test_zeros_to_the_end_from_where_a_block_begins_are_told(
    tmp_path: Path, container: str, subtype: str, channels: int
) -> None:
    film = Film(tmp_path / "film.sound", container, subtype, channels)
    for share in (0.1, 0.33, 0.6, 0.95):
        start = film.block_at(share * SECONDS)
        (one,) = film.losing(start)
        begins_s = film.second_of(start)
        lasts_s = SECONDS - begins_s
        assert one.startswith(
            f"the sound breaks off into zeros at {begins_s:.3f} s, which last to the end, for {lasts_s:.3f} s: "
        )


@pytest.mark.parametrize(("container", "subtype", "channels"), FILES)
@pytest.mark.parametrize("gain_db", [-20.0, -40.0, -54.0])
def test_copies_that_were_never_finished_are_told_however_soft_the_film_is(
    tmp_path: Path, container: str, subtype: str, channels: int, gain_db: float
) -> None:
    if gain_db < -20.0 and subtype == "PCM_S8":
        pytest.skip("softer than its last bit")
    film = Film(tmp_path / "film.sound", container, subtype, channels, gain_db=gain_db)
    for share in (0.1, 0.33, 0.6, 0.95):
        (one,) = film.losing(film.block_at(share * SECONDS))
        assert ", which last to the end, for " in one


@pytest.mark.parametrize("fade_s", [0.005, 0.05, 1.0])
@pytest.mark.parametrize("shape", ["linear", "cosine", "60 dB"])
def test_no_fade_into_digital_silence_is_told_wherever_it_ends(fade_s: float, shape: str) -> None:
    """Though one of these blocks begins just there: as if storage had lost what follows."""
    rate_hz, end = 48_000, 60_000
    falling = np.linspace(1.0, 0.0, round(fade_s * rate_hz), endpoint=False)
    fades = {"linear": falling, "cosine": 0.5 - 0.5 * np.cos(np.pi * falling), "60 dB": 10.0 ** (3.0 * (falling - 1.0))}
    samples = 0.2 * loud(2, rate_hz * 2)
    samples[end - len(falling) : end] *= fades[shape][:, None]
    samples[end:] = 0.0
    whole = (np.rint(samples * 32_768) / 32_768).astype(np.float32)
    ends = int(np.flatnonzero(whole.any(axis=1))[-1]) + 1
    seen = Dropouts(rate_hz, Stored(-4 * ends % BLOCK, 4))
    seen.hear(whole)
    assert list(seen.warnings()) == []


@pytest.mark.parametrize("silent", [[0], [0, 1], [5], [0, 5]])
def test_channels_that_are_silent_hide_no_unfinished_copy(tmp_path: Path, silent: list[int]) -> None:
    """A block that begins amid a frame leaves nothing of it where just the channels before are silent."""
    path, samples = tmp_path / "film.wav", loud(6)
    samples[:, silent] = 0.0
    soundfile.write(path, samples, RATE_HZ, format="WAV", subtype="PCM_16")
    whole = path.read_bytes()
    for block in range(20, 32):
        path.write_bytes(whole[: block * BLOCK] + bytes(len(whole) - block * BLOCK))
        (one,) = read(path)[1].warnings
        assert ", which last to the end, for " in one


@pytest.mark.parametrize(("container", "subtype", "channels"), FILES)
def test_zeros_to_the_end_from_anywhere_else_are_meant(
    tmp_path: Path, container: str, subtype: str, channels: int
) -> None:
    film = Film(tmp_path / "film.sound", container, subtype, channels)
    start = film.block_at(0.5 * SECONDS)
    for off in (film.frame_bytes, BLOCK // 2, *np.random.default_rng(3).integers(64, BLOCK - 64, 3).tolist()):
        assert film.losing(start + off) == []


@pytest.mark.parametrize(("container", "subtype", "channels"), FILES)
def test_a_long_hole_is_told_where_it_begins_and_ends_with_blocks(
    tmp_path: Path, container: str, subtype: str, channels: int
) -> None:
    film = Film(tmp_path / "film.sound", container, subtype, channels)
    start, stop = film.block_at(2.3), film.block_at(6.3) + BLOCK
    (one,) = film.losing(start, stop)
    told = r"the sound breaks off into zeros once and comes back as abruptly, first at (\S+) s: .*, (\S+) s in all"
    found = re.fullmatch(told, one)
    assert found
    assert float(found[1]) == pytest.approx(film.second_of(start), abs=0.001)
    assert float(found[2]) == pytest.approx((stop - start) / film.frame_bytes / RATE_HZ, abs=0.001)
    assert film.losing(start + BLOCK // 2, stop) == []
    assert film.losing(start, stop - BLOCK // 2) == []


def test_a_fade_into_long_zeros_is_meant(tmp_path: Path) -> None:
    """A block may begin just where a fade has ended."""
    film = Film(tmp_path / "film.wav", "WAV", "PCM_16", 2)
    for start in map(film.block_at, (2.0, 4.0)):
        frame = (start - film.first_byte) // film.frame_bytes
        samples = loud(2)
        samples[frame - 480 : frame] *= np.linspace(1.0, 0.0, 482)[1:-1, None]
        samples[frame:] = 0.0
        soundfile.write(film.path, samples, RATE_HZ, format="WAV", subtype="PCM_16")
        assert read(film.path)[1].warnings == ()


def test_where_the_samples_lie_in_a_film_is_not_known(tmp_path: Path) -> None:
    samples = loud(2).astype(np.float32)
    samples[60 * 1_024 :] = 0.0
    path = write_media(tmp_path / "film.mov", [samples], codec="pcm_s16le", rate_hz=RATE_HZ)
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize("size", [1, 7, 1_000, 1_024, 9_001])
@pytest.mark.parametrize("first_byte", [0, 44, 4_090])
def test_the_blocks_that_sound_is_read_in_change_nothing(size: int, first_byte: int) -> None:
    rate_hz, channels = 1_000, 3  # three seconds are 3,000 frames
    stored = Stored(first_byte, 2 * channels)
    data = bytearray(first_byte) + (loud(channels, 30_000) * 32_768).astype("<i2").tobytes()
    for start, stop in ((3 * BLOCK, 8 * BLOCK), (15 * BLOCK, 16 * BLOCK), (40 * BLOCK, len(data))):
        data[start:stop] = bytes(stop - start)
    whole = np.frombuffer(bytes(data), "<i2", offset=first_byte).reshape(-1, channels)
    samples = (whole / 32_768).astype(np.float32)
    seen = Dropouts(rate_hz, stored)
    for start in range(0, len(samples), size):
        seen.hear(samples[start : start + size])
    hole, end = seen.warnings()
    assert "2 times" in hole
    assert f"first at {-(-(3 * BLOCK - first_byte) // stored.frame_bytes) / rate_hz:.3f} s" in hole
    assert f"at {-(-(40 * BLOCK - first_byte) // stored.frame_bytes) / rate_hz:.3f} s, which last to the end" in end


@pytest.mark.parametrize(("second", "told"), [(2.0, False), (3.0, False), (2.0 + 128 / 48_000, True)])
def test_a_cut_on_a_whole_second_is_meant_though_blocks_begin_there(second: float, told: bool) -> None:
    """Samples of 32 bytes from byte 4096 on have a block on each second of 48 kHz."""
    samples = np.full((48_000 * 5, 8), 0.3, np.float32)
    samples[round(second * 48_000) :] = 0.0
    seen = Dropouts(48_000, Stored(BLOCK, 32))
    seen.hear(samples)
    assert bool(list(seen.warnings())) == told
