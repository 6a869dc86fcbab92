"""What somebody else did to a drive fails its checks by name, without a crash."""

from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.model import DriveChoice, Event, Phase, Quality, Span, Timeline, encode
from blastline.run import RenderOptions
from blastline.soundtrack import Cue
from blastline.soundtrack.bwf import cue_chunks
from checked_films import RATE_HZ, Samples, failures, film, rendered


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("share", [0.9, 0.5])
def test_a_clipped_drive_fails_by_as_much_as_its_peak_lacks(tmp_path: Path, drive: DriveChoice, share: float) -> None:
    onsets = [14_400, 26_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.5, 0.3, 0.1])
    made = rendered(path, onsets, RenderOptions(report=False, drive=drive))
    assert failures(made) == []
    out = tmp_path / "out"
    samples, _ = soundfile.read(out / "drive.wav")
    peaks = [event.drive.peak for event in made.events if event.drive]
    limit = share * max(peaks)
    soundfile.write(tmp_path / "clipped.wav", np.clip(samples, -limit, limit), RATE_HZ, subtype="PCM_24")
    checked = run.check(out / "timeline.json", audio=path, drive=tmp_path / "clipped.wav")
    measured = {check.event: check for check in checked.checks if check.name == "peak_as_rendered"}
    for event, peak in zip(made.events, peaks, strict=True):
        assert measured[event.id].measured == pytest.approx(20.0 * np.log10(min(1.0, limit / peak)), abs=0.01)
        assert measured[event.id].passed == (limit >= 0.944 * peak)


def ended(drive: Samples, since: int) -> None:
    drive[since:] = 0.0


def turned_over(drive: Samples, since: int) -> None:
    drive[since:] *= -1.0


def with_a_hole(drive: Samples, since: int) -> None:
    drive[since : since + 240] = 0.0


def noisy(drive: Samples, since: int) -> None:
    drive[since:] += 0.05 * np.random.default_rng(5).standard_normal(drive[since:].size)


def in_8_bits(drive: Samples, since: int) -> None:
    drive[since:] = np.round(drive[since:] * 128) / 128


