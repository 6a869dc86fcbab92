"""Coded data in PCM (SMPTE 337M, DTS) is refused in every word size and arrangement; sound never is."""

import io
import wave
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.errors import SoundtrackError
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.coded import first_burst
from media import RATE_HZ, impulses, require_encoder, write_media

SYNCS = {16: (0xF872, 0x4E1F), 20: (0x6F872, 0x54E1F), 24: (0x96F872, 0xA54E1F)}
"""SMPTE 337M, table 6: Pa and Pb by the bits of a word."""

DOLBY_E_25, DOLBY_E_29_97, AC_3, E_AC_3 = (1920,), (1601, 1602, 1601, 1602, 1602), (1536,), (6144,)
"""Frames from burst to burst."""

REFUSED = r"film\.\w+: sound stream 0 holds coded data \(SMPTE 337M, as of Dolby E or AC-3\) at {} s; expected PCM"


def bursts(bits: int, distances: Sequence[int], *, channels: int, frames: int = 60_000, first: int = 0) -> Any:
    """Return words of 32 bits, shape (frames, channels): bursts of random data that fill half of each distance."""
    rng = np.random.default_rng(bits)
    row = np.zeros((frames, channels), np.int64)
    start, turn = first, 0
    while start < frames:
        distance = distances[turn % len(distances)]
        data = row[start : start + distance // 2].reshape(-1)
        data[:] = rng.integers(0, 1 << bits, len(data))
        data[:2] = SYNCS[bits][: len(data)]
        start, turn = start + distance, turn + 1
    return (row << (32 - bits)).astype(np.uint32).view(np.int32)


def heard(path: Path, **options: Any) -> NDArray[np.float32]:
    with open_soundtrack(path, **options) as track:
        return np.concatenate([block.samples for block in track.blocks(10_007)])


@pytest.mark.parametrize("bits", SYNCS)
@pytest.mark.parametrize("channels", [1, 2])
@pytest.mark.parametrize("distances", [DOLBY_E_25, DOLBY_E_29_97, AC_3, E_AC_3])
def test_bursts_are_refused(tmp_path: Path, bits: int, channels: int, distances: Sequence[int]) -> None:
    words = bursts(bits, distances, channels=channels, first=4_800)
    soundfile.write(tmp_path / "film.wav", words, RATE_HZ, subtype="PCM_16" if bits == 16 else "PCM_24")
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"0\.100")) as told:
        heard(tmp_path / "film.wav")
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("places", "first"),
    [
        ([100, 356, 612, 868], 100),  # 256 frames apart
        ([100, 355, 610, 865], None),
        ([100, 354, 610, 866], None),
        ([100, 356, 612, 868, 1_124], 100),
        ([100, 356, 612], None),
        ([100], None),
        ([100, 1_700, 2_600, 4_200], None),
        ([100, 1_700, 3_300, 4_200], None),
        ([100, 1_700, 3_302, 4_904], 100),  # 1600, 1602, 1602
        ([100, 1_700, 3_303, 4_906], None),
        ([100, 1_000, 1_600, 2_200, 2_800], 1_000),
        ([100, 300, 2_100, 2_350, 4_100, 4_500, 6_100, 6_150], 100),  # two trains in turn, of which one is even
        ([100, 300, 2_100, 2_350, 4_100, 4_500], None),
    ],
)
def test_four_bursts_at_equal_distances_are_data_and_fewer_or_uneven_ones_are_sound(
    places: Sequence[int], first: int | None
) -> None:
    samples = np.zeros((10_000, 1), np.float32)
    for place in places:
        samples[place : place + 2, 0] = [(word - 0x10000 if word & 0x8000 else word) / 0x8000 for word in SYNCS[16]]
    found = first_burst(samples, np.array([True]))
    assert (None if found is None else found.frame) == first


@pytest.mark.parametrize(("container", "subtype"), [("AIFF", "PCM_16"), ("WAV", "PCM_24"), ("CAF", "PCM_32")])
def test_words_may_lie_in_wider_samples_of_any_file(tmp_path: Path, container: str, subtype: str) -> None:
    soundfile.write(tmp_path / "film.x", bursts(16, AC_3, channels=2), RATE_HZ, subtype=subtype, format=container)
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"0\.000")):
        heard(tmp_path / "film.x")


def test_a_stream_of_a_film_is_refused_and_the_others_are_named(tmp_path: Path) -> None:
    data = (bursts(20, DOLBY_E_25, channels=2) / 2.0**31).astype(np.float32)
    sound = impulses(60_000, [30_000], channels=2)
    path = write_media(tmp_path / "film.mkv", [data, sound], codec="pcm_s24le")
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"0\.000") + r" sound; --stream chooses another: 1 \("):
        heard(path)
    assert np.any(heard(path, stream=1))


def test_data_that_begins_late_is_refused_where_it_begins(tmp_path: Path) -> None:
    soundfile.write(
        tmp_path / "film.wav", bursts(24, AC_3, channels=2, frames=400_000, first=240_000), RATE_HZ, "PCM_24"
    )
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"5\.000")):
        heard(tmp_path / "film.wav")


def test_data_that_begins_later_than_all_is_searched_is_refused_as_well(tmp_path: Path) -> None:
    words = bursts(16, AC_3, channels=1, frames=45 * RATE_HZ, first=25 * RATE_HZ)
    soundfile.write(tmp_path / "film.wav", words, RATE_HZ, "PCM_16")
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"(2[5-9]|3\d)\.\d+")):
        heard(tmp_path / "film.wav")


