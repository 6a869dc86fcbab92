"""The drive of a window, by each model: what it promises, and what must not change a bit of it."""

import re
from typing import get_args

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from blastline.model import Background, Clip, DriveInfo, DriveModel, Quality, Shot, Span
from blastline.render import (
    DriveFilters,
    RenderedWindow,
    drive_filters,
    hear_window,
    measure,
    needed_audio,
    plan_windows,
    render_window,
)
from blastline.render.filters import compensated, felt, in_band
from blastline.ruleset import RenderRules, load_rules
from render_signals import (
    CAUSAL,
    KINDS,
    PROFILE,
    RATE_HZ,
    RENDER,
    WINDOWS,
    ZERO,
    altered,
    clip,
    film_with_shot,
    only_window,
    shot_at,
)

Samples = NDArray[np.float64]
MODELS: tuple[DriveModel, ...] = get_args(DriveModel)
BACKGROUNDS: tuple[Background, ...] = get_args(Background)


def rendered(
    film: Samples,
    shots: list[Shot],
    model: DriveModel,
    *,
    background: Background = "mute",
    filters: DriveFilters = CAUSAL,
    rules: RenderRules = RENDER,
) -> list[RenderedWindow]:
    """Return the windows of a film, rendered from just the audio that each needs."""
    windows = plan_windows(shots, frames=len(film), rate_hz=filters.rate_hz, rules=WINDOWS)
    whole = clip(film, filters.rate_hz)
    return [
        render_window(
            hear_window(
                whole.slice(needed_audio(planned, frames=len(film), filters=filters, rules=rules)),
                planned,
                filters=filters,
                rules=rules,
            ),
            shots,
            model=model,
            reason="test",
            background=background,
        )
        for planned in windows
    ]


def figures(drive: NDArray[np.floating], film: Samples, shot: Shot, window_start: int) -> tuple[float, float]:
    """Return ratio and correlation of what is felt of a drive against the sound in the band, over the shot."""
    inside = slice(shot.onset - window_start, min(shot.span.stop, window_start + len(drive)) - window_start)
    found = felt(drive.astype(np.float64), CAUSAL)[inside]
    wanted = in_band(film, CAUSAL)[window_start:][inside]
    level, against = np.linalg.norm(found), np.linalg.norm(wanted)
    return float(level / against), float(np.sum(found * wanted) / level / against)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("background", BACKGROUNDS)
@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
def test_clip_spans_its_window_within_the_limit(
    model: DriveModel, background: Background, filters: DriveFilters
) -> None:
    film, shot = film_with_shot(peak=0.9)
    (done,) = rendered(film, [shot], model, background=background, filters=filters)
    assert done.clip.span == done.planned.window.span
    assert done.clip.samples.shape[1] == 1
    assert done.clip.samples.dtype == np.float64
    assert np.max(np.abs(done.clip.samples)) <= 1.0
    (info,) = done.drives
    assert info.model == model
    assert info.peak == np.max(np.abs(done.clip.samples))


def test_promise_on_weak_shots() -> None:
    """The table of dsp.md: too weak direct, worse scaled or clipped, strong and alike within the limit."""
    table: dict[str, list[tuple[float, float]]] = {"direct": [], "scaled": [], "clipped": [], "constrained": []}
    for seed, kind in enumerate(KINDS):
        film, shot = film_with_shot(kind, seed=seed)
        for model in MODELS:
            (done,) = rendered(film, [shot], model)
            table["scaled" if model == "filter" else model].append(
                figures(done.clip.driving, film, shot, done.planned.window.start)
            )
        clipped = np.clip(compensated(film, CAUSAL), -1.0, 1.0)
        table["clipped"].append(figures(clipped[done.planned.window.start :], film, shot, done.planned.window.start))
    ratio, alike = {}, {}
    for name, rows in table.items():
        ratio[name], alike[name] = np.mean(rows, axis=0)
    assert ratio["constrained"] >= 0.83
    assert alike["constrained"] >= 0.95
    assert ratio["direct"] < 0.4
    assert alike["direct"] < 0.85
    assert ratio["scaled"] < ratio["direct"]
    assert alike["scaled"] > 0.999
    assert ratio["clipped"] < ratio["constrained"] - 0.1
    assert alike["clipped"] < alike["constrained"]


def test_every_tier_keeps_the_promise_and_a_dearer_one_is_better() -> None:
    film, shot = film_with_shot(KINDS[1])
    errors = []
    for quality in get_args(Quality):
        (done,) = rendered(film, [shot], "constrained", rules=load_rules(quality).tier.render)
        ratio, alike = figures(done.clip.driving, film, shot, done.planned.window.start)
        assert ratio >= 0.83
        assert alike >= 0.95
        errors.append(1.0 + ratio**2 - 2.0 * ratio * alike)  # |felt - wanted|^2 / |wanted|^2, what is minimised
    assert errors == sorted(errors, reverse=True)


