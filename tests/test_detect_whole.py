"""A film is the same wherever the cores end in which it is searched: all that is told of it is told by the whole."""

from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect import Detection, find, find_shots, verifier_of
from blastline.detect.backdrop import LEVELS
from blastline.detect.fire import ScoredCandidates
from blastline.detect.sides import Found
from blastline.detect.verify import LogOdds, log_odds_of
from blastline.detect.whole import ChunkResult, MixResult, of_whole_film
from blastline.model import Clip, HeardIn, Shot, ShotEvidence, Span
from blastline.ruleset import load_rules
from blastline.soundtrack import open_soundtrack
from blastline.synth import Scene, render_scene

RATE_HZ = 48_000
RULES = load_rules("standard")
VERIFIER = verifier_of(RULES.tier)
WHOLE = 100
"""Pieces, of a second each, of a core that holds all of the film."""


def row(at_s: float, azimuth_deg: float, snr_db: float, shots: int) -> dict[str, object]:
    return {
        "at_s": at_s,
        "weapon": "smg",
        "environment": "street",
        "distance_m": 12.0,
        "snr_db": snr_db,
        "azimuth_deg": azimuth_deg,
        "burst": {"shots": shots, "rpm": 600.0},
    }


def alone(at_s: float, azimuth_deg: float, snr_db: float) -> dict[str, object]:
    shot = row(at_s, azimuth_deg, snr_db, 2)
    return {name: value for name, value in shot.items() if name != "burst"} | {"weapon": "pistol"}


SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 34.0,
    "seed": 11,
    "layout": "stereo",
    "beds": [{"kind": "dialogue", "level_dbfs": -20.0}, {"kind": "ambience", "level_dbfs": -52.0}],
    "shots": [
        *(alone(at_s, 24.0, level_db) for at_s, level_db in ((2.0, 4.0), (4.3, 0.0), (7.1, 8.0), (9.2, 2.0))),
        *(row(at_s, -20.0, level_db, 6) for at_s, level_db in ((12.2, 4.0), (16.1, 12.0), (20.4, 8.0))),
        *(alone(at_s, -12.0, level_db) for at_s, level_db in ((24.5, 3.0), (26.8, -2.0), (30.2, 6.0))),
    ],
}


ROW = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 9.0,
    "seed": 3,
    "beds": [{"kind": "ambience", "level_dbfs": -46.0}],
    "shots": [
        {
            "at_s": 3.7,
            "weapon": "rifle",
            "environment": "indoors",
            "distance_m": 39.0,
            "snr_db": 15.7,
            "burst": {"shots": 25, "rpm": 922.0, "jitter": 0.03},
        }
    ],
    "negatives": [{"at_s": 7.2, "kind": "rotor", "snr_db": 7.4}],
}


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import soundfile

    audio = render_scene(msgspec.convert(SCENE, Scene))
    path = tmp_path_factory.mktemp("whole") / "film.wav"
    soundfile.write(path, audio.read(0, audio.frames), RATE_HZ, subtype="FLOAT")
    return path


def found(film: Path, core_pieces: int) -> Detection:
    with pytest.MonkeyPatch.context() as patch, open_soundtrack(film) as track:
        patch.setattr(find, "SHORT_CORE_PIECES", core_pieces)
        blocks = track.blocks(sides=True)
        return find_shots(blocks, rate_hz=RATE_HZ, tier=RULES.tier, verifier=VERIFIER, channels=track.channels_in_space)


@pytest.mark.parametrize("core_pieces", [4, 5, 7])
def test_a_sound_beside_the_middle_has_the_same_parts_wherever_cores_end(film: Path, core_pieces: int) -> None:
    """What the mains hardly hear may be a shot by what lies beyond a core: it gets no parts in the mains for that."""
    whole = found(film, WHOLE)
    assert {shot.heard_in for shot in whole.shots} == {"mains", "sides"}
    assert found(film, core_pieces) == whole


def test_a_row_is_as_long_wherever_a_core_cuts_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which sounds are in it depends on what else is there, in no row: all of that is heard beyond a core as well."""
    audio = render_scene(msgspec.convert(ROW, Scene))
    samples = audio.read(0, audio.frames)[:, :1].astype(np.float32)
    heard = []
    for core_pieces in (WHOLE, 4, 5):
        monkeypatch.setattr(find, "CORE_PIECES", core_pieces)
        blocks = [Clip(samples, RATE_HZ)]
        heard.append(find_shots(blocks, rate_hz=RATE_HZ, tier=RULES.tier, verifier=VERIFIER))
    assert len(heard[0].shots) > 20
    assert heard[1:] == heard[:1] * 2


def shot(onset: int, probability: float) -> Shot:
    span = Span(onset, onset + 100)
    evidence = ShotEvidence(probability, 1, None, "fallen")
    return Shot(onset, probability, -6.0, 20.0, span, (), span, evidence=evidence)


def mix(onsets: NDArray[np.intp], probabilities: NDArray[np.float64], as_well: NDArray[np.bool_]) -> MixResult:
    """Return what is found of a mix where everything is segmented that its networks score."""
    odds = log_odds_of(probabilities)
    unheard = np.zeros((onsets.size, LEVELS), np.int16)
    scored = ScoredCandidates(onsets, np.full(onsets.size, -6.0), LogOdds(odds, odds, odds), unheard)
    shots = [shot(*each) for each in zip(onsets.tolist(), probabilities.tolist(), strict=True)]
    beside = [msgspec.structs.replace(each, azimuth_deg=10.0) for each in shots]
    return MixResult(shots, [], scored, beside, as_well)


@pytest.mark.parametrize("seed", range(8))
def test_what_the_whole_tells_does_not_depend_on_where_chunks_end(seed: int) -> None:
    """Between the beginnings of one sound in both mixes, within a row that the mains hear as well, or anywhere."""
    rng = np.random.default_rng(seed)
    rows = [start + 4_800 * np.arange(6) for start in rng.integers(0, 900_000, 8)]
    places = np.unique(np.concatenate([rng.integers(0, 1_000_000, 40), *rows]))
    places = places[np.diff(places, prepend=-1_000) > 500]
    heard: dict[HeardIn, tuple[NDArray[np.intp], NDArray[np.float64]]] = {
        "mains": (places, rng.random(places.size)),
        "sides": (places + rng.integers(-240, 241, places.size), rng.random(places.size)),
    }
    as_well = rng.random(places.size) < 0.8

    def told(ends: NDArray[np.intp]) -> Found:
        edges, chunks = [-1_000, *ends.tolist(), 2_000_000], list[ChunkResult]()
        for first, last in pairwise(edges):
            parts = dict[HeardIn, MixResult]()
            for name, (onsets, probabilities) in heard.items():
                own = (onsets >= first) & (onsets < last)
                parts[name] = mix(onsets[own], probabilities[own], as_well[own] & (name == "sides"))
            chunks.append(parts)
        return of_whole_film(chunks, rate_hz=RATE_HZ, tier=RULES.tier)

    whole = told(places[:0])
    assert {each.heard_in for each in whole[0]} == {"mains", "sides"}
    assert {each.azimuth_deg for each in whole[0]} == {None, 10.0}
    for beside in (0, 1, 120):
        assert told(places[:: int(rng.integers(2, 9))] + beside) == whole
