"""Films and compressed sound: the right delay, nothing lost or shifted, and what is no film refused."""

import errno
import socket
import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from av.stream import Disposition

from blastline.errors import OutputError, SoundtrackError
from blastline.soundtrack import open_soundtrack
from coded_films import FILM_RATE, FRAMES, SHOTS, read, shots_in_film
from media import RATE_HZ, impulses, onsets, write_media

NONE = Disposition(0)
LOSSLESS = [
    ("flac", "flac", 8),
    ("flac", "mkv", 6),
    ("flac", "mp4", 2),
    ("alac", "m4a", 6),
    ("pcm_s16le", "mov", 8),
    ("pcm_s24le", "mkv", 8),
    ("pcm_s16be", "mov", 1),
    ("pcm_f32le", "mkv", 6),
]
LOSSY = [
    ("aac", "mp4", 8),  # planar 7.1
    ("aac", "mov", 1),
    ("aac", "mkv", 6),
    ("aac", "ts", 2),
    ("ac3", "mp4", 2),
    ("ac3", "mkv", 6),
    ("ac3", "ts", 6),
    ("eac3", "mkv", 6),
    ("eac3", "mp4", 1),
    ("libopus", "mkv", 8),
    ("libopus", "ogg", 2),
    ("libmp3lame", "mp3", 2),
    ("pcm_mulaw", "wav", 1),
    ("adpcm_ms", "wav", 2),
]
WITH_PICTURE = ("mkv", "mp4", "mov", "ts")


@pytest.mark.parametrize(("codec", "extension", "channels"), LOSSLESS)
def test_lossless_sound_is_exact(tmp_path: Path, codec: str, extension: str, channels: int) -> None:
    written = impulses(FRAMES, SHOTS, channels=channels)
    written[:, -1] *= -1.0
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec)
    for channel in {0, channels - 1}:
        samples, source = read(path, mix=str(channel))
        np.testing.assert_array_equal(samples[:, 0], written[:, channel])
        assert (source.channels, source.sample_rate_hz, source.warnings) == (channels, RATE_HZ, ())


@pytest.mark.parametrize("more", [1, 1_000, 2_048, 3_000, 4_095, 4_096])
@pytest.mark.parametrize("extension", ["caf", "m4a"])
def test_the_last_packet_of_alac_is_heard_to_its_end(tmp_path: Path, extension: str, more: int) -> None:
    """A CAF tells what a whole packet of 4096 would have more: it is not there, and not to be cut off."""
    written = impulses(10 * 4_096 + more, [4_800, 10 * 4_096 + more - 1], channels=2)
    kind = "ipod" if extension == "m4a" else None
    path = write_media(tmp_path / f"film.{extension}", [written], codec="alac", container_format=kind)
    samples, source = read(path, mix="0")
    np.testing.assert_array_equal(samples[:, 0], written[:, 0])
    assert source.warnings == ()


