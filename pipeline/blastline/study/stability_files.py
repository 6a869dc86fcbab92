"""Rows about files: sound that is no number, and a day of stream, whose counters exceed 32 bits."""

import struct
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from ..model import Clip, Source, Span
from ..render import drive_filters
from ..ruleset import DEFAULT_ACTUATOR, load_actuator
from ..soundtrack import Cue, open_soundtrack, write_drive
from ..soundtrack.bwf import MARKER_LIMIT, cue_chunks
from ..soundtrack.chunks import chunk_table
from ..soundtrack.pcm import open_pcm
from ..timecode import timecode_at
from ..units import samples_from_s
from .bars import Bar, exact
from .sound_files import write_sound
from .stability_signals import MODELS, RATE_HZ, drive_of, shot_film

DAY_S = 86_400
_BAD = {100: np.nan, 101: np.inf, 14_500: -np.inf, 14_501: 1e38, 15_000: np.nan, 23_999: np.nan}


def file_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about files; the day's drive is a sparse file of 12 GB that takes a few kilobytes."""
    yield from _bad_sample_rows(folder / "bad.wav")
    yield from _day_rows(folder / "day.wav")
    yield from _counter_rows()
    yield from _timecode_rows()


def _bad_sample_rows(path: Path) -> Iterator[Bar]:
    """Yield what becomes of samples that are no sound: 0, counted by name, and not one sample more."""
    import soundfile

    film = shot_film().astype(np.float32)
    broken = film.copy()
    for place, value in _BAD.items():
        broken[place] = value
    write_sound(path, broken, RATE_HZ, subtype="FLOAT")
    with open_soundtrack(path) as track:
        read = np.concatenate([block.heard for block in track.blocks(1_000)])
        warnings = track.source().warnings
        again = track.read(Span(0, len(film))).driving
    wanted = film.copy()
    wanted[list(_BAD)] = 0.0
    yield exact("NaN, infinity and 1e38 in a file: samples not mended", np.count_nonzero(read != wanted))
    yield exact("the same, cut again: samples not mended", np.count_nonzero(again != wanted))
    told = [line for line in warnings if line.startswith(f"{len(_BAD)} samples were NaN, infinite or beyond")]
    named = told and told[0].endswith("first at sample 100")
    yield exact("the same: named and counted wrongly", int(not named), "warnings")
    profile, _ = load_actuator(DEFAULT_ACTUATOR)
    filters = drive_filters(profile, RATE_HZ, "causal")
    for model in MODELS:
        drive = drive_of(again, 14_400, model, filters)
        drive_path = path.with_name(f"{model}.wav")
        write_drive(drive_path, [Clip(drive[:, None], RATE_HZ)], rate_hz=RATE_HZ, frames=len(drive))
        written, _ = soundfile.read(drive_path)
        # half a step of 24 bits, and the topmost step for 1.0
        wrong = np.count_nonzero(~(np.abs(written - drive) <= 2.0**-23))
        yield exact(f"{model} drive of it, as written: wrong samples", wrong)


def _day_rows(path: Path) -> Iterator[Bar]:
    """Yield a day's drive, written at five places and read back there by two readers."""
    import soundfile

    frames = DAY_S * RATE_HZ + 1
    steps = np.arange(1, 101)
    places = (0, 2**31 - 50, 2**31 + 1_000, 2**32 - 150_000_000, frames - len(steps))
    clips = (Clip((steps / 2.0**23)[:, None], RATE_HZ, place) for place in places)
    write_drive(path, clips, rate_hz=RATE_HZ, frames=frames, cues=[Cue(place, "shot", 100) for place in places])
    track = open_pcm(path, chunk_table(path))
    wrong_here = wrong_there = len(places) * len(steps)
    if track is not None:
        with soundfile.SoundFile(path) as file:
            yield exact("24 h at 48 kHz: frames in the file", file.frames - frames)
            for place in places:
                wrong_here -= int(np.count_nonzero(track.read(place, len(steps))[:, 0] == steps / 2.0**23))
                file.seek(place)
                wrong_there -= int(np.count_nonzero(file.read(len(steps)) == steps / 2.0**23))
            rest = np.count_nonzero(track.read(2**31 + 1_100, 65_536))
        track.close()
        yield exact("24 h: samples beyond the windows that are not 0", rest)
    yield exact("24 h: wrong samples, read here", wrong_here)
    yield exact("24 h: wrong samples, read by libsndfile", wrong_there)
    yield exact("24 h: markers out of place", len(set(places) ^ set(_marker_places(path))), "markers")
    path.unlink()


def _marker_places(path: Path) -> list[int]:
    with path.open("rb") as file:
        file.seek(-4_096, 2)
        tail = file.read()
    at = tail.index(b"cue ") + 8
    (count,) = struct.unpack_from("<I", tail, at)
    return [struct.unpack_from("<II4sIII", tail, at + 4 + 24 * number)[5] for number in range(count)]


def _counter_rows() -> Iterator[Bar]:
    """Yield the way from samples to seconds and back, for a day at each rate, against exact fractions."""
    wrong = half = 0
    random = np.random.default_rng(7)
    for rate_hz in (8_000, 11_025, 44_100, 48_000, 192_000, 384_000):
        for sample in (*random.integers(2**31, DAY_S * 384_000, 500).tolist(), DAY_S * rate_hz, DAY_S * rate_hz - 1):
            wrong += samples_from_s(sample / rate_hz, rate_hz) != sample
            half += abs(Fraction(sample / rate_hz) - Fraction(sample, rate_hz)) * rate_hz >= Fraction(1, 1000)
    yield exact("24 h: samples to seconds and back: wrong", wrong)
    yield exact("24 h: onset_s off by a thousandth of a sample", half)
    beyond = cue_chunks([Cue(MARKER_LIMIT, "last", 5), Cue(MARKER_LIMIT + 1, "beyond", MARKER_LIMIT + 1)])
    yield exact("markers beyond 32 bits in the file", beyond.count(b"beyond"), "markers")
    yield exact("markers at 32 bits missing", 1 - beyond.count(b"last"), "markers")


def _timecode_rows() -> Iterator[Bar]:
    """Yield timecodes around a day's end against the nearest frames, counted in integers."""
    for frame_rate, nominal, drop in (
        ("24", 24, False),
        ("25", 25, False),
        ("24000/1001", 24, False),
        ("30000/1001", 30, True),
    ):
        wrong = 0
        start = "00:00:00;00" if drop else "00:00:00:00"
        for rate_hz in (44_100, 48_000, 384_000):
            source = Source("film", "", rate_hz, 1, 1, start_timecode=start, frame_rate=frame_rate)
            for sample in (2**31 - 1, 2**31, 2**32 + 1, DAY_S * rate_hz - 1, DAY_S * rate_hz):
                frame = (sample * Fraction(frame_rate) / rate_hz + Fraction(1, 2)) // 1
                wrong += timecode_at(source, sample) != _smpte(frame, nominal, drop=drop)
        yield exact(f"24 h: timecodes at {frame_rate} frames per second: wrong", wrong, "timecodes")


def _smpte(frame: int, nominal: int, *, drop: bool) -> str:
    """Return the timecode of a frame; drop-frame skips two numbers in every minute but the tenth."""
    if drop:
        tens, rest = divmod(frame, 17_982)
        frame += 18 * tens + (2 * ((rest - 1_800) // 1_798 + 1) if rest >= 1_800 else 0)
    seconds, frames = divmod(frame, nominal)
    clock = f"{seconds // 3600 % 24:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
    return f"{clock}{';' if drop else ':'}{frames:02}"
