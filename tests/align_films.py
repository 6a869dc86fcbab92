"""Short films made in code for the tests of checks and report: shots over a quiet bed, and a drive that fits them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blastline import dsp
from blastline.align import check_files
from blastline.model import (
    SCHEMA,
    ActuatorRef,
    Background,
    Check,
    Clip,
    DriveInfo,
    DriveModel,
    Event,
    Phase,
    Reflection,
    Rejection,
    Source,
    Span,
    Timeline,
    Window,
)
from blastline.ruleset import ActuatorProfile, load_actuator, load_rules

Samples = NDArray[np.float64]

PROFILE: ActuatorProfile
DIGEST: str
PROFILE, DIGEST = load_actuator("crowson-t108sm")
RULES = load_rules("standard").align
RATE_HZ = 48_000


@dataclass(frozen=True, eq=False)
class Held:
    """A file held in memory, as the checks see one; it refuses to read past its ends."""

    samples: NDArray[Any]
    rate_hz: int
    block: int = 65_536

    damaged_samples: int = 0

    @property
    def frames(self) -> int:
        return len(self.samples)

    def read(self, span: Span, *, sides: bool = False) -> Clip:
        if span.start < 0 or span.stop > self.frames:
            raise ValueError(f"{span} lies outside {self.frames} frames")
        return Clip(self.samples[span.start : span.stop, None].astype(np.float64), self.rate_hz, span.start)

    def blocks(self) -> Iterator[Clip]:
        for start in range(0, self.frames, self.block):
            yield Clip(self.samples[start : start + self.block, None].astype(np.float32), self.rate_hz, start)


@dataclass(frozen=True, eq=False)
class Film:
    """Soundtrack, drive and timeline that belong together."""

    audio: Held
    drive: Held
    timeline: Timeline

    def with_drive(self, samples: Samples, rate_hz: int | None = None) -> "Film":
        """Return the film with another drive, in 24-bit steps as a file holds it."""
        return replace(self, drive=Held(in_24_bits(samples), rate_hz or self.drive.rate_hz))

    def with_events(self, *events: Event) -> "Film":
        """Return the film with other events in its timeline."""
        import msgspec

        return replace(self, timeline=msgspec.structs.replace(self.timeline, events=events))


def in_24_bits(samples: Samples) -> Samples:
    """Return samples in steps of 24-bit PCM."""
    return np.clip(np.rint(samples * 2**23), -(2**23), 2**23 - 1) / 2**23


def one_shot(seed: int, rate_hz: int, *, peak: float, tail: float = 0.1, length_s: float = 0.3) -> tuple[Samples, int]:
    """Return a Friedlander blast with one echo and a decaying noisy tail, and the echo's delay in samples."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(length_s * rate_hz)) / rate_hz
    positive_s = rng.uniform(0.6e-3, 4e-3)
    blast = (1.0 - t / positive_s) * np.exp(-t / positive_s)
    delay = round(rng.uniform(0.02, 0.06) * rate_hz)
    sound = blast.copy()
    sound[delay:] += 0.5 * blast[: len(t) - delay]
    rumble = dsp.run_filter(dsp.discretise(dsp.band(PROFILE), rate_hz), rng.standard_normal(len(t)))
    sound += tail * rumble / np.std(rumble) * np.exp(-t / 0.08)
    return peak * sound / np.abs(sound).max(), delay


