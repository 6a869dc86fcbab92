"""Uncompressed files: every sample exact, block and cut the same, and what is odd in them told."""

import struct
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.model import Clip, Span
from blastline.soundtrack import Cue, open_soundtrack, write_drive
from blastline.soundtrack.cancelling import Cancelling
from blastline.soundtrack.recent import Recent
from blastline.soundtrack.track import in_blocks
from blastline.timecode import clock, timecode_at
from sound_files import FORMATS, FRAMES, RATE_HZ, noise, read, wav


@pytest.mark.parametrize(("container", "subtype"), FORMATS)
@pytest.mark.parametrize("channels", [1, 2, 6])
def test_every_sample_is_what_libsndfile_reads(tmp_path: Path, container: str, subtype: str, channels: int) -> None:
    path = tmp_path / "film.sound"  # the name does not matter
    soundfile.write(path, noise(channels=channels), RATE_HZ, format=container, subtype=subtype)
    expected = soundfile.read(path, dtype="float32", always_2d=True)[0]
    for channel in {0, channels - 1}:
        with open_soundtrack(path, mix=str(channel)) as track:
            assert (track.rate_hz, track.channels, track.columns) == (RATE_HZ, channels, 1)
            assert track.expected_frames == FRAMES
            samples = np.concatenate([block.samples for block in track.blocks(9999)])
            np.testing.assert_array_equal(samples[:, 0], expected[:, channel])
            cut = track.read(Span(123, 66_000))
            assert cut.start == 123
            assert cut.samples.dtype == np.float64
            np.testing.assert_array_equal(cut.samples, samples[123:66_000].astype(np.float64))
            assert track.source().warnings == ()
            assert track.source().frames == FRAMES


@pytest.mark.parametrize("at", [0, 65_535, 65_536, FRAMES - 1])
@pytest.mark.parametrize("sample", [1, -1, 0x10000, -0x800000])
def test_one_sample_amid_silence_is_read_as_it_is(tmp_path: Path, at: int, sample: int) -> None:
    samples = np.zeros((FRAMES, 2), np.int32)
    samples[at, 1] = sample << 8
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_24")
    with open_soundtrack(path, mix="1") as track:
        read_samples = np.concatenate([block.samples[:, 0] for block in track.blocks()])
    assert np.flatnonzero(read_samples).tolist() == [at]
    assert read_samples[at] * 2.0**23 == sample


@pytest.mark.parametrize("subtype", ["PCM_16", "FLOAT"])
@pytest.mark.parametrize("mix", ["mains", "all", "lfe", "1,4"])
def test_the_size_of_the_blocks_changes_no_bit(tmp_path: Path, subtype: str, mix: str) -> None:
    path = wav(tmp_path / "film.wav", noise(channels=6), subtype=subtype)
    whole, source = read(path, mix=mix, frames=FRAMES)
    for frames in (7, 4096, 65_536, 65_537, 10 * FRAMES):
        np.testing.assert_array_equal(read(path, mix=mix, frames=frames)[0], whole)
    short = wav(tmp_path / "short.wav", noise(300, 6), subtype=subtype)
    np.testing.assert_array_equal(read(short, mix=mix, frames=1)[0], read(short, mix=mix)[0])
    with open_soundtrack(path, mix=mix) as track:
        assert track.columns == whole.shape[1] == (2 if mix in ("all", "lfe") else 1)
        assert sum(len(block.span) for block in track.blocks()) == source.frames == FRAMES
        for span in (Span(0, FRAMES), Span(5, 6), Span(65_530, 65_540), Span(FRAMES, FRAMES)):
            np.testing.assert_array_equal(track.read(span).samples, whole[span.start : span.stop])


@pytest.mark.parametrize("frames", [1, 4, 7, 100])
@pytest.mark.parametrize("sizes", [[], [3], [4], [1, 1, 1, 1, 1], [10, 3, 9], [0, 5, 0, 3], [7, 7], [6, 1, 6, 1]])
def test_blocks_hold_all_samples_once_and_all_but_the_last_are_whole(frames: int, sizes: list[int]) -> None:
    whole = np.arange(sum(sizes), dtype=np.float32)[:, None]
    blocks = list(in_blocks(np.split(whole, np.cumsum(sizes)), frames))
    assert all(len(block) == frames for block in blocks[:-1])
    assert all(0 < len(block) <= frames for block in blocks[-1:])
    np.testing.assert_array_equal(np.concatenate([whole[:0], *blocks]), whole)


def test_mono_is_stereo_with_equal_channels(tmp_path: Path) -> None:
    mono = noise()
    one, _ = read(wav(tmp_path / "mono.wav", mono))
    two, _ = read(wav(tmp_path / "stereo.wav", np.repeat(mono, 2, axis=1)))
    np.testing.assert_array_equal(one, two)


