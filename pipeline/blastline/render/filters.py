"""The filters of a film's drive, designed once: the band, the compensator, and what is felt of a drive."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Phase, Span
from ..ruleset import ActuatorProfile, RenderRules
from ..units import samples_from_ms
from .banded import Recursion
from .renderable import require_renderable
from .windows import PlannedWindow

Samples = NDArray[np.float64]

_RECURSION_ERROR = 1e-3  # so much of the impulse response may a shorter recursion miss: the solver is faster by it
_FREE_SAMPLES = 3  # samples that a recursion has to itself before its poles ring
_WELL_FELT = 0.1  # of the most in the band; of seats that answer so above half the corners' rate, draft lost up to 40 %
_NEGLIGIBLE_SHARE = 1e-10  # an impulse response ends where this much of its peak is left: far below 24-bit audio

_LONGEST_SUMMED_S = 2.0  # a longer pre-roll is run: with all of the film, to the bits of the whole track

_SLOWEST = 1.0 - 1e-6  # a pole nearer to the unit circle is taken as this one: it rings on for minutes


@dataclass(frozen=True, eq=False)
class DriveFilters:
    """Second-order sections, shape (sections, 6), float64, for one actuator at one sample rate.

    `band` and `compensator` run forwards. With phase "zero" they hold half of the band's roll-off each, and `band`
    runs backwards over their output as well. After `ring_samples` of silence both have faded. `felt` is H, `impulse`
    its impulse response until it has faded, and `recursion` H for the solver: of the actuator's own poles alone where
    that is close enough, else of all that the sections have.
    """

    rate_hz: int
    phase: Phase
    band: Samples
    compensator: Samples
    ring_samples: int
    felt: Samples
    impulse: Samples
    recursion: Recursion


def drive_filters(profile: ActuatorProfile, rate_hz: int, phase: Phase) -> DriveFilters:
    """Return the filters that make the drive for an actuator; RuleError as `require_renderable`."""
    require_renderable(profile, rate_hz)
    felt = dsp.felt_response(profile)
    sections = dsp.discretise(felt, rate_hz)
    # twice, since poles that lie together fade later than one; the sections' own may be slower than a fast actuator's
    impulse = _until_faded(dsp.run_filter(sections, np.concatenate([[1.0], np.zeros(2 * _ring_samples(sections))])))
    band = dsp.band_sections(profile, rate_hz, phase, lean=True)
    compensator = dsp.compensator_sections(profile, rate_hz, phase, lean=True)
    return DriveFilters(
        rate_hz,
        phase,
        band=band,
        compensator=compensator,
        ring_samples=max(_ring_samples(band), _ring_samples(compensator)),
        felt=sections,
        impulse=impulse,
        recursion=_recursion(
            np.exp(felt.poles / rate_hz), sections, impulse, longest_stride=_longest_stride(profile, rate_hz)
        ),
    )


def preroll(filters: DriveFilters, rules: RenderRules) -> int:
    """Return the samples before a window from which the filters start, so that they have settled when it begins."""
    slowest_s = filters.ring_samples / filters.rate_hz / -math.log(_NEGLIGIBLE_SHARE)
    return samples_from_ms(dsp.preroll_ms(rules.preroll_ms, slowest_s), filters.rate_hz)


def needed_audio(planned: PlannedWindow, *, frames: int, filters: DriveFilters, rules: RenderRules) -> Span:
    """Return the part of the film that rendering a window listens to: what is filtered, and where that begins with the
    film, the opening that tells what the film stands on.
    """
    filtered = filtered_audio(planned, frames=frames, filters=filters, rules=rules)
    opening = dsp.opening_frames(frames, filters.rate_hz) if filtered.start == 0 else 0
    return Span(filtered.start, max(filtered.stop, opening))


def filtered_audio(planned: PlannedWindow, *, frames: int, filters: DriveFilters, rules: RenderRules) -> Span:
    """Return a window with the pre-roll before it and, where the phase is zero, as much after it."""
    roll = preroll(filters, rules)
    after = roll if filters.phase == "zero" else 0
    return Span(max(0, planned.window.start - roll), min(frames, planned.window.stop + after))


def in_band(samples: Samples, filters: DriveFilters) -> Samples:
    """Return the sound in the band, shape (frames,), which the felt vibration is to follow; after it is silence."""
    return _both_ways(filters.band, samples, filters)


def compensated(samples: Samples, filters: DriveFilters) -> Samples:
    """Return the drive, shape (frames,), that would make felt the sound in the band if the actuator had no limit."""
    return _both_ways(filters.compensator, samples, filters)


def settled_band(samples: Samples, inside: slice, filters: DriveFilters, rules: RenderRules) -> Samples:
    """Return `in_band` for the samples inside alone, shape (inside,), those around them being its pre-roll."""
    return _inside(filters.band, samples, inside, filters, preroll(filters, rules))


def settled_compensated(samples: Samples, inside: slice, filters: DriveFilters, rules: RenderRules) -> Samples:
    """Return `compensated` for the samples inside alone, shape (inside,), those around them being its pre-roll."""
    return _inside(filters.compensator, samples, inside, filters, preroll(filters, rules))


def felt(drive: Samples, filters: DriveFilters) -> Samples:
    """Return what is felt of a drive that starts from rest, shape (frames,), predicted by H."""
    return dsp.run_filter(filters.felt, drive)


def _both_ways(sections: Samples, samples: Samples, filters: DriveFilters) -> Samples:
    """Return the samples through sections and, where the phase is zero, backwards through the band."""
    if filters.phase == "causal":
        return dsp.run_filter(sections, samples)
    ended = _ringing_on(samples, filters.ring_samples)
    return dsp.run_both_ways(sections, ended, backwards=filters.band)[: len(samples)]


def _inside(sections: Samples, samples: Samples, inside: slice, filters: DriveFilters, roll: int) -> Samples:
    """Return the samples inside through sections and, where the phase is zero, backwards through the band.

    Where fewer than the pre-roll follow, the film has ended there and is followed by silence.
    """
    if filters.phase == "causal":
        return _settled(sections, samples, inside.start, filters, roll)[: inside.stop - inside.start]
    ended = _ringing_on(samples, min(filters.ring_samples, max(0, roll - (len(samples) - inside.stop))))
    forwards = _settled(sections, ended, inside.start, filters, roll)
    return _settled(filters.band, forwards[::-1], len(ended) - inside.stop, filters, roll)[::-1]


def _ringing_on(samples: Samples, silence: int) -> Samples:
    """Return samples with silence after them: what a filter still rings there belongs to what runs backwards."""
    return np.concatenate([samples, np.zeros(silence)])


def _settled(sections: Samples, samples: Samples, start: int, filters: DriveFilters, roll: int) -> Samples:
    """Return the samples from `start` on through sections that have heard those before it, from rest."""
    if roll > _LONGEST_SUMMED_S * filters.rate_hz:
        return dsp.run_filter(sections, samples)[start:]
    for_band, for_compensator = _settlings(filters, roll)
    settling = for_band if sections is filters.band else for_compensator
    return dsp.run_filter(sections, samples[start:], state=dsp.settled_state(settling, samples[:start]))


@lru_cache(maxsize=8)
def _settlings(filters: DriveFilters, roll: int) -> tuple[dsp.Settling, dsp.Settling]:
    return dsp.settling(filters.band, roll), dsp.settling(filters.compensator, roll)


def _ring_samples(sections: Samples) -> int:
    """Return the samples after which what sections ring is negligible."""
    slowest = min(float(np.max(np.abs(_poles(sections)))), _SLOWEST)
    return math.ceil(math.log(_NEGLIGIBLE_SHARE) / math.log(slowest))


def _poles(sections: Samples) -> NDArray[np.complex128]:
    """Return the poles of sections, but for those at 0, which only delay."""
    poles = np.concatenate([np.roots(section[3:]) for section in sections]).astype(np.complex128)
    return poles[np.abs(poles) > 0.0]


def _until_faded(response: Samples) -> Samples:
    """Return an impulse response up to the last sample that is not negligible against its peak."""
    heard = np.flatnonzero(np.abs(response) > _NEGLIGIBLE_SHARE * np.max(np.abs(response)))
    return response[: int(heard[-1]) + 1]


def _longest_stride(profile: ActuatorProfile, rate_hz: int) -> int:
    """Return how many samples apart the corners of a drive may be: half their rate reaches as high as is well felt."""
    felt, low_hz, high_hz = dsp.felt_response(profile), profile.highpass.corner_hz, profile.lowpass.corner_hz
    frequencies_hz = np.sort([*dsp.telling_hz(felt, 1.0, rate_hz / 2.0, 1000), low_hz, high_hz])
    gain = np.abs(felt.at(frequencies_hz))
    in_band = (frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)
    highest_hz = frequencies_hz[gain >= _WELL_FELT * np.max(gain[in_band])][-1]
    return max(1, int(rate_hz / (2.0 * highest_hz)))


def _recursion(poles: NDArray[np.complex128], sections: Samples, impulse: Samples, *, longest_stride: int) -> Recursion:
    """Return a recursive filter of an impulse response: of these poles if it comes close, else of all the sections'."""
    fitted = np.concatenate([impulse[:_FREE_SAMPLES], _ringing_in(poles, impulse[_FREE_SAMPLES:])])
    if np.linalg.norm(fitted - impulse) <= _RECURSION_ERROR * np.linalg.norm(impulse):
        return Recursion(poles, fitted, _FREE_SAMPLES, longest_stride)
    every = _poles(sections)
    free = max(_FREE_SAMPLES, 2 * len(sections) + 1 - len(every))
    return Recursion(every, impulse, free, longest_stride)


def _ringing_in(poles: NDArray[np.complex128], response: Samples) -> Samples:
    """Return what of a response the ringing of poles explains, by least squares.

    By the orthonormal functions of these poles (Ninness and Gustafsson 1997), each an all-pass further than the one
    before: the powers of near or slow poles are too alike to be told apart.
    """
    from scipy.signal import lfilter

    explained = np.zeros(len(response))
    all_passed = np.zeros(len(response), np.complex128)
    all_passed[:1] = 1.0
    for pole in poles:
        base = math.sqrt(1.0 - abs(pole) ** 2) * lfilter([1.0], [1.0, -pole], all_passed)
        explained += (np.vdot(base, response) * base).real
        all_passed = lfilter([-np.conj(pole), 1.0], [1.0, -pole], all_passed)
    return explained