@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
def test_constrained_drive_is_silent_until_its_lead(filters: DriveFilters) -> None:
    film, shot = film_with_shot(bed=0.01)
    for lead_ms in (0.0, 1.0, 3.0, 100.0):
        (done,) = rendered(film, [shot], "constrained", filters=filters, rules=altered(lead_ms=lead_ms))
        start = done.planned.window.start
        lead = min(round(lead_ms * 48), shot.onset - start)
        assert not np.any(done.clip.driving[: shot.onset - start - lead])
        assert np.max(np.abs(done.clip.driving)) <= 1.0


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("background", BACKGROUNDS)
@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
@pytest.mark.parametrize("delay", [1, 7, 30_011])
def test_a_late_film_has_the_same_drive_later_to_the_bit(
    model: DriveModel, background: Background, filters: DriveFilters, delay: int
) -> None:
    # 0.1 s before the shot: less than the pre-roll, so that the delay lengthens it by silence
    film, shot = film_with_shot(before_s=0.1, after_s=0.2)
    late_shot = shot_at(shot.onset + delay)
    (once,) = rendered(film, [shot], model, background=background, filters=filters)
    (late,) = rendered(
        np.concatenate([np.zeros(delay), film]), [late_shot], model, background=background, filters=filters
    )
    assert late.clip.start == once.clip.start + delay
    assert np.array_equal(late.clip.samples, once.clip.samples)
    assert late.drives == once.drives


@pytest.mark.parametrize("model", MODELS)
def test_more_audio_than_needed_changes_no_bit(model: DriveModel) -> None:
    film, shot = film_with_shot(before_s=1.5, after_s=1.5)
    for filters in (CAUSAL, ZERO):
        (narrow,) = rendered(film, [shot], model, filters=filters)
        some = clip(film).slice(needed_audio(narrow.planned, frames=len(film), filters=filters, rules=RENDER))
        least, most = (
            hear_window(audio, narrow.planned, filters=filters, rules=RENDER) for audio in (some, clip(film))
        )
        wide = render_window(most, [shot], model=model, reason="test", background="mute")
        assert np.array_equal(wide.clip.samples, narrow.clip.samples)
        assert measure(least) == measure(most)


@pytest.mark.parametrize("bed", [1e-3, 0.05])
def test_windowed_filter_is_the_filter_over_the_whole_track(bed: float) -> None:
    film, shot = film_with_shot(peak=0.1, before_s=3.0, bed=bed * 0.1)
    film += 0.02 * np.sin(2.0 * np.pi * 31.0 / RATE_HZ * np.arange(len(film)))  # rumble that runs through
    whole = compensated(film, CAUSAL)
    full = altered(preroll_ms=1e4)
    for rules, bar_db in ((RENDER, -80.0), (full, -np.inf)):
        (done,) = rendered(film, [shot], "filter", rules=rules)
        (info,) = done.drives
        assert "scaled" not in info.reason
        core = done.planned.core
        found = done.clip.slice(core).driving
        error = np.max(np.abs(found - whole[core.start : core.stop])) / np.max(np.abs(found))
        assert error == 0.0 if bar_db == -np.inf else 20.0 * np.log10(error) <= bar_db


def test_filter_within_the_limit_is_felt_as_the_target() -> None:
    film, shot = film_with_shot(peak=0.1, bed=0.0)
    (done,) = rendered(film, [shot], "filter")
    (info,) = done.drives
    assert info.reason == "test"
    ratio, alike = figures(done.clip.driving, film, shot, done.planned.window.start)
    assert ratio == pytest.approx(1.0, abs=2e-3)
    assert alike == pytest.approx(1.0, abs=1e-4)
    assert info.fidelity == pytest.approx(alike, abs=1e-9)


def test_filter_beyond_the_limit_is_scaled_not_clipped_and_says_so() -> None:
    film, shot = film_with_shot()
    (done,) = rendered(film, [shot], "filter")
    (info,) = done.drives
    assert "scaled" in info.reason
    assert info.peak == 1.0
    core = done.planned.core
    unlimited = compensated(film, CAUSAL)[core.start : core.stop]
    found = done.clip.slice(core).driving
    np.testing.assert_allclose(found, unlimited / np.max(np.abs(unlimited)), atol=1e-3)


def test_filter_just_beyond_the_limit_says_a_peak_that_is_beyond_it() -> None:
    film, shot = film_with_shot(peak=0.05, bed=0.0)
    (within,) = rendered(film, [shot], "filter")
    (beyond,) = rendered(film * (1.0004 / within.drives[0].peak), [shot], "filter")
    said = re.search(r"peak is (\S+) of the limit, so the window is scaled", beyond.drives[0].reason)
    assert said is not None
    assert float(said[1]) == pytest.approx(1.0004, abs=5e-5)


