"""The drive as other programs read it: samples, markers, time of day, size."""

import errno
import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import soundfile
import wavinfo
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray

from blastline.errors import OutputError
from blastline.model import Clip, Span
from blastline.soundtrack import Cue, open_soundtrack, write_drive
from blastline.soundtrack.bwf import cue_chunks, written_cues

RATE_HZ = 48_000


def clip(samples: ArrayLike, start: int = 0, rate_hz: int = RATE_HZ) -> Clip:
    return Clip(np.asarray(samples, dtype=np.float64).reshape(-1, 1), rate_hz, start)


def steps(count: int, seed: int = 0) -> NDArray[np.float64]:
    """Return random values that 24 bits hold exactly."""
    return np.random.default_rng(seed).integers(-(2**23), 2**23, count) / 2**23


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "drive.wav"


def test_24_bit_samples_survive_and_the_rest_is_zero(path: Path) -> None:
    first, second = steps(1000), steps(70_000, seed=1)
    write_drive(path, [clip(first, 500), clip(second, 1500)], rate_hz=RATE_HZ, frames=100_001)
    samples, rate_hz = soundfile.read(path)
    expected = np.zeros(100_001)
    expected[500:1500], expected[1500:71_500] = first, second
    assert rate_hz == RATE_HZ
    np.testing.assert_array_equal(samples, expected)
    info = soundfile.info(path)
    assert (info.format, info.subtype, info.channels) == ("WAV", "PCM_24", 1)


@pytest.mark.parametrize("cues", [(), (Cue(300_000, "g0001"),)])
def test_holes_read_as_the_zeros_they_stand_for(path: Path, cues: tuple[Cue, ...]) -> None:
    drive = [clip(steps(1000), 500), clip(steps(9, seed=1), 399_990), clip(steps(70_000, seed=2), 500_000)]
    write_drive(path, drive, rate_hz=RATE_HZ, frames=900_001, cues=cues)
    whole = path.with_name("whole.wav")
    whole.write_bytes(path.read_bytes())
    with open_soundtrack(path) as sparse, open_soundtrack(whole) as dense:
        for one, other in zip(sparse.blocks(), dense.blocks(), strict=True):
            np.testing.assert_array_equal(one.samples, other.samples)
        for start, stop in [(0, 500), (499, 501), (1500, 399_990), (399_000, 399_991), (900_000, 900_001)]:
            span = Span(start, stop)
            np.testing.assert_array_equal(sparse.read(span).samples, dense.read(span).samples)
        assert np.count_nonzero(sparse.read(Span(0, 900_001)).samples) > 71_000


def test_one_is_the_top_step_and_only_there_is_anything_clipped(path: Path) -> None:
    values = [1.0, 1.0 - 2**-23, -1.0, 0.4 * 2**-23, 0.6 * 2**-23]
    write_drive(path, [clip(values)], rate_hz=RATE_HZ, frames=5)
    np.testing.assert_array_equal(soundfile.read(path)[0] * 2**23, [8_388_607, 8_388_607, -8_388_608, 0, 1])


@pytest.mark.parametrize("value", [1.0 + 2**-22, -1.0 - 2**-22, np.nan, np.inf, 5.0])
def test_a_sample_beyond_the_limit_is_a_mistake_and_is_named(path: Path, value: float) -> None:
    with pytest.raises(ValueError, match="at sample 12; expected -1 to 1"):
        write_drive(path, [clip([0.0, 0.0, value], 10)], rate_hz=RATE_HZ, frames=20)


@pytest.mark.parametrize(
    "clips",
    [
        [clip([0.0] * 5, 10), clip([0.0] * 5, 14)],
        [clip([0.0] * 5, 10), clip([0.0] * 5, 0)],
        [clip([0.0] * 5, 96)],
        [clip([0.0] * 5, -1)],
        [clip([0.0] * 5, 0, rate_hz=44_100)],
    ],
)
def test_a_clip_out_of_place_is_a_mistake(path: Path, clips: list[Clip]) -> None:
    with pytest.raises(ValueError, match="does not follow"):
        write_drive(path, clips, rate_hz=RATE_HZ, frames=100)


