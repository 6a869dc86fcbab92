"""Rows about windows and blocks: against a mask made sample by sample, and against the film taken whole."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..detect import find_shots, verifier_of
from ..detect.tracks import pieces
from ..model import Clip, Shot, Span
from ..render import RenderedWindow, compose, drive_filters, hear_window, plan_windows, render_window
from ..ruleset import DEFAULT_ACTUATOR, load_actuator, load_rules
from ..soundtrack import open_soundtrack
from .bars import Bar, exact
from .sound_files import write_sound
from .stability_signals import RATE_HZ, shot_at, shot_film

BLOCKS = (1, 7, 4_096)
_FRAMES = 48_000


def window_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about windows and blocks; writes one short film into the folder."""
    yield from _plan_rows()
    yield from _compose_rows()
    yield from _detection_rows()
    yield from _reading_rows(folder / "film.wav")


def _plan_rows() -> Iterator[Bar]:
    fade_in, guard, fade_out = _margins()
    reach = guard + fade_in + fade_out
    films: dict[str, tuple[int, list[Shot]]] = {
        "a film of one sample": (1, [shot_at(0, 1)]),
        "a shot of one sample": (_FRAMES, [shot_at(20_000, 1)]),
        "windows that touch": (_FRAMES, [shot_at(9_000, 100), shot_at(9_100 + reach, 100)]),
        "windows one sample apart": (_FRAMES, [shot_at(9_000, 100), shot_at(9_101 + reach, 100)]),
        "windows that overlap": (_FRAMES, [shot_at(9_000, 4_000), shot_at(10_000, 100), shot_at(12_000, 9_000)]),
        "a window past the start": (_FRAMES, [shot_at(0, 4_000), shot_at(1, 1)]),
        "a window past the end": (_FRAMES, [shot_at(_FRAMES - 1, 9_000)]),
    }
    rules = load_rules("standard").tier.windows
    for name, (frames, shots) in films.items():
        planned = plan_windows(shots, frames=frames, rate_hz=RATE_HZ, rules=rules)
        count, wrong = np.zeros(frames, np.intp), 0
        for each in planned:
            count[each.window.start : each.window.stop] += 1
            wrong += each.window.stop > frames or each.window.fade_in_samples > len(each.window.span)
        wrong += int(np.count_nonzero(count != _covered(shots, frames)))
        # between two windows at least one sample rests, and every shot has one window
        wrong += sum(one.window.stop >= other.window.start for one, other in pairwise(planned))
        wrong += sorted(index for each in planned for index in each.shots) != list(range(len(shots)))
        yield exact(f"{name}: wrong samples", wrong)


def _margins() -> tuple[int, int, int]:
    rules = load_rules("standard").tier.windows
    fade_in, guard, fade_out = (
        round(ms * RATE_HZ / 1000) for ms in (rules.fade_in_ms, rules.guard_ms, rules.fade_out_ms)
    )
    return fade_in, guard, fade_out


def _covered(shots: Sequence[Shot], frames: int) -> NDArray[np.intp]:
    """Return 1 for each sample that some shot's window covers, each sample asked on its own."""
    fade_in, guard, fade_out = _margins()
    place = np.arange(frames)
    inside = np.zeros(frames, bool)
    for shot in shots:
        inside |= (place >= shot.onset - guard - fade_in) & (place < min(shot.span.stop, frames) + fade_out)
    return inside.astype(np.intp)


def _compose_rows() -> Iterator[Bar]:
    film = np.maximum(shot_film(frames=_FRAMES), shot_film(frames=_FRAMES, onset=38_000)) + 1e-3
    shots = [shot_at(14_400, 4_000), shot_at(38_000, 4_000)]
    tier, (profile, _) = load_rules("standard").tier, load_actuator(DEFAULT_ACTUATOR)
    filters = drive_filters(profile, RATE_HZ, "causal")
    whole = Clip(film[:, None], RATE_HZ)
    rendered = [
        render_window(
            hear_window(whole, planned, filters=filters, rules=tier.render),
            shots,
            model="filter",
            reason="study",
            background="direct",
        )
        for planned in plan_windows(shots, frames=_FRAMES, rate_hz=RATE_HZ, rules=tier.windows)
    ]
    wanted = film.copy()
    for done in rendered:
        wanted[done.clip.start : done.clip.span.stop] = done.clip.driving
    # far into a stream, where a counter of 32 bits would have turned over, the sums are the same
    for start in (0, 2**31 - 20_000, 2**32 - 20_000):
        late = [_later(done, start) for done in rendered]
        for frames in (*BLOCKS, _FRAMES):
            composed = compose(_blocks(film, frames, start), late, "direct")
            made = np.concatenate([block.driving for block in composed])
            place = "" if start == 0 else f" from sample {start}"
            yield exact(f"composed in blocks of {frames}{place}: bits that differ", np.count_nonzero(made != wanted))


def _later(done: RenderedWindow, samples: int) -> RenderedWindow:
    return replace(done, clip=Clip(done.clip.samples, RATE_HZ, done.clip.start + samples))


def _detection_rows() -> Iterator[Bar]:
    film = (shot_film(frames=_FRAMES) + 1e-4 * np.random.default_rng(5).standard_normal(_FRAMES)).astype(np.float32)
    tier = load_rules("standard").tier
    verifier = verifier_of(tier)
    tracks = list(pieces(_blocks(film, _FRAMES), RATE_HZ))
    found = find_shots(_blocks(film, _FRAMES), rate_hz=RATE_HZ, tier=tier, verifier=verifier)
    yield Bar("shots found in the film of the next rows", len(found.shots), 1, "shots", "above")
    for frames in BLOCKS:
        wrong = sum(
            np.count_nonzero(getattr(one, name) != getattr(other, name))
            for one, other in zip(tracks, pieces(_blocks(film, frames), RATE_HZ), strict=True)
            for name in ("samples", "peak", "slope", "bands")
        )
        yield exact(f"scan in blocks of {frames}: bits that differ", wrong)
        again = find_shots(_blocks(film, frames), rate_hz=RATE_HZ, tier=tier, verifier=verifier)
        yield exact(f"detection in blocks of {frames}: differs", int(again != found), "results")


def _reading_rows(path: Path) -> Iterator[Bar]:
    steps = np.random.default_rng(6).integers(-(2**23), 2**23, 20_000, dtype=np.int32)
    write_sound(path, steps << 8, RATE_HZ, subtype="PCM_24")
    wanted = (steps / 2.0**23).astype(np.float32)
    for frames in (*BLOCKS, len(steps)):
        with open_soundtrack(path) as track:
            read = np.concatenate([block.heard for block in track.blocks(frames)])
            again = track.read(Span(7, 19_000)).heard
        wrong = np.count_nonzero(read != wanted) + np.count_nonzero(again != wanted[7:19_000])
        yield exact(f"read in blocks of {frames}: bits that differ", wrong)


def _blocks(film: NDArray[np.floating], frames: int, origin: int = 0) -> Iterator[Clip]:
    for start in range(0, len(film), frames):
        yield Clip(film[start : start + frames, None], RATE_HZ, origin + start)