@pytest.mark.parametrize("model", ["direct", "filter"])
def test_level_raises_what_is_driven(model: DriveModel) -> None:
    film, shot = film_with_shot(peak=0.05)
    (plain,) = rendered(film, [shot], model)
    (louder,) = rendered(film, [shot], model, rules=altered(level_db=6.0))
    np.testing.assert_allclose(louder.clip.samples, 10.0 ** (6.0 / 20.0) * plain.clip.samples, rtol=1e-9, atol=1e-15)
    assert louder.drives[0].perceived_gain_db == pytest.approx(plain.drives[0].perceived_gain_db + 6.0, abs=1e-6)


def test_a_level_below_the_limit_changes_nothing_in_how_near_direct_conversion_is() -> None:
    film, shot = film_with_shot(peak=0.05)
    usual, louder = (
        measure(hear_window(clip(film), only_window(film, shot), filters=CAUSAL, rules=rules))
        for rules in (RENDER, altered(level_db=6.0))
    )
    assert louder.direct_level_db == pytest.approx(usual.direct_level_db, abs=1e-9)
    assert louder.direct_fidelity == pytest.approx(usual.direct_fidelity, abs=1e-9)


def test_lower_level_is_followed_more_faithfully() -> None:
    film, shot = film_with_shot()
    found = [
        rendered(film, [shot], "constrained", rules=altered(level_db=level_db))[0].drives[0].fidelity
        for level_db in (6.0, 0.0, -6.0, -18.0)
    ]
    assert found == sorted(found)
    assert found[2] > 0.985
    assert found[3] > 0.998


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("phase_filters", [CAUSAL, ZERO], ids=["causal", "zero"])
@pytest.mark.parametrize("scale", [0.0, 1e-300, 1e-30, 1e-6, 1.0, 1e6, 1e30])
def test_extreme_levels_give_finite_figures(model: DriveModel, phase_filters: DriveFilters, scale: float) -> None:
    film, shot = film_with_shot(before_s=0.05, after_s=0.1)
    film = scale * film
    for background in BACKGROUNDS:
        (done,) = rendered(film, [shot], model, background=background, filters=phase_filters)
        assert np.all(np.isfinite(done.clip.samples))
        assert np.max(np.abs(done.clip.samples)) <= 1.0
        assert all(np.isfinite(figure) for figure in plain(done.drives[0]))
        evidence = measure(hear_window(clip(film), done.planned, filters=phase_filters, rules=RENDER))
        assert np.all(np.isfinite([evidence.direct_level_db, evidence.direct_fidelity, evidence.filter_peak]))
    if scale == 0.0:
        assert not np.any(done.clip.samples)
        assert plain(done.drives[0]) == (0.0, 0.0, 1.0)


def plain(info: DriveInfo) -> tuple[float, float, float]:
    return info.peak, info.perceived_gain_db, info.fidelity


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("background", BACKGROUNDS)
@pytest.mark.parametrize("frames", [1, 2, 40, 3000])
@pytest.mark.parametrize("place", ["first", "last"])
def test_shots_on_the_first_and_last_frame_and_films_of_one(
    model: DriveModel, background: Background, frames: int, place: str
) -> None:
    onset = 0 if place == "first" else frames - 1
    film = np.zeros(frames)
    film[onset] = 1.0
    shot = msgspec.structs.replace(shot_at(onset), span=Span(onset, onset))
    for filters in (CAUSAL, ZERO):
        (done,) = rendered(film, [shot], model, background=background, filters=filters)
        assert done.clip.span.start == max(0, onset - 288)
        assert done.clip.span.stop == min(frames, onset + 1 + 1920)
        assert np.all(np.isfinite(done.clip.samples))
        assert all(np.isfinite(figure) for figure in plain(done.drives[0]))
        if place == "first" and model == "direct":
            assert done.clip.samples[0, 0] == 1.0, "no room for a fade: full weight at once"


def test_sound_beyond_full_scale_is_held_inside_the_window() -> None:
    film, shot = film_with_shot(peak=3.0)
    (done,) = rendered(film, [shot], "direct", background="direct")
    assert np.array_equal(done.clip.driving, np.clip(film[done.clip.start : done.clip.span.stop], -1.0, 1.0))
    assert done.drives[0].perceived_gain_db == 0.0, "compared with the direct conversion that can be played"


def test_direct_conversion_over_its_own_background_is_the_sound_to_the_bit() -> None:
    film, shot = film_with_shot()
    (done,) = rendered(film, [shot], "direct", background="direct")
    assert np.array_equal(done.clip.driving, film[done.clip.start : done.clip.span.stop])
    assert done.drives[0].perceived_gain_db == 0.0