@pytest.mark.parametrize(
    ("change", "drive", "since_ms"),
    [
        *((change, drive, 250) for change in (ended, turned_over) for drive in ("direct", "filter", "constrained")),
        (ended, "direct", 100),
        *((with_a_hole, drive, 30) for drive in ("direct", "filter", "constrained")),
        *((noisy, drive, 30) for drive in ("direct", "filter", "constrained")),
        *((in_8_bits, drive, 30) for drive in ("direct", "filter")),
    ],
)
def test_what_is_wrong_with_a_drive_after_its_attack_fails_by_name(
    tmp_path: Path, change: Callable[[Samples, int], None], drive: DriveChoice, since_ms: int
) -> None:
    path = film(tmp_path / "film.wav", [14_400], [0.9], decay_s=0.15)
    made = rendered(path, [14_400], RenderOptions(report=False, drive=drive))
    assert failures(made) == []
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    window = made.events[0].window
    change(samples[: window.stop - window.fade_out_samples], 14_400 + 48 * since_ms)
    soundfile.write(tmp_path / "wrong.wav", np.clip(samples, -1.0, 1.0), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav")
    names = {name for name, _, _ in failures(checked)}
    assert "drive_as_rendered" in names
    assert names.isdisjoint({"drive_onset", "felt_onset", "drive_shift", "lag_as_rendered", "pre_echo"})


@pytest.mark.parametrize(("frequency_hz", "amplitude"), [(3000.0, 0.2), (8000.0, 0.5)])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_a_tone_above_the_band_fails_by_name(
    tmp_path: Path, frequency_hz: float, amplitude: float, phase: Phase, quality: Quality
) -> None:
    """It is hardly felt, and a drive at its limit has as much energy there by itself."""
    path = film(tmp_path / "film.wav", [14_400], [0.9])
    made = rendered(path, [14_400], RenderOptions(report=False, drive="constrained", phase=phase, quality=quality))
    assert failures(made) == []
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    window = made.events[0].window
    inside = np.arange(window.start + window.fade_in_samples, window.stop - window.fade_out_samples)
    samples[inside] += amplitude * np.sin(2 * np.pi * frequency_hz * inside / RATE_HZ)
    soundfile.write(tmp_path / "wrong.wav", np.clip(samples, -1.0, 1.0), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav")
    assert "drive_above_band" in {name for name, _, _ in failures(checked)}


def first_half(drive: Samples) -> Samples:
    return np.concatenate([drive[:20_000], np.zeros(drive.size - 20_000)])


def swapped(drive: Samples) -> Samples:
    return np.roll(drive, drive.size // 2)


def constant(drive: Samples) -> Samples:
    return np.full_like(drive, 0.3)


@pytest.mark.parametrize("wrong", [first_half, swapped, constant, np.flip])
def test_a_drive_that_is_not_this_films_fails_and_nothing_else_happens(
    tmp_path: Path, wrong: Callable[[Samples], Samples]
) -> None:
    onsets = [10_000, 30_000, 50_000]
    path = film(tmp_path / "film.wav", onsets, [0.3] * 3)
    rendered(path, onsets, RenderOptions(report=False, drive="direct"))
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "wrong.wav", wrong(drive), RATE_HZ, subtype="PCM_24")
    assert failures(run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav"))


@pytest.mark.parametrize("drive", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("level_db", [0.0, -4.5])
def test_a_gain_that_was_edited_and_not_rendered_fails_by_as_much(
    tmp_path: Path, drive: DriveChoice, level_db: float
) -> None:
    onsets = [14_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.1])
    made = rendered(path, onsets, RenderOptions(report=False, drive=drive, level_db=level_db), [-7.25, 2.1])
    assert failures(made) == []
    timeline = tmp_path / "out" / "timeline.json"

    def failed(before: str, after: str) -> dict[str | None, float | None]:
        edited = timeline.with_name("edited.json")
        text = timeline.read_text(encoding="utf-8")
        assert text.count(before) == 1
        edited.write_text(text.replace(before, after), encoding="utf-8")
        checked = run.check(edited, audio=path)
        return {event: aside for name, event, aside in failures(checked) if name == "gain_as_rendered"}

    assert failed('"gain_db": 2.1', '"gain_db": 2.1') == {}
    assert failed('"gain_db": 2.1', '"gain_db": 2.0') == {"shot-0002": pytest.approx(0.1)}
    assert failed(f'"level_db": {level_db}', '"level_db": 1.5') == {
        event: pytest.approx(level_db - 1.5) for event in ("shot-0001", "shot-0002")
    }


@pytest.mark.parametrize("by", [-240, -1, 1, 240])
def test_an_onset_that_was_edited_and_not_rendered_fails_by_as_much(tmp_path: Path, by: int) -> None:
    onsets = [14_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.1])
    rendered(path, onsets, RenderOptions(report=False))
    timeline = tmp_path / "out" / "timeline.json"
    text = timeline.read_text(encoding="utf-8")
    for key, at, moved in (
        ("onset_sample", 40_000, 40_000 + by),
        ("onset_s", 40_000 / RATE_HZ, (40_000 + by) / RATE_HZ),
    ):
        assert text.count(f'"{key}": {at}') == 1
        text = text.replace(f'"{key}": {at}', f'"{key}": {moved}')
    edited = timeline.with_name("edited.json")
    edited.write_text(text, encoding="utf-8")
    wrong = {event: aside for name, event, aside in failures(run.check(edited, audio=path)) if "onset_as" in name}
    assert wrong == {"shot-0002": pytest.approx(1000.0 * by / RATE_HZ)}


@pytest.mark.parametrize("index", [0, 1, 2])
@pytest.mark.parametrize("how", ["deleted", "without its drive"])
def test_a_shot_that_was_deleted_and_not_rendered_fails_and_is_named(tmp_path: Path, index: int, how: str) -> None:
    onsets = [14_400, 18_000, 21_600]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.3, 0.2])
    made = rendered(path, onsets, RenderOptions(report=False))
    assert len({event.window for event in made.events}) == 1
    assert figure_of(made, "shots_as_rendered") == (True, 0.0)
    gone = made.events[index]
    bare = () if how == "deleted" else (msgspec.structs.replace(gone, drive=None),)
    notes: list[str] = []
    edited = written(tmp_path, (*made.events[:index], *bare, *made.events[index + 1 :]), made)
    checked = run.check(edited, audio=path, note=notes.append)
    assert figure_of(checked, "shots_as_rendered") == (False, -1.0)
    [note] = notes
    assert f": lacks {gone.id}, " in note