@pytest.mark.parametrize(("codec", "extension", "channels"), LOSSY)
def test_lossy_sound_keeps_its_delay_within_a_millisecond(
    tmp_path: Path, codec: str, extension: str, channels: int
) -> None:
    written = impulses(FRAMES, SHOTS, channels=channels)
    rate = FILM_RATE if extension in WITH_PICTURE else None
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec, picture_rate=rate)
    samples, source = read(path, mix="0")
    np.testing.assert_allclose(shots_in_film(samples, source), SHOTS, atol=48)
    assert FRAMES <= len(samples) < FRAMES + 2_400
    assert (source.channels, source.warnings) == (channels, ())
    assert source.frame_rate == (str(FILM_RATE) if rate else None)


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_the_sample_rate_is_never_changed(tmp_path: Path, rate_hz: int) -> None:
    for codec, extension in (("flac", "mkv"), ("aac", "mp4")):
        written = impulses(FRAMES, SHOTS)
        path = write_media(tmp_path / f"film.{extension}", [written], codec=codec, rate_hz=rate_hz)
        samples, source = read(path)
        assert source.sample_rate_hz == rate_hz
        np.testing.assert_allclose(onsets(samples[:, 0]), SHOTS, atol=rate_hz // 1000)


def test_the_layout_of_the_container_is_used(tmp_path: Path) -> None:
    written = np.zeros((9_000, 6), np.float32)
    for channel in range(6):
        written[1000 * (channel + 1) : 1000 * (channel + 1) + 10, channel] = 0.5
    path = write_media(tmp_path / "film.mkv", [written], codec="flac")
    peaks = read(path)[0][1000:7000, 0].reshape(6, 1000).max(axis=1)
    np.testing.assert_allclose(peaks, [0.35355, 0.35355, 0.5, 0.0, 0.25, 0.25], atol=1e-4)
    low = read(path, mix="lfe")[0]
    assert low[4000, 0] == 0.0
    assert low[4000, 1] == pytest.approx(0.5 * 10**0.5)


def test_a_stereo_film_whose_channels_are_called_left_and_right_total_is_read(tmp_path: Path) -> None:
    """So MOV calls what has the surround in it; it was refused, as if there were other channels to choose."""
    sound = impulses(20_000, [5_000], channels=2) * np.array([1.0, 0.5], np.float32)
    frame = av.AudioFrame.from_ndarray(sound.reshape(1, -1), format="flt", layout="stereo")
    frame.sample_rate = RATE_HZ
    with av.open(str(tmp_path / "film.mov"), "w") as container:
        stream: Any = container.add_stream("pcm_s16le", rate=RATE_HZ, layout="downmix")
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    with av.open(str(tmp_path / "film.mov")) as container:
        assert container.streams.audio[0].layout.name == "downmix"
    plain = write_media(tmp_path / "plain.mov", [sound], codec="pcm_s16le")
    np.testing.assert_array_equal(read(tmp_path / "film.mov")[0], read(plain)[0])


@pytest.mark.parametrize("frames", [1, 7, 4096, 10**6])
def test_the_size_of_the_blocks_changes_no_bit(tmp_path: Path, frames: int) -> None:
    path = write_media(tmp_path / "film.mkv", [impulses(9_000, [100], channels=6)], codec="ac3")
    expected, _ = read(path, mix="all")
    with open_soundtrack(path, mix="all") as track:
        blocks = list(track.blocks(frames))
    assert all(len(block.span) == frames for block in blocks[:-1])
    np.testing.assert_array_equal(np.concatenate([block.samples for block in blocks]), expected)


def test_a_list_of_films_is_no_film(tmp_path: Path) -> None:
    """Its digest would be that of the list, whatever becomes of the sound."""
    write_media(tmp_path / "part.flac", [impulses(FRAMES, SHOTS)], codec="flac")
    (tmp_path / "film.mkv").write_text("ffconcat version 1.0\nfile part.flac\n")
    with pytest.raises(SoundtrackError, match=r"film\.mkv: is a list of other files"):
        open_soundtrack(tmp_path / "film.mkv")


def test_the_default_track_is_taken_and_any_other_on_request(tmp_path: Path) -> None:
    main, comment = impulses(FRAMES, SHOTS), impulses(FRAMES, [60_000])
    path = write_media(
        tmp_path / "film.mkv",
        [comment, main],
        codec="flac",
        dispositions=[NONE, Disposition.default],
        titles=["Comment", "Main"],
    )
    for stream, expected in ((None, SHOTS), (0, [60_000]), (1, SHOTS)):
        samples, source = read(path, stream=stream)
        assert onsets(samples[:, 0]) == expected
        assert source.stream == (1 if stream is None else stream)
    for stream in (2, -1):
        with pytest.raises(SoundtrackError, match=r"no sound stream .*0 \(flac, 1 channel, Comment\); 1 \(flac,"):
            open_soundtrack(path, stream=stream)


@pytest.mark.parametrize("aside", [Disposition.comment, Disposition.hearing_impaired, Disposition.visual_impaired])
@pytest.mark.parametrize("unmarked", [NONE, Disposition.default])
def test_what_is_spoken_over_a_film_is_not_taken_for_it(
    aside: Disposition, unmarked: Disposition, tmp_path: Path
) -> None:
    """Some programs call every stream the default one."""
    main, beside = impulses(FRAMES, SHOTS), impulses(FRAMES, [60_000])
    marks = [aside | Disposition.default, unmarked]
    path = write_media(tmp_path / "film.mkv", [beside, main], codec="flac", dispositions=marks)
    for stream, expected in ((None, SHOTS), (0, [60_000])):
        assert onsets(read(path, stream=stream)[0][:, 0]) == expected
    alone = write_media(tmp_path / "alone.mkv", [beside], codec="flac", dispositions=marks[:1])
    assert onsets(read(alone)[0][:, 0]) == [60_000]


@pytest.mark.parametrize(
    "title",
    [
        "Director's Commentary",
        "comments",
        "Regiekommentar",
        "Commentaire audio",
        "Komentarz",
        "Audiodescripci\u00f3n",
        "Audiodescrizione",
        "Audiodeskrypcja",
    ],
)
def test_a_default_stream_that_is_speech_by_its_title_alone_is_heard_and_told(title: str, tmp_path: Path) -> None:
    """A title is no mark: what is heard stays what the file says, and the user decides."""
    main, beside = impulses(FRAMES, SHOTS, channels=2), impulses(FRAMES, [60_000], channels=2)
    path = write_media(tmp_path / "film.mkv", [beside, main], codec="flac", titles=[title, "Main"])
    samples, source = read(path)
    assert onsets(samples[:, 0]) == [60_000]
    assert source.warnings == (
        f"sound stream 0 (flac, 2 channels, {title}) is heard, which its title says is spoken over the film's sound; "
        "--stream chooses another: 1 (flac, 2 channels, Main)",
    )
    for stream in (0, 1):
        assert not read(path, stream=stream)[1].warnings
    marks = [Disposition.comment, NONE]
    marked = write_media(
        tmp_path / "marked.mkv", [beside, main], codec="flac", titles=[title, "Main"], dispositions=marks
    )
    alone = write_media(tmp_path / "alone.mkv", [beside], codec="flac", titles=[title])
    behind = write_media(tmp_path / "behind.mkv", [main, beside], codec="flac", titles=["Main", title])
    assert not any(read(each)[1].warnings for each in (marked, alone, behind))


def test_a_title_that_is_no_text_is_told_as_far_as_it_is(tmp_path: Path) -> None:
    """PyAV up to 18 would refuse the film, and from 19 on gives letters that no file takes."""
    silent, loud = np.zeros((FRAMES, 2), np.float32), impulses(FRAMES, SHOTS, channels=2)
    path = write_media(tmp_path / "film.mkv", [silent, loud], codec="flac", titles=["first", "caf__ bar"])
    path.write_bytes(path.read_bytes().replace(b"caf__ bar", b"caf\xe9\xe8 bar"))
    source = read(path, stream=0)[1]
    assert source.warnings[0].endswith(
        "--stream chooses another: 1 (flac, 2 channels, caf\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER} bar)"
    )
    source.warnings[0].encode()


def test_channels_in_streams_of_their_own_are_told_unless_one_is_chosen(tmp_path: Path) -> None:
    """Masters keep 5.1 in six streams of one channel: who is not told takes the left one for the film."""
    channels = [impulses(FRAMES, SHOTS, seed=seed) for seed in range(3)]
    path = write_media(tmp_path / "film.mov", channels, codec="pcm_s16le")
    [warning] = read(path)[1].warnings
    assert warning.startswith("only sound stream 0 of 3 with one channel each is heard: --stream 0-1 joins 2 as stereo")
    assert not read(path, stream=1)[1].warnings
    pair = write_media(tmp_path / "pair.mov", [impulses(FRAMES, SHOTS, channels=2)] * 2, codec="pcm_s16le")
    assert not read(pair)[1].warnings


def test_a_film_without_sound_is_refused(tmp_path: Path) -> None:
    path = write_media(tmp_path / "film.mp4", [], codec="aac", picture_rate=Fraction(24), silent_s=1.0)
    with pytest.raises(SoundtrackError, match=r"film\.mp4: has no sound stream"):
        open_soundtrack(path)


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [(2, 6, "from 2 channels at 48000 Hz to 6 channels at "), (1, 2, "from 1 channel at 48000 Hz to 2 channels at ")],
)
def test_sound_that_changes_its_channels_is_refused(tmp_path: Path, before: int, after: int, told: str) -> None:
    parts = []
    for channels in (before, after):
        part = write_media(tmp_path / "part.ac3", [impulses(FRAMES, SHOTS, channels=channels)], codec="ac3")
        parts.append(part.read_bytes())
    path = tmp_path / "film.ac3"
    path.write_bytes(b"".join(parts))
    with pytest.raises(SoundtrackError, match=rf"film\.ac3: the sound changes {told}"):
        read(path)


