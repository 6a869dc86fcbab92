"""The pass over the whole drive, and the order of a timeline."""

import numpy as np
import pytest

from align_films import Held, make_film, weights_of
from blastline import dsp
from blastline.align.sanity import order_faults
from blastline.align.sounds import Sound, TimeMap, drive_at
from blastline.align.whole_drive import fades_of, gaps, moving_spans, scan
from blastline.model import Event, Span, Window


def test_gaps_and_windows_make_up_the_film() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        starts = rng.integers(0, 900, 6)
        windows = [Span(int(s), int(s + n)) for s, n in zip(starts, rng.integers(1, 200, 6), strict=True)]
        covered = np.zeros(1000, int)
        for window in windows:
            covered[window.start : window.stop] = 1
        for gap in gaps(windows, 1000):
            assert len(gap) > 0
            covered[gap.start : gap.stop] += 2
        assert set(covered.tolist()) <= {1, 2}


@pytest.mark.parametrize("block", [1, 7, 999, 10_000])
def test_block_size_changes_nothing(block: int) -> None:
    rng = np.random.default_rng(2)
    samples = np.where(rng.random(3000) < 0.02, rng.uniform(-1, 1, 3000), 0.0)
    still = [Span(0, 500), Span(600, 601), Span(1200, 3000)]
    figures = scan(Held(samples, 8000, block).blocks(), still, expected=None)
    assert figures.frames == 3000
    assert figures.peak == pytest.approx(np.abs(samples).max())
    assert figures.stray == sum(np.count_nonzero(samples[s.start : s.stop]) for s in still)
    assert moving_spans(Held(samples, 8000, block).blocks(), still=30) == moving_spans(
        Held(samples, 8000).blocks(), still=30
    )


@pytest.mark.parametrize("late", [0, 1, -7, 300])
def test_a_drive_that_is_late_by_whole_samples_is_read_there_as_between_samples(late: int) -> None:
    drive, span = Sound(Held(np.random.default_rng(6).standard_normal(3_000), 8_000), 3_000), Span(500, 900)
    whole, _ = drive_at(drive, span, rate_hz=8_000, time_map=TimeMap(1.0, late))
    between, _ = drive_at(drive, span, rate_hz=8_000, time_map=TimeMap(1.0, late + 1e-9))
    assert whole == pytest.approx(between, abs=1e-6)
    assert len(whole) == len(span)
    twice, _ = drive_at(drive, span, rate_hz=8_000, time_map=TimeMap(2.0, late))
    assert twice == pytest.approx(drive.file.read(Span(1_000 + late, 1_800 + late)).heard[::2], abs=1e-6)


def test_movements_are_separated_by_rest() -> None:
    samples = np.zeros(1000)
    samples[[100, 105, 129, 400, 990]] = 0.5
    assert moving_spans(Held(samples, 8000, 104).blocks(), still=25) == [Span(100, 130), Span(400, 401), Span(990, 991)]


@pytest.mark.parametrize("bits", [16, 24])
def test_dry_sound_is_compared_to_one_step_of_the_drives_own(bits: int) -> None:
    sound = np.random.default_rng(3).uniform(-1.2, 1.2, 2000)
    steps = 2 ** (bits - 1)
    written = np.clip(np.rint(sound * steps), -steps, steps - 1) / steps
    still = [Span(0, 2000)]

    def strays(samples: np.ndarray) -> int:
        return scan(Held(samples, 8000).blocks(), still, expected=lambda s: sound[s.start : s.stop]).stray

    assert strays(written) == 0
    written[[5, 1500]] += np.where(written[[5, 1500]] > 0, -3, 3) / steps
    assert strays(written) == 2
    assert strays(np.zeros(2000)) == np.count_nonzero(np.abs(sound) > 1.5 / steps), "rest is no sound either"


@pytest.mark.parametrize("block", [1, 13, 10_000])
@pytest.mark.parametrize("sounding", [False, True])
def test_what_fades_is_held_to_the_weight_of_its_window(block: int, sounding: bool) -> None:
    rng = np.random.default_rng(4)
    windows = [Window(100, 300, 40, 60), Window(300, 400, 0, 0), Window(500, 600, 50, 50), Window(100, 300, 40, 60)]
    dry = rng.uniform(-1.3, 1.3, 1000) if sounding else np.zeros(1000)
    weights = np.zeros(1000)
    for window in windows:
        weights[window.start : window.stop] = weights_of(window)
    loudest = dsp.cross_fade(np.clip(dry, -1.0, 1.0), np.where(dry > 0.0, -1.0, 1.0), weights)

    def unfaded(samples: np.ndarray) -> int:
        fades = fades_of(windows[::-1])
        expected = (lambda span: dry[span.start : span.stop]) if sounding else None
        return scan(Held(samples, 8000, block).blocks(), [], expected=expected, fades=fades).unfaded

    assert unfaded(loudest) == 0
    touched = [100, 139, 240, 299, 520, 599]
    for further in (touched, [150, 310, 410]):  # these lie in no fade
        loudest[further] += 1e-3 * np.sign(loudest - dry)[further]
        assert unfaded(loudest) == len(touched)


def test_windows_that_overlap_are_read_all_the_same() -> None:
    fades = fades_of([Window(0, 200, 10, 100), Window(50, 120, 10, 5), Window(60, 61, 5, 5)])
    assert [fade.span for fade in fades] == [Span(0, 10), Span(50, 60), Span(100, 200), Span(115, 120)]
    for block in (1, 7, 300):
        assert scan(Held(np.ones(300), 8000, block).blocks(), [], expected=None, fades=fades).unfaded == 125


def replaced(event: Event, **changes: object) -> Event:
    import msgspec

    return msgspec.structs.replace(event, **changes)


def test_each_fault_of_a_timeline_counts() -> None:
    timeline = make_film(onsets_s=(0.5, 1.0, 1.5), peaks=(0.1, 0.1, 0.1), seconds=2.0).timeline
    frames = timeline.source.frames
    first, second, third = timeline.events
    assert order_faults(timeline.events, frames) == 0
    assert order_faults((second, first, third), frames) == 1
    assert order_faults((first, replaced(second, id=first.id), third), frames) == 1
    window = second.window
    assert order_faults((first, second, replaced(third, window=Window(window.start, frames + 1, 0, 0))), frames) == 2
    assert order_faults((first, replaced(second, onset_sample=window.stop), third), frames) == 1
    shared = (first, replaced(second, onset_sample=first.onset_sample + 100, window=first.window), third)
    assert order_faults(shared, frames) == 0
