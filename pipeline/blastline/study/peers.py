"""What others find in the same films: onset detectors, each where it is installed, each at its own best threshold.

Each peer is a function of the sound that is worked out once, and a threshold that picks onsets from it; where the
library does both at once, each threshold listens anew. Thresholds are chosen on what is scored, for each window anew,
which flatters the peers.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .matching import Times

HOP_MS = 5.0
_STA_MS, _LTA_MS = 2.0, 200.0

Samples = NDArray[np.float32]


@dataclass(frozen=True)
class Peer:
    """An onset detector: `prepare` gives what `pick` needs to find onsets, in milliseconds, at a threshold."""

    name: str
    package: str
    thresholds: tuple[float, ...]
    prepare: Callable[[Samples, int], Any]
    pick: Callable[[Any, int, float], Times]


def installed(peers: Iterable[Peer] | None = None) -> tuple[tuple[Peer, ...], tuple[str, ...]]:
    """Return the peers whose package is there, and the packages that are not."""
    every = tuple(PEERS if peers is None else peers)
    there = {peer.package: find_spec(peer.package) is not None for peer in every}
    return tuple(peer for peer in every if there[peer.package]), tuple(
        name for name, found in there.items() if not found
    )


def _itself(samples: Samples, rate_hz: int) -> Samples:
    """Return the sound for a library that does all at once."""
    return samples


def _librosa_strength(samples: Samples, rate_hz: int) -> Any:
    from librosa.onset import onset_strength

    return onset_strength(y=samples, sr=rate_hz, hop_length=_hop(rate_hz))


def _librosa_onsets(strength: Any, rate_hz: int, threshold: float) -> Times:
    """Return librosa's onsets, backtracked to the rise."""
    from librosa.onset import onset_backtrack, onset_detect

    hop = _hop(rate_hz)
    found = onset_detect(onset_envelope=strength, sr=rate_hz, hop_length=hop, delta=threshold)
    if len(found) == 0:
        return np.empty(0)
    return np.asarray(np.unique(onset_backtrack(found, strength)) * (1000.0 * hop / rate_hz), np.float64)


def _obspy_ratio(samples: Samples, rate_hz: int) -> Any:
    """Return the recursive ratio of the short to the long average, as seismologists pick arrivals."""
    from obspy.signal.trigger import recursive_sta_lta

    sta, lta = (max(2, round(ms * rate_hz / 1000.0)) for ms in (_STA_MS, _LTA_MS))
    if samples.size <= lta:
        return np.zeros(samples.size)
    return recursive_sta_lta(np.asarray(samples, np.float64), sta, lta)


def _obspy_onsets(ratio: Any, rate_hz: int, threshold: float) -> Times:
    from obspy.signal.trigger import trigger_onset

    spans = trigger_onset(ratio, threshold, threshold / 2.0)
    return np.array([first for first, _ in spans], np.float64) * (1000.0 / rate_hz)


def _aubio_onsets(samples: Samples, rate_hz: int, threshold: float) -> Times:
    """Return aubio's onsets by high-frequency content."""
    import aubio

    hop = _hop(rate_hz)
    detector = aubio.onset("hfc", 1024, hop, rate_hz)
    detector.set_threshold(threshold)
    onsets = []
    for start in range(0, samples.size - hop + 1, hop):
        if detector(samples[start : start + hop]):
            onsets.append(detector.get_last_ms())
    return np.array(onsets, np.float64)


def _auditok_onsets(samples: Samples, rate_hz: int, threshold: float) -> Times:
    """Return where auditok says that activity begins, in windows of 10 ms over an energy threshold in its own dB."""
    import auditok

    pcm = np.asarray(np.clip(samples * 32767.0, -32768.0, 32767.0), np.int16).tobytes()
    regions: Any = auditok.split(
        pcm,
        sampling_rate=rate_hz,
        sample_width=2,
        channels=1,
        min_dur=0.01,
        max_dur=5.0,
        max_silence=0.03,
        analysis_window=0.01,
        energy_threshold=threshold,
    )
    return np.array([region.start * 1000.0 for region in regions], np.float64)


def _essentia_content(samples: Samples, rate_hz: int) -> Any:
    """Return essentia's high-frequency content, frame by frame, at the frame rate that its picking is made for."""
    es = _essentia()
    window, spectrum = es.Windowing(type="hann", size=1024), es.Spectrum(size=1024)
    content = es.OnsetDetection(method="hfc", sampleRate=float(rate_hz))
    phase = np.zeros(513, np.float32)
    frames = es.FrameGenerator(samples, frameSize=1024, hopSize=_essentia_hop(rate_hz), startFromZero=False)
    return np.array([content(spectrum(window(frame)), phase) for frame in frames], np.float32)


def _essentia_onsets(content: Any, rate_hz: int, threshold: float) -> Times:
    if content.size < 2:
        return np.empty(0)
    pick = _essentia().Onsets(frameRate=rate_hz / _essentia_hop(rate_hz), alpha=threshold)
    return np.asarray(pick(content[None, :], np.ones(1, np.float32)), np.float64) * 1000.0


def _essentia() -> Any:
    """Return the library, kept from talking to the terminal."""
    import essentia

    essentia.log.infoActive = essentia.log.warningActive = False
    import essentia.standard

    return essentia.standard


def _essentia_hop(rate_hz: int) -> int:
    return max(1, round(rate_hz * 512 / 44_100))


def _hop(rate_hz: int) -> int:
    return max(1, round(HOP_MS * rate_hz / 1000.0))


PEERS: Sequence[Peer] = (
    Peer("librosa onset_detect", "librosa", (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6), _librosa_strength, _librosa_onsets),
    Peer("aubio hfc", "aubio", (0.05, 0.1, 0.3, 0.6, 1.0, 2.0, 3.0), _itself, _aubio_onsets),
    Peer("obspy STA/LTA", "obspy", (4.0, 6.0, 8.0, 11.0, 14.0, 18.0, 24.0), _obspy_ratio, _obspy_onsets),
    Peer("auditok", "auditok", (40.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0), _itself, _auditok_onsets),
    Peer("essentia hfc", "essentia", (0.05, 0.1, 0.3, 0.6, 0.9), _essentia_content, _essentia_onsets),
)