def test_a_playlist_fetches_nothing(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        address = f"http://127.0.0.1:{server.getsockname()[1]}/film.ts"
        path = tmp_path / "film.m3u8"
        path.write_text(f"#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\n{address}\n#EXT-X-ENDLIST\n")
        with pytest.raises(SoundtrackError, match=r"film\.m3u8: "):
            open_soundtrack(path)
        with pytest.raises(TimeoutError):
            server.accept()


def test_the_name_of_the_file_means_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = impulses(FRAMES, SHOTS)
    path = write_media(tmp_path / "concat:film %d.txt", [written], codec="flac", container_format="flac")
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(read(Path(path.name))[0], written)


def test_a_full_disk_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_media(tmp_path / "film.flac", [impulses(FRAMES, SHOTS)], codec="flac")

    class Full:
        def write(self, data: object) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

        def close(self) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: Full())
    with open_soundtrack(path, spool_folder=tmp_path) as track:
        with pytest.raises(OutputError, match="cannot keep the decoded sound here: No space left") as caught:
            list(track.blocks())
        assert str(caught.value).startswith(str(tmp_path))
    monkeypatch.undo()
    with pytest.raises(OutputError, match="nowhere: cannot keep the decoded sound here"):
        open_soundtrack(path, spool_folder=tmp_path / "nowhere")