def test_the_channel_mask_names_the_channels(tmp_path: Path) -> None:
    samples = noise(100, 3)
    path = tmp_path / "film.wav"
    data = samples.astype("<f4").tobytes()
    mask_fl_fr_lfe = 0b1011
    guid = struct.pack("<HHIQ", 3, 0, 0x00100000, 0x719B3800AA000080)
    fmt = struct.pack("<HHIIHHHHI", 0xFFFE, 3, RATE_HZ, 12 * RATE_HZ, 12, 32, 22, 32, mask_fl_fr_lfe) + guid
    body = b"WAVEfmt " + struct.pack("<I", len(fmt)) + fmt + b"data" + struct.pack("<I", len(data)) + data
    path.write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    np.testing.assert_allclose(read(path)[0][:, 0], samples[:, :2].mean(axis=1), atol=1e-6)
    assert read(path, mix="lfe")[0].shape == (100, 2)


@pytest.mark.parametrize(("form", "order"), [(b"RIFF", "<"), (b"RIFX", ">")])
def test_the_channel_mask_is_read_in_its_byte_order(tmp_path: Path, form: bytes, order: str) -> None:
    """Left, right, centre and a single surround, not the two pairs that four channels without names are taken for."""
    kind = struct.pack(f"{order}IHH", 1, 0, 16) + b"\x80\x00\x00\xaa\x00\x38\x9b\x71"
    fmt = struct.pack(f"{order}HHIIHHHHI", 0xFFFE, 4, RATE_HZ, 8 * RATE_HZ, 8, 16, 22, 16, 0x107) + kind
    samples = np.zeros((480, 4), f"{order}i2")
    samples[:, 2] = 16_384
    body = b"WAVE" + b"".join(
        name + struct.pack(f"{order}I", len(chunk)) + chunk
        for name, chunk in ((b"fmt ", fmt), (b"data", samples.tobytes()))
    )
    path = tmp_path / "film.wav"
    path.write_bytes(form + struct.pack(f"{order}I", len(body)) + body)
    for mix in ("mains", "center"):
        np.testing.assert_array_equal(read(path, mix=mix)[0], np.full((480, 1), 0.5, np.float32))


def test_samples_that_are_no_sound_are_set_to_zero_and_counted(tmp_path: Path) -> None:
    samples = noise(channels=2)
    samples[1234:1236, 0] = np.nan, np.inf
    samples[65_540, 1] = -np.inf
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    found, source = read(path, mix="0")
    assert source.warnings == ("3 samples were NaN, infinite or beyond 1e9, and were set to 0, first at sample 1234",)
    np.testing.assert_array_equal(found[1234:1236], 0.0)
    np.testing.assert_array_equal(found[1236:], samples[1236:, :1].astype(np.float32))
    with open_soundtrack(path) as track:
        mixed = np.concatenate([block.samples for block in track.blocks(999)])
        np.testing.assert_array_equal(track.read(Span(1000, 66_000)).samples, mixed[1000:66_000])
        assert np.isfinite(mixed).all()
        assert len(track.source().warnings) == 1


@pytest.mark.parametrize("absurd", [np.nan, np.inf, -np.inf, 3e38, -3e38, 2e9, -2e9])
def test_one_absurd_sample_anywhere_is_found(tmp_path: Path, absurd: float) -> None:
    samples = noise(200_000)
    samples[150_000] = absurd
    found, source = read(wav(tmp_path / "film.wav", samples, subtype="FLOAT"))
    samples[150_000] = 0.0
    np.testing.assert_array_equal(found, samples.astype(np.float32))
    assert source.warnings == ("1 sample was NaN, infinite or beyond 1e9, and was set to 0, first at sample 150000",)


@pytest.mark.parametrize(("scale", "warned"), [(1.0, False), (10.0, False), (2.0**15, True), (2.0**31 / 10.0, True)])
@pytest.mark.parametrize("at", [10, 70_000])
def test_sound_of_another_scale_is_told(tmp_path: Path, scale: float, warned: bool, at: int) -> None:
    """Programs that store whole numbers as they are in a file of floats make a film 90 dB too loud."""
    samples = np.zeros((80_000, 2))
    samples[at:, 1] = 0.5 * scale
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    found, source = read(path, mix="1")
    np.testing.assert_array_equal(found[:, 0], samples[:, 1].astype(np.float32))
    above_db = 20.0 * np.log10(0.5 * scale)
    told = f"samples reach {0.5 * scale:.6g}, {above_db:.0f} dB above full scale; expected -1 to 1"
    assert [line.split(":")[0] for line in source.warnings] == ([told] if warned else [])
    assert all(line.endswith(f"first at sample {at}") for line in source.warnings)