def test_data_in_channels_that_are_not_heard_do_no_harm(tmp_path: Path) -> None:
    sound = np.rint(impulses(60_000, [30_000], channels=6) * 2.0**31).astype(np.int32)
    words = np.concatenate([sound, bursts(20, DOLBY_E_25, channels=2)], axis=1)
    soundfile.write(tmp_path / "film.wav", words, RATE_HZ, subtype="PCM_24")
    assert np.any(heard(tmp_path / "film.wav", mix="0,1,2"))
    for mix in ("mains", "6", "7"):
        with pytest.raises(SoundtrackError, match="--mix chooses other channels"):
            heard(tmp_path / "film.wav", mix=mix)


@pytest.mark.parametrize("codec", ["ac3", "eac3"])
def test_what_ffmpeg_wraps_is_refused(tmp_path: Path, codec: str) -> None:
    require_encoder(codec)
    wrapped = io.BytesIO()
    with av.open(wrapped, "w", format="spdif") as container:
        stream: Any = container.add_stream(codec, rate=RATE_HZ, layout="stereo")
        for place in range(0, 4 * RATE_HZ, 1536):
            frame = av.AudioFrame.from_ndarray(np.zeros((2, 1536), np.float32), format="fltp", layout="stereo")
            frame.sample_rate, frame.pts, frame.time_base = RATE_HZ, place, Fraction(1, RATE_HZ)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    with wave.open(str(tmp_path / "film.wav"), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(wrapped.getvalue())
    with pytest.raises(SoundtrackError, match=REFUSED.format(r"0\.000")):
        heard(tmp_path / "film.wav")


DTS_HEADS = {
    "14 bits": (0x1FFF, 0xE800, 0x07F1),
    "16 bits": (0x7FFE, 0x8001, 0xFC3C),
    "14 bits swapped": (0xFF1F, 0x00E8, 0xF107),
    "16 bits swapped": (0xFE7F, 0x0180, 0x3CFC),
}
"""ETSI TS 102 114, 5.3 and annex: the sync word and the first bits of a whole frame."""


def dts(head: Sequence[int], *, distance: int = 512, first: int = 0) -> NDArray[np.int16]:
    """Return random words of 14 bits for the samples of a pair, with the head of a frame every so often."""
    row = np.random.default_rng(7).integers(-8_192, 8_192, 2 * 40_000)
    for place in range(2 * first, len(row) - 2, 2 * distance):
        row[place : place + 3] = head
    return row.astype(np.uint16).view(np.int16).reshape(-1, 2)


@pytest.mark.parametrize("head", DTS_HEADS.values(), ids=DTS_HEADS)
@pytest.mark.parametrize("distance", [512, 1_024, 4_096])
@pytest.mark.parametrize(("container", "subtype"), [("WAV", "PCM_16"), ("FLAC", "PCM_16"), ("AIFF", "PCM_24")])
def test_dts_is_refused(tmp_path: Path, head: Sequence[int], distance: int, container: str, subtype: str) -> None:
    """It sounds like noise, in which there is no shot: of such a film nobody would know that nothing was heard."""
    words = dts(head, distance=distance, first=4_800)
    soundfile.write(tmp_path / "film.x", words, RATE_HZ, subtype=subtype, format=container)
    with pytest.raises(
        SoundtrackError, match=r"sound stream 0 holds coded data \(DTS\) at 0\.100 s; expected PCM sound"
    ):
        heard(tmp_path / "film.x")


@pytest.mark.parametrize("head", DTS_HEADS.values(), ids=DTS_HEADS)
def test_words_of_dts_without_the_third_are_sound(tmp_path: Path, head: Sequence[int]) -> None:
    """A square wave may have the first two, at full scale, at any distance."""
    soundfile.write(tmp_path / "film.wav", dts((*head[:2], 0x0300)), RATE_HZ, subtype="PCM_16")
    assert len(heard(tmp_path / "film.wav")) == 40_000


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("third", [np.nan, np.inf, -np.inf, 3e38, -1e30, 1.5])
@pytest.mark.parametrize("head", DTS_HEADS.values(), ids=DTS_HEADS)
def test_what_is_no_word_behind_two_words_of_dts_is_sound(tmp_path: Path, head: Sequence[int], third: float) -> None:
    """Damaged samples are set to 0, which one warning tells; none comes from what looks at them before."""
    samples = (np.array(dts((*head[:2], 0))) / 2.0**15).astype(np.float32)
    samples[1::512, 0] = third
    soundfile.write(tmp_path / "film.wav", samples, RATE_HZ, subtype="FLOAT")
    found = heard(tmp_path / "film.wav")
    assert np.isfinite(found).all()
    assert len(found) == 40_000


@pytest.mark.parametrize(
    "places", [(9_000, 10_920, 12_840), (9_000, 10_920, 12_850, 14_770, 16_700), range(0, 60_000, 2)]
)
def test_sync_words_by_chance_are_sound(tmp_path: Path, places: Sequence[int]) -> None:
    """Three at equal distances, many at others, and a square wave of these very samples."""
    words = np.random.default_rng(3).integers(-(2**31), 2**31, (60_000, 2)).astype(np.int32)
    for place in places:
        words[place] = (np.array(SYNCS[16]) << 16).astype(np.uint32).view(np.int32)
    soundfile.write(tmp_path / "film.wav", words, RATE_HZ, subtype="PCM_16")
    assert len(heard(tmp_path / "film.wav")) == 60_000