def make_film(
    *,
    onsets_s: tuple[float, ...] = (0.7, 1.6, 2.9, 4.1, 5.0),
    peaks: tuple[float, ...] = (0.05, 0.5, 0.1, 0.9, 0.06),
    seconds: float = 6.0,
    rate_hz: int = RATE_HZ,
    phase: Phase = "causal",
    background: Background = "mute",
    model: DriveModel | None = None,
    bed: float = 1e-4,
    rumble: float = 0.0,
    tail: float = 0.1,
    level_db: float = 0.0,
    offset: float = 0.0,
    seed: int = 0,
) -> Film:
    """Return a film of single shots; those whose compensated drive exceeds the limit get a constrained one.

    The bed is white noise and, by `rumble`, noise in the band of vibration; both are rms. Peaks over 1 are clipped. All
    of it stands `offset` off zero.
    """
    rng = np.random.default_rng(seed)
    audio = bed * rng.standard_normal(round(seconds * rate_hz))
    if rumble:
        felt_bed = dsp.run_filter(dsp.discretise(dsp.band(PROFILE), rate_hz), rng.standard_normal(len(audio)))
        audio += rumble * felt_bed / np.std(felt_bed)
    echoes = []
    for index, (onset_s, peak) in enumerate(zip(onsets_s, peaks, strict=True)):
        sound, delay = one_shot(seed * 1000 + index, rate_hz, peak=peak, tail=tail)
        onset = round(onset_s * rate_hz)
        sound = sound[: len(audio) - onset]
        audio[onset : onset + len(sound)] += sound
        echoes.append(delay)
    audio = in_24_bits(audio + offset)
    drive = audio.copy() if background == "direct" else np.zeros_like(audio)
    events = []
    for index, onset_s in enumerate(onsets_s):
        onset = round(onset_s * rate_hz)
        window = window_around(onset, len(audio), rate_hz)
        wet, how = make_drive(audio, window, onset, rate_hz=rate_hz, phase=phase, model=model, level_db=level_db)
        inside = slice(window.start, window.stop)
        drive[inside] = dsp.cross_fade(drive[inside], wet, weights_of(window))
        events.append(event_of(index, audio, drive, window, onset, echoes[index], rate_hz, how))
    return Film(Held(audio, rate_hz), Held(in_24_bits(drive), rate_hz), timeline_of(audio, events, rate_hz))