@pytest.mark.parametrize("has_checks", [True, False])
@pytest.mark.parametrize(
    ("lost", "added"), [((1,), ()), ((), (20_000,)), ((1,), (20_000,)), ((0, 2), (16_000, 24_000)), ((), ())]
)
def test_the_markers_of_a_drive_tell_which_shots_it_was_rendered_with(
    tmp_path: Path, has_checks: bool, lost: Sequence[int], added: Sequence[int]
) -> None:
    """As many added as deleted, or without the checks, nothing else in the timeline tells."""
    onsets = [14_400, 18_000, 21_600]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.3, 0.2])
    made = rendered(path, onsets, RenderOptions(report=False))
    new = [moved(made.events[0], onset, f"door {number}") for number, onset in enumerate(added)]
    kept = [event for index, event in enumerate(made.events) if index not in lost]
    events = tuple(sorted((*kept, *new), key=lambda event: event.onset_sample))
    bare = made if has_checks else msgspec.structs.replace(made, checks=())
    notes: list[str] = []
    checked = run.check(written(tmp_path, events, bare), audio=path, note=notes.append)
    figure = len(added) - len(lost) or -len(lost)
    assert figure_of(checked, "shots_as_rendered") == (figure == 0, figure)
    gone, here = (", ".join(event.id for event in each) for each in ((made.events[i] for i in lost), new))
    expected = [f"lacks {gone}, which the drive was rendered with; "] * bool(lost)
    expected += [f"has {here}, which the drive was not rendered with; "] * bool(added)
    assert len(notes) == len(expected)
    assert all(f": {words}" in note for words, note in zip(expected, notes, strict=True))


def moved(event: Event, onset: int, name: str) -> Event:
    """Return a copy of an event elsewhere in its window, as somebody writes one who adds it to a timeline by hand."""
    by = onset - event.onset_sample
    blast = Span(event.blast.start + by, event.blast.stop + by)
    return msgspec.structs.replace(event, id=name, onset_sample=onset, onset_s=onset / RATE_HZ, blast=blast)


@pytest.mark.parametrize("has_checks", [True, False])
def test_a_drive_that_another_program_has_saved_names_no_shots(tmp_path: Path, has_checks: bool) -> None:
    """Its markers may be gone, or some of them, and others be there: only the checks in the timeline tell then."""
    onsets = [14_400, 18_000, 21_600]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.3, 0.2])
    made = rendered(path, onsets, RenderOptions(report=False))
    samples, _ = soundfile.read(tmp_path / "out" / "drive.wav", dtype="int32")
    bare = made if has_checks else msgspec.structs.replace(made, checks=())
    for tail in (cue_chunks([Cue(14_400, "shot-0001", 3_600)]), cue_chunks([Cue(30_000, "Marker 1")])):
        mixed = tmp_path / "mixed.wav"
        soundfile.write(mixed, samples, RATE_HZ, subtype="PCM_24")
        mixed.write_bytes(mixed.read_bytes() + tail)
        notes: list[str] = []
        checked = run.check(written(tmp_path, made.events, bare), audio=path, drive=mixed, note=notes.append)
        assert failures(checked) == []
        assert figure_of(checked, "shots_as_rendered") == (True, 0.0 if has_checks else None)
        assert notes == []
        checked = run.check(written(tmp_path, made.events[1:], bare), audio=path, drive=mixed, note=notes.append)
        assert figure_of(checked, "shots_as_rendered") == ((False, -1.0) if has_checks else (True, None))


def test_a_shot_that_was_given_another_id_needs_no_other_drive(tmp_path: Path) -> None:
    onsets = [14_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.2, 0.1])
    made = rendered(path, onsets, RenderOptions(report=False))
    first, second = made.events
    notes: list[str] = []
    renamed = written(tmp_path, (msgspec.structs.replace(first, id="door"), second), made)
    assert failures(run.check(renamed, audio=path, note=notes.append)) == []
    assert notes == []


def written(folder: Path, events: tuple[Event, ...], made: Timeline) -> Path:
    """Write a timeline with other events beside its drive and return it."""
    edited = folder / "out" / "edited.json"
    edited.write_bytes(encode(msgspec.structs.replace(made, events=events)))
    return edited


def figure_of(made: Timeline, name: str) -> tuple[bool, float | None]:
    """Return whether the film's check of a name passed, and what it measured."""
    [check] = [check for check in made.checks if check.name == name]
    return check.passed, check.measured
