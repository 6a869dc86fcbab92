"""Windows laid into the film or into silence: to the bit outside of them, whatever the blocks are."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.model import Background, Clip, DriveModel
from blastline.render import RenderedWindow, compose, hear_window, plan_windows, render_window
from blastline.render.made_of import _OnsetEnergy
from render_signals import CAUSAL, RENDER, WINDOWS, film_with_shot, shot_at

Samples = NDArray[np.float64]


def two_shots() -> tuple[Samples, list[RenderedWindow]]:
    """Return a short film of two shots, the second near its end, and its windows over direct conversion."""
    first, shot = film_with_shot(before_s=0.05, after_s=0.1)
    film = np.concatenate([first, np.random.default_rng(3).uniform(-0.5, 0.5, 4000), first[:3000]])
    return film, windows_of(film, [shot.onset, len(first) + 4000 + shot.onset], "direct")


def windows_of(
    film: Samples, onsets: list[int], background: Background, model: DriveModel = "constrained"
) -> list[RenderedWindow]:
    shots = [shot_at(onset, decay_ms=30.0) for onset in onsets]
    planned = plan_windows(shots, frames=len(film), rate_hz=48_000, rules=WINDOWS)
    audio = Clip(film[:, None], 48_000)
    return [
        render_window(
            hear_window(audio, each, filters=CAUSAL, rules=RENDER),
            shots,
            model=model,
            reason="test",
            background=background,
        )
        for each in planned
    ]


def blocks(film: Samples, size: int, dtype: type = np.float64) -> Iterator[Clip]:
    for start in range(0, len(film), size):
        yield Clip(film[start : start + size, None].astype(dtype), 48_000, start)


def whole(clips: Iterator[Clip]) -> Samples:
    """Return the clips as one column; they must follow one another from sample 0."""
    parts, reached = [], 0
    for part in clips:
        assert part.start == reached
        assert part.samples.shape[1] == 1
        reached = part.span.stop
        parts.append(part.driving)
    return np.concatenate(parts)


@pytest.mark.parametrize("size", [1, 7, 4096, 10**6])
def test_block_size_changes_no_bit(size: int) -> None:
    film, done = two_shots()
    assert len(done) == 2
    drive = whole(compose(blocks(film, size), done, "direct"))
    expected = film.copy()
    for window in done:
        expected[window.clip.start : window.clip.span.stop] = window.clip.driving
    assert np.array_equal(drive, expected)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("gain", [1.0, 3.0])
def test_outside_windows_the_film_is_kept_to_the_bit_within_the_limit(dtype: type, gain: float) -> None:
    film, done = two_shots()
    film = gain * film
    assert gain == 1.0 or np.max(np.abs(film[5000:8000])) > 1.0
    drive = whole(compose(blocks(film, 1000, dtype), done, "direct"))
    outside = np.ones(len(film), bool)
    for window in done:
        outside[window.clip.start : window.clip.span.stop] = False
    assert np.any(outside)
    assert np.array_equal(drive[outside], np.clip(film.astype(dtype).astype(np.float64), -1.0, 1.0)[outside])


def test_direct_windows_over_the_film_are_the_film() -> None:
    film, _ = two_shots()
    done = windows_of(film, [2400, 11_000], "direct", "direct")
    assert np.array_equal(whole(compose(blocks(film, 333), done, "direct")), film)


def test_mute_yields_the_windows_alone_and_reads_no_blocks() -> None:
    film, _ = two_shots()
    done = windows_of(film, [2400], "mute")

    def unread() -> Iterator[Clip]:
        raise AssertionError("blocks were read")
        yield

    clips = list(compose(unread(), done, "mute"))
    assert [each.span for each in clips] == [each.planned.window.span for each in done]
    assert all(np.array_equal(each.samples, window.clip.samples) for each, window in zip(clips, done, strict=True))


def test_film_without_windows_is_its_own_drive() -> None:
    film, _ = two_shots()
    assert np.array_equal(whole(compose(blocks(film, 100), [], "direct")), film)
    assert list(compose([], [], "mute")) == []


def test_blocks_are_left_as_they_were() -> None:
    film, done = two_shots()
    kept = film.copy()
    list(compose([Clip(film[:, None], 48_000)], done, "direct"))
    assert np.array_equal(film, kept)


def test_film_goes_on_in_its_driving_column() -> None:
    film, done = two_shots()
    two = Clip(np.stack([np.ones(len(film)), film], axis=1), 48_000)
    assert np.array_equal(whole(compose([two], done, "direct")), whole(compose(blocks(film, 999), done, "direct")))


def test_windows_are_read_no_earlier_than_the_blocks_reach_them() -> None:
    film, done = two_shots()
    read: list[int] = []

    def lazily() -> Iterator[RenderedWindow]:
        for window in done:
            read.append(window.clip.start)
            yield window

    for part in compose(blocks(film, 500), lazily(), "direct"):
        assert len(read) <= 1 + sum(window.clip.span.stop <= part.span.stop for window in done)


def test_film_that_ends_before_its_windows_is_an_error() -> None:
    film, done = two_shots()
    with pytest.raises(ValueError, match=r"a window reaches to sample \d+, the film only to 9000"):
        list(compose(blocks(film[:9000], 3000), done, "direct"))


@pytest.mark.parametrize("level", [0.0, 0.25])
def test_a_shot_that_a_film_begins_with_brings_as_much_as_after_a_rest_at_the_films_first_level(level: float) -> None:
    shot = level + np.concatenate([[0.0], np.exp(-np.arange(9_600) / 500.0)])
    alone = _OnsetEnergy.around(shot, 0, 48_000)
    rested = _OnsetEnergy.around(np.concatenate([np.full(48_000, level), shot]), 48_000, 48_000)
    assert alone.brought == pytest.approx(rested.brought, rel=1e-9)
    assert alone.brought > 0.0