def test_a_sample_that_is_no_number_hides_no_sound_of_another_scale(tmp_path: Path) -> None:
    samples = np.zeros((80_000, 1))
    samples[70_000:] = 16_384.0
    samples[69_990] = np.nan
    _, source = read(wav(tmp_path / "film.wav", samples, subtype="FLOAT"))
    assert [line.split(" ")[:3] for line in source.warnings] == [["1", "sample", "was"], ["samples", "reach", "16384,"]]


def test_the_time_of_day_goes_through_reader_and_writer(tmp_path: Path) -> None:
    path = tmp_path / "film.wav"
    blast = Clip(np.full((10, 1), 0.5), RATE_HZ, 100)
    write_drive(path, [blast], rate_hz=RATE_HZ, frames=FRAMES, time_reference=172_800_480, cues=[Cue(100, "shot", 10)])
    with open_soundtrack(path) as track:
        assert track.time_reference == 172_800_480
        samples = np.concatenate([block.samples for block in track.blocks()])
        source = track.source()
    assert samples.shape == (FRAMES, 1)
    assert np.flatnonzero(samples).tolist() == list(range(100, 110))
    assert (source.start_timecode, source.frame_rate) == ("01:00:00.010000", None)
    assert timecode_at(source, 48) == "01:00:00.011"


def test_source_names_the_file_and_its_digest(tmp_path: Path) -> None:
    source = read(wav(tmp_path / "film.wav", np.zeros((480, 1))))[1]
    assert (source.name, source.channels, source.stream, source.mix) == ("film.wav", 1, 0, "mains")
    assert source.sha256 == read(wav(tmp_path / "copy.wav", np.zeros((480, 1))))[1].sha256
    assert source.sha256 != read(wav(tmp_path / "other.wav", np.ones((480, 1))))[1].sha256


CANCELLING = [
    ([0, 0, 0, 0, 1, -1], "mains", True, True),
    ([1, -1, 0, 0, 0, 0], "mains", True, True),
    ([0, 0, 0, 0, 1, 1], "mains", True, False),
    ([0, 0, 0, 0, 1, -1], "4", True, False),
    ([0, 0, 1, 0, 1, -1], "mains", True, False),  # the centre plays on
    ([1, -1], "mains", False, True),
    ([1, -1], "mains", True, False),  # heard in the sides
    ([1, -1], "0,1", True, True),  # a mix that names its channels has none
    ([1, 1], "mains", False, False),
]


def test_a_film_that_is_silent_throughout_is_told(tmp_path: Path) -> None:
    still = np.zeros((70_000, 2))
    assert read(wav(tmp_path / "still.wav", still))[1].warnings == ("sound stream 0 is silent from beginning to end",)
    still[-1, 1] = 1e-4
    assert not read(wav(tmp_path / "last.wav", still))[1].warnings


@pytest.mark.parametrize("mix", ["mains", "1"])
def test_a_constant_is_no_sound(tmp_path: Path, mix: str) -> None:
    still = np.tile([0.0, 0.25], (70_000, 1))
    silent = wav(tmp_path / "still.wav", still)
    assert read(silent, mix=mix)[1].warnings == ("sound stream 0 is silent from beginning to end",)
    still[-1, 1] += 1e-4
    assert not read(wav(tmp_path / "last.wav", still), mix=mix)[1].warnings


def test_a_silent_channel_that_drives_is_told_though_what_is_heard_is_not(tmp_path: Path) -> None:
    sounding = np.random.default_rng(1).uniform(-0.3, 0.3, (4_800, 6))
    sounding[:, 3] = 0
    path = wav(tmp_path / "film.wav", sounding)
    assert any("mix lfe is silent" in line for line in read(path, mix="lfe")[1].warnings)
    assert not read(path, mix="all")[1].warnings


@pytest.mark.parametrize(("other", "warned"), [(-1.0, True), (-0.999, False), (0.0, False)])
def test_a_mix_that_is_silent_though_the_film_is_not_is_told(tmp_path: Path, other: float, warned: bool) -> None:
    """Since its channels cancel, or since the one that is asked for does not sound."""
    path = wav(tmp_path / "film.wav", noise() @ [[1.0, other]], subtype="FLOAT")
    assert any("mix mains is silent" in line for line in read(path)[1].warnings) == warned
    assert any("mix 1 is silent" in line for line in read(path, mix="1")[1].warnings) == (other == 0.0)