def test_the_last_column_is_written(path: Path) -> None:
    columns = np.stack([np.full(10, 0.25), np.full(10, 0.5)], axis=1)
    write_drive(path, [Clip(columns, RATE_HZ, 0)], rate_hz=RATE_HZ, frames=10)
    np.testing.assert_array_equal(soundfile.read(path)[0], 0.5)


@pytest.mark.parametrize("frames", [1000, 1001])
@pytest.mark.parametrize("riff_limit", [0xFFFFFFFF, 500])
def test_markers_ranges_and_time_of_day_are_read_back(path: Path, frames: int, riff_limit: int) -> None:
    cues = [Cue(0, "shot 1", 300), Cue(500, "shot 2, burst 1", 24), Cue(999, "end")]
    write_drive(
        path,
        [clip(steps(10), 20)],
        rate_hz=RATE_HZ,
        frames=frames,
        time_reference=2**33 + 5,
        cues=cues,
        description="reel 1",
        riff_limit=riff_limit,
    )
    info = wavinfo.WavInfoReader(str(path))
    assert info.bext is not None
    assert (info.bext.originator, info.bext.description) == ("blastline", "reel 1")
    assert (info.bext.time_reference, info.bext.version) == (2**33 + 5, 1)
    assert info.cues is not None
    assert [cue.position for cue in info.cues.cues] == [0, 500, 999]
    assert [info.cues.label_and_note(cue.name)[0] for cue in info.cues.cues] == [cue.label for cue in cues]
    assert [info.cues.range(cue.name) for cue in info.cues.cues] == [300, 24, None]
    assert (info.data.byte_count, info.data.frame_count) == (3 * frames, frames)
    assert (info.fmt.sample_rate, info.fmt.bits_per_sample, info.fmt.channel_count) == (RATE_HZ, 24, 1)
    assert soundfile.info(path).frames == frames


@pytest.mark.parametrize("riff_limit", [0xFFFFFFFF, 500])
@pytest.mark.parametrize(
    "cues", [[], [Cue(0, "odd", 1)], [Cue(1, "shot-0001"), Cue(7, "Tür 2", 300), Cue(999, "x" * 99)]]
)
def test_the_markers_of_a_drive_are_told_as_long_as_nobody_else_saved_it(
    path: Path, riff_limit: int, cues: list[Cue]
) -> None:
    for frames in (999, 1000):
        write = partial(write_drive, path, rate_hz=RATE_HZ, frames=frames, cues=cues, riff_limit=riff_limit)
        write([clip(steps(10), 20)], time_reference=2**33 + 5, description="vibration drive for seat")
        assert written_cues(path) == tuple(cues)
        whole = path.read_bytes()
        place = whole.index(b"bext") + 8
        for other in (
            whole[:-1],
            whole + b"LIST\4\0\0\0INFO",
            whole[: place + 320] + b"2026-11-30" + whole[place + 330 :],
            whole[: place - 8] + b"JUNK\4\0\0\0abcd" + whole[place - 8 :],
            whole[:40],
            b"",
        ):
            path.write_bytes(other)
            assert written_cues(path) is None
    soundfile.write(path, steps(10), RATE_HZ, subtype="PCM_24")
    assert written_cues(path) is None
    assert written_cues(path.with_name("none.wav")) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_into_which_nobody_writes_is_not_waited_for(path: Path) -> None:
    os.mkfifo(path)
    assert written_cues(path) is None


@pytest.mark.parametrize("riff_limit", [0xFFFFFFFF, 500])
def test_the_declared_size_is_the_size_of_the_file(path: Path, riff_limit: int) -> None:
    for frames in (0, 1, 2, 999):
        write_drive(path, [], rate_hz=RATE_HZ, frames=frames, cues=[Cue(0, "odd", 1)], riff_limit=riff_limit)
        data = path.read_bytes()
        is_rf64 = data[:4] == b"RF64"
        assert is_rf64 == (riff_limit == 500)
        declared = int.from_bytes(data[20:28], "little") if is_rf64 else int.from_bytes(data[4:8], "little")
        assert declared + 8 == len(data)
        assert len(data) % 2 == 0


def test_rf64_holds_the_same_samples(path: Path) -> None:
    values = steps(5000)
    write_drive(path, [clip(values, 1)], rate_hz=RATE_HZ, frames=6000, riff_limit=1000)
    assert soundfile.info(path).format == "RF64"
    np.testing.assert_array_equal(soundfile.read(path)[0][1:5001], values)