def test_fades_join_the_background_and_the_attack_is_whole() -> None:
    film, shot = film_with_shot()
    (mute,) = rendered(film, [shot], "filter")
    window = mute.planned.window
    whole = compensated(film, CAUSAL)[window.start : window.stop]
    whole /= np.max(np.abs(whole))
    found = mute.clip.driving
    assert np.max(np.abs(found[:5])) < 0.01 * np.max(np.abs(whole[:5]))
    assert np.max(np.abs(found[-5:])) < 0.01 * np.max(np.abs(whole[-5:]))
    full = slice(shot.onset - 48 - window.start, -window.fade_out_samples)
    np.testing.assert_allclose(found[full], whole[full], atol=2e-4)


def test_drive_reads_the_driving_column() -> None:
    film, shot = film_with_shot()
    heard = np.random.default_rng(1).standard_normal(len(film))
    planned = only_window(film, shot)
    two = Clip(np.stack([heard, film], axis=1), RATE_HZ)
    one, other = (
        render_window(
            hear_window(audio, planned, filters=CAUSAL, rules=RENDER),
            [shot],
            model="constrained",
            reason="test",
            background="direct",
        )
        for audio in (clip(film), two)
    )
    assert np.array_equal(one.clip.samples, other.clip.samples)


def test_each_shot_of_a_burst_has_its_own_figures() -> None:
    quiet, first = film_with_shot(KINDS[0], peak=0.2, before_s=0.3, after_s=0.1)
    loud, second = film_with_shot(KINDS[1], peak=0.9, before_s=0.001, after_s=0.4)
    film = np.concatenate([quiet, loud])
    shots = [first, shot_at(len(quiet) + second.onset)]
    shots = [msgspec.structs.replace(shots[0], span=Span(first.onset, len(quiet))), shots[1]]
    (done,) = rendered(film, shots, "direct")
    assert done.planned.shots == (0, 1)
    assert done.drives[0].peak == pytest.approx(0.2, abs=0.01)
    assert done.drives[1].peak == pytest.approx(0.9, abs=0.01)
    (done,) = rendered(film, shots, "constrained")
    assert done.drives[0].fidelity > 0.999, "the quiet shot hardly meets the limit, whatever follows it"
    assert 0.95 < done.drives[1].fidelity < 0.99
    assert done.drives[1].peak == 1.0


def test_evidence_tells_a_strong_scene_from_a_weak_one() -> None:
    weak, shot = film_with_shot(peak=0.9)
    planned = only_window(weak, shot)
    evidence = measure(hear_window(clip(weak), planned, filters=CAUSAL, rules=RENDER))
    assert -12.0 < evidence.direct_level_db < -8.0
    assert 0.7 < evidence.direct_fidelity < 0.85
    assert 4.0 < evidence.filter_peak < 7.0
    quieter = measure(hear_window(clip(0.1 * weak), planned, filters=CAUSAL, rules=RENDER))
    assert quieter.filter_peak == pytest.approx(0.1 * evidence.filter_peak, rel=1e-9)
    assert quieter.direct_level_db == pytest.approx(evidence.direct_level_db, abs=1e-6)
    (done,) = rendered(weak, [shot], "direct")
    ratio, alike = figures(done.clip.driving, weak, shot, planned.window.start)
    assert evidence.direct_level_db == pytest.approx(20.0 * np.log10(ratio), abs=0.1)
    assert evidence.direct_fidelity == pytest.approx(alike, abs=0.01)


def test_filters_of_another_rate_are_refused() -> None:
    film, shot = film_with_shot()
    with pytest.raises(ValueError, match="filters for 44100 Hz cannot render audio at 48000 Hz"):
        measure(
            hear_window(
                clip(film), only_window(film, shot), filters=drive_filters(PROFILE, 44_100, "causal"), rules=RENDER
            )
        )


@given(
    st.lists(st.integers(0, 19_999), min_size=1, max_size=5),
    st.sampled_from(MODELS),
    st.sampled_from(BACKGROUNDS),
    st.integers(0, 99),
)
@settings(max_examples=25)
def test_any_shots_anywhere(onsets: list[int], model: DriveModel, background: Background, seed: int) -> None:
    film = 0.5 * np.random.default_rng(seed).standard_normal(20_000)
    shots = [msgspec.structs.replace(shot_at(onset), span=Span(onset, onset + 900)) for onset in onsets]
    done = rendered(film, shots, model, background=background)
    assert sum(len(each.drives) for each in done) == len(shots)
    for each in done:
        assert each.clip.span == each.planned.window.span
        assert np.max(np.abs(each.clip.samples)) <= 1.0
        assert all(-1.0 <= info.fidelity <= 1.0 and info.peak <= 1.0 for info in each.drives)