@pytest.mark.parametrize(("behind", "mix", "sides", "told"), CANCELLING)
def test_what_the_channels_of_a_mix_cancel_is_told(
    tmp_path: Path, behind: list[float], mix: str, *, sides: bool, told: bool
) -> None:
    """A quarter of a second, from second 1 on, in which two channels play one noise over a soft bed."""
    rng = np.random.default_rng(1)
    film = 1e-3 * rng.standard_normal((2 * RATE_HZ, len(behind)))
    film[RATE_HZ : RATE_HZ * 5 // 4] += 0.2 * rng.standard_normal((RATE_HZ // 4, 1)) * behind
    with open_soundtrack(wav(tmp_path / "film.wav", film), mix=mix) as track:
        list(track.blocks(sides=sides))
        lines = [line for line in track.source().warnings if "cancel" in line]
    assert bool(lines) == told
    assert all(f"mix {mix} cancel for 0.25 s, first at 1.00 s: what they play" in line for line in lines)


@pytest.mark.parametrize("size", [1, 100, 2_400, 7_201])
def test_what_cancels_is_found_in_blocks_of_any_size(size: int) -> None:
    weights, rng = np.array([0.7, 0.7, 0.5], np.float32), np.random.default_rng(1)
    film = 0.1 * rng.standard_normal((24_000, 3)).astype(np.float32)
    film[4_800:12_000] = film[4_800:12_000, :1] * np.array([1.0, -1.0, 0.0], np.float32)
    seen = Cancelling(weights, RATE_HZ)
    for start in range(0, len(film), size):
        block = film[start : start + size]
        seen.hear(block, np.asarray(block @ weights, np.float32))
    assert [seen.lost_s, seen.first_s] == pytest.approx([0.15, 0.1])


def test_the_order_of_use_is_kept(tmp_path: Path) -> None:
    with open_soundtrack(wav(tmp_path / "film.wav", noise())) as track:
        with pytest.raises(ValueError, match="at least 1 frame"):
            next(track.blocks(0))
        with pytest.raises(ValueError, match="not inside"):
            track.read(Span(0, 1))
        with pytest.raises(ValueError, match="once all blocks"):
            track.source()
        list(track.blocks())
        with pytest.raises(ValueError, match="decoded already"):
            next(track.blocks())
        with pytest.raises(ValueError, match="not inside"):
            track.read(Span(0, FRAMES + 1))


@pytest.mark.parametrize("size", [1, 7, 100, 350])
def test_what_was_decoded_last_can_be_read_again(size: int) -> None:
    samples = np.random.default_rng(size).uniform(-1.0, 1.0, (1000, 3)).astype(np.float32)
    recent = Recent(300)
    for start in range(0, 1000, size):
        recent.append(samples[start : start + size])
        stop = min(start + size, 1000)
        span = Span(max(0, stop - 300), stop)
        there = recent.read(span)
        assert there is not None
        np.testing.assert_allclose(there, samples[span.start : span.stop], rtol=2.0**-7)
        assert recent.read(Span(stop - 1, stop + 1)) is None
    assert recent.read(Span(699, 900)) is None
    assert recent.read(Span(700, 701)) is not None


@pytest.mark.parametrize(("form", "order"), [(b"RIFF", "<"), (b"RIFX", ">")])
@pytest.mark.parametrize("reference", [0, 48_000 * 3_600, 2**33 + 5, 2**64 - 1])
def test_a_time_stamp_is_read_in_its_byte_order_and_none_is_a_week_late(
    tmp_path: Path, form: bytes, order: str, reference: int
) -> None:
    """EBU Tech 3285: TimeReferenceLow, then TimeReferenceHigh, 32 bits each; libsndfile writes a RIFX so, too."""
    bext = bytes(338) + struct.pack(f"{order}II", reference & 0xFFFFFFFF, reference >> 32) + bytes(256)
    fmt = struct.pack(f"{order}HHIIHH", 1, 1, 48_000, 96_000, 2, 16)
    data = np.arange(4_800, dtype=f"{order}i2").tobytes()
    body = b"WAVE" + b"".join(
        name + struct.pack(f"{order}I", len(chunk)) + chunk
        for name, chunk in ((b"bext", bext), (b"fmt ", fmt), (b"data", data))
    )
    path = tmp_path / "film.wav"
    path.write_bytes(form + struct.pack(f"{order}I", len(body)) + body)
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) == 4_800
        source = track.source()
    if reference > 7 * 86_400 * 48_000:
        assert source.start_timecode is None
        assert any("after midnight; it was ignored" in warning for warning in source.warnings)
    else:
        assert source.start_timecode == clock(reference, 48_000, decimals=6)
        assert source.warnings == ()


@pytest.mark.parametrize("frames", [1, 2])
@pytest.mark.parametrize("name", ["film.wav", "film.flac"])
def test_the_shortest_films_are_films(tmp_path: Path, frames: int, name: str) -> None:
    soundfile.write(tmp_path / name, np.full(frames, 0.25), RATE_HZ)
    samples, source = read(tmp_path / name)
    assert (samples.tolist(), source.frames) == ([[0.25]] * frames, frames)
