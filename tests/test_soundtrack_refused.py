"""What cannot be read, or changes while it is read, is one clear line."""

import gc
import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.errors import RuleError, SoundtrackError
from blastline.model import Span
from blastline.soundtrack import Soundtrack, open_soundtrack
from blastline.timebase import Timebase
from sound_files import FRAMES, RATE_HZ, noise, read, wav


def _grow(path: Path) -> None:
    with path.open("ab") as file:
        file.write(bytes(1000))


def _shrink(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def _replace(path: Path) -> None:
    other = path.with_name("other")
    other.write_bytes(path.read_bytes()[::-1])
    other.replace(path)


def _read_on(track: Soundtrack, path: Path, change: Callable[[Path], None]) -> None:
    blocks = track.blocks()
    next(blocks)
    change(path)
    list(blocks)
    track.source()


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
@pytest.mark.parametrize("change", [_grow, _shrink, _replace, Path.unlink])
def test_a_file_that_changes_while_it_is_read_is_refused(
    tmp_path: Path, suffix: str, change: Callable[[Path], None]
) -> None:
    """Else its digest would be that of another sound than was heard, and its length that of neither."""
    path = tmp_path / f"film{suffix}"
    soundfile.write(path, noise(400_000), RATE_HZ, subtype="PCM_16")
    with open_soundtrack(path) as track, pytest.raises(SoundtrackError, match=f"film{suffix}: "):
        _read_on(track, path, change)


@pytest.mark.parametrize("change", [_grow, _shrink, _replace, Path.unlink])
def test_a_file_that_changes_before_it_is_read_again_is_refused(tmp_path: Path, change: Callable[[Path], None]) -> None:
    path = wav(tmp_path / "film.wav", noise())
    with open_soundtrack(path) as track:
        list(track.blocks())
        change(path)
        with pytest.raises(SoundtrackError, match=r"film\.wav: (was changed|is gone) while it is read"):
            track.read(Span(0, 10))


@pytest.mark.parametrize("share", [0.05, 0.2, 1.0])
def test_a_film_that_is_mostly_no_number_is_refused(tmp_path: Path, share: float) -> None:
    samples = noise()
    samples[: round(share * FRAMES)] = np.nan
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    if share < 0.1:
        assert "NaN" in read(path)[1].warnings[0]
        return
    with pytest.raises(SoundtrackError, match=r"film\.wav: \d+ of 70000 samples are NaN"):
        read(path)


def test_what_is_no_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "empty.wav").touch()
    for name, message in ((".", "is a folder"), ("nowhere.wav", "no such file"), ("empty.wav", "is empty")):
        with pytest.raises(SoundtrackError, match=message) as caught:
            open_soundtrack(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path / name))
        assert "\n" not in str(caught.value)
    with pytest.raises(SoundtrackError, match="cannot be read: File name too long"):
        open_soundtrack(tmp_path / ("x" * 5000))


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the administrator may read everything")
def test_a_file_without_permission_is_one_line(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(10))
    path.chmod(0)
    with pytest.raises(SoundtrackError, match="cannot be read: Permission denied"):
        open_soundtrack(path)


@pytest.mark.parametrize("head", [b"", b"RIFF", b"RF64", b"riff", b"FORM", b"caff", b"fLaC", b"ffconcat version 1.0\n"])
def test_garbage_is_refused(tmp_path: Path, head: bytes) -> None:
    path = tmp_path / "film.wav"
    for seed in range(5):
        path.write_bytes(head + np.random.default_rng(seed).bytes(5000))
        with pytest.raises(SoundtrackError, match=r"film\.wav: "):
            open_soundtrack(path)


def test_a_track_without_samples_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SoundtrackError, match="no sound"):
        open_soundtrack(wav(tmp_path / "film.wav", noise(0)))


@pytest.mark.parametrize("rate_hz", [4_000, 500_000])
def test_a_sample_rate_beyond_reason_is_refused(tmp_path: Path, rate_hz: int) -> None:
    with pytest.raises(SoundtrackError, match=f"sample rate is {rate_hz} Hz; expected 8000 to 384000 Hz"):
        open_soundtrack(wav(tmp_path / "film.wav", noise(10), rate_hz=rate_hz))


@pytest.mark.parametrize("rate_hz", [8_000, 384_000])
def test_the_slowest_and_the_fastest_sound_are_read(tmp_path: Path, rate_hz: int) -> None:
    assert read(wav(tmp_path / "film.wav", noise(10), rate_hz=rate_hz))[1].sample_rate_hz == rate_hz


def test_streams_and_channels_that_are_not_there_are_refused(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(10, 2))
    with pytest.raises(SoundtrackError, match=r"film\.wav: has no sound stream 1; it has 0 \(2 channels\)"):
        open_soundtrack(path, stream=1)
    with pytest.raises(SoundtrackError, match=r"film\.wav: mix '2': there is no channel 2; the sound has 2"):
        open_soundtrack(path, mix="2")
    many = wav(tmp_path / "many.wav", noise(10, 12))
    with pytest.raises(SoundtrackError, match="does not say what its 12 channels are"):
        open_soundtrack(many)
    assert read(many, mix="11")[0].shape == (10, 1)


def test_nothing_stays_open_of_a_film_whose_timecode_cannot_be_counted(tmp_path: Path) -> None:
    """Of compressed sound there is a temporary file already by then."""
    path = tmp_path / "film.flac"
    soundfile.write(path, noise(1000, 2), RATE_HZ)
    with warnings.catch_warnings(record=True) as left_open:
        warnings.simplefilter("always")
        with pytest.raises(RuleError, match="the film has no frame rate"):
            open_soundtrack(path, timebase=Timebase(start_timecode="01:00:00:00"))
        gc.collect()
    assert [str(each.message) for each in left_open] == []


def test_a_name_that_is_no_text_is_refused() -> None:
    with pytest.raises(SoundtrackError, match="the name is not valid UTF-8; rename the file"):
        open_soundtrack(Path("bad\udcff.wav"))