def test_beyond_4_gib_it_is_rf64_and_silence_takes_no_room(path: Path) -> None:
    frames = 1_500_000_000  # 8.7 hours
    with path.open("wb") as probe:
        probe.truncate(1 << 22)
    if path.stat().st_blocks > 64:
        pytest.skip("this file system keeps no holes")
    write_drive(
        path, [clip([0.5, -0.5], frames - 2)], rate_hz=RATE_HZ, frames=frames, cues=[Cue(frames - 2, "last", 2)]
    )
    assert path.stat().st_size > 2**32
    assert path.stat().st_blocks * 512 < 1 << 20
    with soundfile.SoundFile(path) as file:
        assert (file.frames, file.format) == (frames, "RF64")
        file.seek(frames - 3)
        np.testing.assert_array_equal(file.read(3), [0.0, 0.5, -0.5])
    info = wavinfo.WavInfoReader(str(path))
    assert info.cues is not None
    [last] = info.cues.cues
    assert (last.position, info.cues.label_and_note(last.name)[0], info.cues.range(last.name)) == (
        frames - 2,
        "last",
        2,
    )
    assert info.data.frame_count == frames


def test_a_marker_later_than_32_bits_is_left_out(path: Path) -> None:
    frames = 2**32 + 10
    with path.open("wb") as probe:
        probe.truncate(1 << 22)
    if path.stat().st_blocks > 64:
        pytest.skip("this file system keeps no holes")
    cues = [Cue(2**32 - 1, "last that fits", 5), Cue(2**32, "one later")]
    write_drive(path, [clip([0.5], 2**32)], rate_hz=RATE_HZ, frames=frames, cues=cues)
    info = wavinfo.WavInfoReader(str(path))
    assert info.cues is not None
    assert [(cue.position, info.cues.label_and_note(cue.name)[0]) for cue in info.cues.cues] == [
        (2**32 - 1, "last that fits")
    ]
    assert soundfile.info(path).frames == frames


def test_the_same_drive_is_the_same_file(tmp_path: Path) -> None:
    for name in ("a.wav", "b.wav"):
        write_drive(tmp_path / name, [clip(steps(10))], rate_hz=RATE_HZ, frames=10, cues=[Cue(1, "shot")])
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 200), st.integers(0, 200)), max_size=6), st.integers(0, 50))
def test_however_the_drive_is_cut_it_is_the_same_sound(
    tmp_path_factory: pytest.TempPathFactory, pieces: list[tuple[int, int]], rest: int
) -> None:
    path = tmp_path_factory.mktemp("cut") / "drive.wav"
    expected: list[NDArray[np.float64]] = []
    clips: list[Clip] = []
    place = 0
    for gap, length in pieces:
        expected += [np.zeros(gap), steps(length, seed=place)]
        clips.append(clip(expected[-1], place + gap))
        place += gap + length
    write_drive(path, clips, rate_hz=RATE_HZ, frames=place + rest)
    np.testing.assert_array_equal(soundfile.read(path)[0], np.concatenate([*expected, np.zeros(rest)]))


def test_a_cue_outside_the_drive_is_a_mistake(path: Path) -> None:
    with pytest.raises(ValueError, match="cue"):
        write_drive(path, [], rate_hz=RATE_HZ, frames=10, cues=[Cue(11, "late")])


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"nowhere.*cannot write the drive: No such file"):
        write_drive(tmp_path / "nowhere" / "drive.wav", [], rate_hz=RATE_HZ, frames=10)


def test_who_closes_the_pipe_that_progress_is_told_through_is_not_told_of_a_bad_file(path: Path) -> None:
    def telling() -> Iterator[Clip]:
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")
        yield

    with pytest.raises(BrokenPipeError):
        write_drive(path, telling(), rate_hz=RATE_HZ, frames=10)


def test_a_region_that_is_longer_than_the_format_counts_is_as_long_as_it_can_be() -> None:
    assert cue_chunks([Cue(1, "a film in itself", 2**33)]) == cue_chunks([Cue(1, "a film in itself", 2**32 - 1)])
