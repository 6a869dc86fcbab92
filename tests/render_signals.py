"""Synthetic gunshots for the tests of rendering: Friedlander blast, ground echo, decaying tail, quiet bed."""

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from blastline.model import Clip, Shot, Span
from blastline.render import DriveFilters, PlannedWindow, drive_filters, plan_windows
from blastline.ruleset import ActuatorProfile, RenderRules, load_actuator, load_rules
from blastline.units import samples_from_ms

RATE_HZ = 48_000
TIER = load_rules("standard").tier
RENDER, WINDOWS = TIER.render, TIER.windows
PROFILE: ActuatorProfile = load_actuator("crowson-t108sm")[0]
CAUSAL: DriveFilters = drive_filters(PROFILE, RATE_HZ, "causal")
ZERO: DriveFilters = drive_filters(PROFILE, RATE_HZ, "zero")

# positive phase, decay and echo delay in ms: near pistol to far rifle
KINDS = ((0.6, 120.0, 9.0), (1.0, 180.0, 12.0), (1.5, 250.0, 18.0), (2.5, 300.0, 30.0), (0.8, 500.0, 45.0))


def altered(**changes: float) -> RenderRules:
    return msgspec.structs.replace(RENDER, **changes)


def shot_at(onset: int, *, decay_ms: float = 400.0, rate_hz: int = RATE_HZ) -> Shot:
    return Shot(
        onset=onset,
        confidence=1.0,
        peak_dbfs=-1.0,
        snr_db=40.0,
        blast=Span(onset, onset + samples_from_ms(6.0, rate_hz)),
        reflections=(),
        span=Span(onset, onset + samples_from_ms(decay_ms, rate_hz)),
    )


def film_with_shot(
    kind: tuple[float, float, float] = KINDS[1],
    *,
    seed: int = 0,
    peak: float = 0.9,
    before_s: float = 0.6,
    after_s: float = 0.5,
    bed: float = 1e-3,
    rate_hz: int = RATE_HZ,
) -> tuple[NDArray[np.float64], Shot]:
    """Return a film of one column and its shot."""
    positive_ms, decay_ms, echo_ms = kind
    random = np.random.default_rng(seed)
    onset = round(before_s * rate_hz)
    time_ms = np.arange(round(after_s * rate_hz)) * 1e3 / rate_hz

    def blast(at_ms: NDArray[np.float64]) -> NDArray[np.float64]:
        late = np.maximum(at_ms, 0.0) / positive_ms
        return np.where(at_ms >= 0.0, (1.0 - late) * np.exp(-late), 0.0)

    tail = sosfilt(butter(2, [80.0, 2500.0], "band", fs=rate_hz, output="sos"), random.standard_normal(len(time_ms)))
    tail *= np.exp(-3.0 * time_ms / decay_ms) * (1.0 - np.exp(-time_ms / 2.0)) / np.max(np.abs(tail))
    bang = blast(time_ms) + 0.5 * blast(time_ms - echo_ms) + 0.4 * tail
    film = np.concatenate([np.zeros(onset), peak * bang / np.max(np.abs(bang))])
    film += bed * random.standard_normal(len(film))
    return film, shot_at(onset, rate_hz=rate_hz)


def clip(film: NDArray[np.float64], rate_hz: int = RATE_HZ) -> Clip:
    return Clip(film[:, None], rate_hz)


def only_window(film: NDArray[np.float64], shot: Shot, rate_hz: int = RATE_HZ) -> PlannedWindow:
    (planned,) = plan_windows([shot], frames=len(film), rate_hz=rate_hz, rules=WINDOWS)
    return planned
