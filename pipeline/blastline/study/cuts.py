"""The new cuts that conforming is measured on: how a film is cut, changed and copied."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..units import gain_from_db
from .codecs import Codec, encode
from .recut import Piece, Recut, Samples, in_surround, recut, stretched
from .sound_files import write_sound

RATE_HZ = 48_000


@dataclass(frozen=True, eq=False)
class OldFilm:
    """The old film: its file, its samples, its shots; and another film to insert from."""

    path: Path
    samples: Samples
    onsets_s: tuple[float, ...]
    other: Samples

    @property
    def duration_s(self) -> float:
        """Return the old film's length."""
        return float(self.samples.shape[0]) / RATE_HZ


_Make = Callable[[OldFilm], Recut]


@dataclass(frozen=True)
class Copy:
    """How the new film is written."""

    codec: Codec | None = None
    surround: bool = False
    bits_per_s: int = 448_000
    rate_hz: int = RATE_HZ


def _cut_up(old: OldFilm) -> list[Piece]:
    """Return three removals, two insertions and one change of speed."""
    at, speed = old.duration_s, 25.0 / 24.0
    return [
        Piece(0.0, 0.15 * at),
        Piece(0.02 * at, 0.08 * at, inserted=True),
        Piece(0.19 * at, 0.38 * at),
        Piece(0.38 * at + 2.3, 0.5 * at, speed),
        Piece(0.2 * at, 0.2 * at + 7.0, inserted=True),
        Piece(0.5 * at, 0.62 * at, speed),
        Piece(0.69 * at, at),
    ]


def _whole(old: OldFilm, speed: float) -> list[Piece]:
    return [Piece(0.0, old.duration_s, speed)]


def _leader(old: OldFilm) -> list[Piece]:
    return [Piece(11.0, 19.0, inserted=True), Piece(0.0, old.duration_s)]


def _reordered(old: OldFilm) -> list[Piece]:
    at = old.duration_s
    edges = np.array([0.0, 0.2, 0.3, 0.55, 0.6, 0.9, 1.0]) * at
    return [Piece(float(edges[n]), float(edges[n + 1])) for n in (0, 3, 1, 2, 5, 4)]


def _dubbed(level_db: float) -> Callable[[Samples, OldFilm], Samples]:
    """Return what mixes other sound in, `level_db` under the film by its mean power."""

    def change(samples: Samples, old: OldFilm) -> Samples:
        added = np.resize(old.other, samples.shape)
        level = float(np.sqrt(np.mean(samples**2) / np.mean(added**2)))
        return np.asarray(np.clip(samples + added * np.float32(level * gain_from_db(level_db)), -1.0, 1.0), np.float32)

    return change


def _close_cuts(old: OldFilm) -> list[Piece]:
    """Return cuts 100 ms before every twelfth shot, and 100 ms after every twelfth."""
    pieces, start_s = [], 0.0
    for index, onset_s in enumerate(old.onsets_s):
        if index % 12 == 5 and onset_s - 0.1 > start_s + 8.0:
            pieces.append(Piece(start_s, onset_s - 4.1))
            start_s = onset_s - 0.1
        elif index % 12 == 11 and onset_s + 0.1 > start_s + 4.0:
            pieces.append(Piece(start_s, onset_s + 0.1))
            start_s = onset_s + 4.1
    return [*pieces, Piece(start_s, old.duration_s)]


def _plain(
    pieces: Callable[[OldFilm], list[Piece]], change: Callable[[Samples, OldFilm], Samples] | None = None
) -> _Make:
    def make(old: OldFilm) -> Recut:
        made = recut(old.samples, old.other, pieces(old), RATE_HZ)
        return made if change is None else replace(made, samples=change(made.samples, old))

    return make


def _stretched(old: OldFilm) -> Recut:
    return stretched(old.samples, old.onsets_s, 25.0 / 24.0, RATE_HZ)


def _lowpassed(samples: Samples, old: OldFilm) -> Samples:
    from scipy.signal import butter, sosfilt

    return np.asarray(sosfilt(butter(4, 3500.0, fs=RATE_HZ, output="sos"), samples), np.float32)


def _louder(samples: Samples, old: OldFilm) -> Samples:
    return np.asarray(np.clip(samples * np.float32(gain_from_db(10.0)), -1.0, 1.0), np.float32)


def _softer(samples: Samples, old: OldFilm) -> Samples:
    return np.asarray(samples * np.float32(gain_from_db(-10.0)), np.float32)


_AC3 = Copy("ac3", surround=True)

CASES: dict[str, tuple[_Make, Copy]] = {
    "3 removals, 2 insertions, 4 % faster from the middle, 5.1 AC-3": (_plain(_cut_up), _AC3),
    "the same, as WAV": (_plain(_cut_up), Copy()),
    "first reel 37.123 s shorter, 5.1 AC-3": (_plain(lambda old: [Piece(37.123, old.duration_s)]), _AC3),
    "eight seconds of leader put first, stereo AAC": (_plain(_leader), Copy("aac", bits_per_s=96_000)),
    "25 for 24 pictures, pitch raised, 5.1 AC-3": (_plain(lambda old: _whole(old, 25.0 / 24.0)), _AC3),
    "25 for 23.976 pictures, pitch raised, 5.1 AC-3": (_plain(lambda old: _whole(old, 25.025 / 24.0)), _AC3),
    "24 for 25 pictures, pitch lowered, 5.1 AC-3": (_plain(lambda old: _whole(old, 0.96)), _AC3),
    "23.976 for 24 pictures (1000/1001), 5.1 AC-3": (_plain(lambda old: _whole(old, 1000.0 / 1001.0)), _AC3),
    "2.2 % slower, WAV": (_plain(lambda old: _whole(old, 0.978)), Copy()),
    "25 for 24 pictures, pitch kept (atempo), WAV": (_stretched, Copy()),
    "44.1 kHz, WAV": (_plain(_cut_up), Copy(rate_hz=44_100)),
    "10 dB louder, clipped, WAV": (_plain(_cut_up, _louder), Copy()),
    "10 dB softer, WAV": (_plain(_cut_up, _softer), Copy()),
    "low-passed at 3.5 kHz, 64 kbit/s MP3": (_plain(_cut_up, _lowpassed), Copy("libmp3lame", bits_per_s=64_000)),
    "dubbed: another film's talk and music 6 dB under": (_plain(_cut_up, _dubbed(-6.0)), Copy()),
    "dubbed: another film's talk and music as loud": (_plain(_cut_up, _dubbed(0.0)), Copy()),
    "cuts 100 ms before and after shots, 5.1 AC-3": (_plain(_close_cuts), _AC3),
    "scenes in another order, 5.1 AC-3": (_plain(_reordered), _AC3),
}


def written(made: Recut, copy: Copy, folder: Path) -> Path:
    """Write the new film into `folder` as the copy says and return its file."""
    import soxr

    samples = made.samples
    if copy.rate_hz != made.rate_hz:
        samples = np.asarray(soxr.resample(samples, made.rate_hz, copy.rate_hz), np.float32)
    if copy.codec is None:
        write_sound(folder / "new.wav", samples, copy.rate_hz)
        return folder / "new.wav"
    channels = in_surround(samples) if copy.surround else samples[:, None]
    encode(folder / "new.mkv", channels, copy.codec, bits_per_s=copy.bits_per_s, rate_hz=copy.rate_hz)
    return folder / "new.mkv"