def timeline_of(audio: Samples, events: list[Event], rate_hz: int) -> Timeline:
    """Return the timeline of a film's events."""
    return Timeline(
        schema=SCHEMA,
        version="0",
        quality="standard",
        rules_digest="ab" * 32,
        source=Source("film.wav", "cd" * 32, rate_hz, len(audio), 1, "01:00:00:00", "24"),
        actuator=ActuatorRef(PROFILE.name, DIGEST),
        events=tuple(events),
        rejections=(Rejection(rate_hz // 4, "probability", {"probability": 0.21}),),
        checks=(),
    )


def window_around(onset: int, frames: int, rate_hz: int) -> Window:
    """Return a window with a fade-in that is over 1 ms before the onset and 0.3 s of shot."""
    fade_in, guard, fade_out = (round(ms * rate_hz / 1000) for ms in (5.0, 1.0, 40.0))
    start = max(0, onset - guard - fade_in)
    stop = min(frames, onset + round(0.3 * rate_hz))
    return Window(start, stop, max(0, onset - guard - start), min(fade_out, stop - onset - 1))


def weights_of(window: Window) -> Samples:
    """Return the weight of a window's drive over the window."""
    weights = np.ones(len(window.span))
    weights[: window.fade_in_samples] = dsp.fade(window.fade_in_samples)
    weights[len(weights) - window.fade_out_samples :] = dsp.fade(window.fade_out_samples)[::-1]
    return weights


def make_drive(
    audio: Samples,
    window: Window,
    onset: int,
    *,
    rate_hz: int,
    phase: Phase,
    model: DriveModel | None,
    level_db: float = 0.0,
) -> tuple[Samples, DriveModel]:
    """Return the drive inside a window before its fades: the compensator's, or a limited one where that exceeds 1."""
    level = 10.0 ** (level_db / 20.0)
    if model == "direct":
        return np.clip(level * audio[window.start : window.stop], -1.0, 1.0), "direct"
    roll = round(0.5 * rate_hz)
    start, stop = max(0, window.start - roll), min(len(audio), window.stop + roll)
    inside = slice(window.start - start, window.stop - start)
    piece = _off_nothing(audio, rate_hz)[start:stop]
    if phase == "causal":
        target = dsp.run_filter(dsp.discretise(dsp.band(PROFILE), rate_hz), piece)[inside]
        wet = dsp.run_filter(dsp.compensator_sections(PROFILE, rate_hz, phase, lean=True), piece)[inside]
    else:
        half = dsp.half_band(PROFILE)
        back = dsp.discretise(half, rate_hz)
        target = dsp.run_filter(back, dsp.run_filter(back, piece)[::-1])[::-1][inside]
        forwards, backwards = (
            sections(PROFILE, rate_hz, phase, lean=True) for sections in (dsp.compensator_sections, dsp.band_sections)
        )
        wet = dsp.run_both_ways(forwards, piece, backwards=backwards)[inside]
    if level * np.abs(wet).max() <= 1.0:
        return level * wet, "filter"
    return limited(level * target, onset - round(1e-3 * rate_hz) - window.start, rate_hz), "constrained"


def _off_nothing(audio: Samples, rate_hz: int) -> Samples:
    """Return a film's sound without the constant on which it stands, which no drive follows."""
    return audio - dsp.opening_level(audio[:rate_hz], rate_hz)


def limited(target: Samples, first: int, rate_hz: int, *, stop: int | None = None, iterations: int = 150) -> Samples:
    """Return the drive within the limit, 0 outside `first` to `stop`, that is felt most like the target (FISTA)."""
    from scipy import fft

    size = fft.next_fast_len(2 * len(target), real=True)
    response = fft.rfft(_impulse(len(target), rate_hz), size)
    step = 1.0 / float(np.max(np.abs(response) ** 2))
    drive = ahead = np.zeros(len(target))
    momentum = 1.0
    for _ in range(iterations):
        error = fft.irfft(fft.rfft(ahead, size) * response, size)[: len(target)] - target
        slope = fft.irfft(np.conj(response) * fft.rfft(error, size), size)[: len(target)]
        after = np.clip(ahead - step * slope, -1.0, 1.0)
        after[: max(0, first)] = 0.0
        after[len(target) if stop is None else stop :] = 0.0
        following = (1.0 + (1.0 + 4.0 * momentum**2) ** 0.5) / 2.0
        ahead, drive = after + (momentum - 1.0) / following * (after - drive), after
        momentum = following
    return np.asarray(drive, dtype=np.float64)


def _impulse(samples: int, rate_hz: int) -> Samples:
    return dsp.run_filter(dsp.discretise(dsp.felt_response(PROFILE), rate_hz), np.eye(1, samples)[0])


def event_of(
    index: int,
    audio: Samples,
    drive: Samples,
    window: Window,
    onset: int,
    delay: int,
    rate_hz: int,
    how: DriveModel,
    *,
    stop: int | None = None,
) -> Event:
    """Return the event of a shot whose drive, over the film, is compared up to `stop`, or to its window's fade-out."""
    blast = Span(onset, onset + round(4e-3 * rate_hz))
    echo = Reflection(onset + delay, onset + delay + len(blast), 1000.0 * delay / rate_hz, -6.0)
    core = slice(onset - window.start, (stop or window.stop - window.fade_out_samples) - window.start)
    felt_sections = dsp.discretise(dsp.felt_response(PROFILE), rate_hz)
    felt, plain = (dsp.run_filter(felt_sections, s[window.start : window.stop])[core] for s in (drive, audio))
    sound = _off_nothing(audio, rate_hz)[window.start : window.stop]
    band = dsp.run_filter(dsp.discretise(dsp.band(PROFILE), rate_hz), sound)[core]
    gain_db = 20.0 * np.log10(np.linalg.norm(felt) / np.linalg.norm(plain))
    fidelity = float(np.dot(felt, band) / (np.linalg.norm(felt) * np.linalg.norm(band)))
    peak = float(np.abs(drive[window.start : window.stop]).max())
    seconds = onset / rate_hz
    return Event(
        id=f"shot-{index + 1:04d}",
        onset_sample=onset,
        onset_s=seconds,
        timecode=f"01:00:{int(seconds):02d}:{int(seconds % 1 * 24):02d}",
        confidence=0.55 + 0.4 * ((index * 7) % 10) / 10,
        burst=None,
        shot_in_burst=None,
        peak_dbfs=float(20.0 * np.log10(np.abs(audio[onset : blast.stop]).max())),
        snr_db=40.0 - index,
        blast=blast,
        reflections=(echo,),
        window=window,
        drive=DriveInfo(how, "made for a test", peak, float(gain_db), fidelity),
    )


def checks_of(film: Film, phase: Phase = "causal", background: Background = "mute") -> tuple[Check, ...]:
    return check_files(
        film.timeline,
        audio=film.audio,
        drive=film.drive,
        profile=PROFILE,
        rules=RULES,
        lead_ms=1.0,
        preroll_ms=600.0,
        corner_ms=1000.0 / RATE_HZ,
        phase=phase,
        background=background,
    )


def failed(checks: tuple[Check, ...]) -> set[str]:
    return {check.name for check in checks if not check.passed}


def figure(checks: tuple[Check, ...], name: str, event: str | None = None) -> float:
    (measured,) = (check.measured for check in checks if check.name == name and check.event == event)
    assert measured is not None
    return measured