def test_nothing_stays_in_the_spool_folder(tmp_path: Path) -> None:
    spool = tmp_path / "spool"
    spool.mkdir()
    path = write_media(tmp_path / "film.flac", [impulses(FRAMES, SHOTS)], codec="flac")
    with open_soundtrack(path, spool_folder=spool) as track:
        next(track.blocks())  # and leave in the middle
    assert not list(spool.iterdir())


@pytest.mark.parametrize(("codec", "extension"), [("flac", "mkv"), ("aac", "mp4"), ("pcm_s16le", "mov")])
@pytest.mark.parametrize("picture_rate", [None, Fraction(25)])
def test_a_container_tells_whether_it_holds_a_picture(
    tmp_path: Path, codec: str, extension: str, picture_rate: Fraction | None
) -> None:
    path = write_media(tmp_path / f"it.{extension}", [impulses(9_000, [100])], codec=codec, picture_rate=picture_rate)
    with open_soundtrack(path) as track:
        assert track.describe().has_picture == (picture_rate is not None)


@pytest.mark.parametrize("codec", ["ac3", "eac3", "aac"])
def test_silence_is_told_as_such_after_a_codec_too(tmp_path: Path, codec: str) -> None:
    """FFmpeg decodes silent AC-3 to noise at -101 dBFS: a film whose first track is left empty has no gunshots then."""
    tracks = [np.zeros((70_000, 2), np.float32), impulses(70_000, [30_000], channels=2)]
    silent, heard = (read(write_media(tmp_path / "film.mkv", tracks, codec=codec), stream=each)[1] for each in (0, 1))
    (warning,) = silent.warnings
    assert warning.startswith("sound stream 0 is silent from beginning to end; --stream chooses another: 1")
    assert heard.warnings == ()
