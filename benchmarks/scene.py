"""What choosing by scene saves and costs: `python benchmarks/scene.py [--quality standard] [--minutes 20]`.

Over the fixtures, and over a film of mixed scenes, holds what a run does against doing everything everywhere: every
candidate of the scan goes through all networks and is segmented, every window gets the constrained drive. CPU after the
scan, without checks and files; F1 at 10 ms; of the shots of the run's own windows, the correlation of what is felt with
the target and the ratio of their rms, as `blastline study rendering` has them.

Then it asks from which probability by the screen on a candidate is clear enough to spare it the networks: what it gives
less than `look_from` is dropped, unless it makes a row of fire with what it gives more; what it gives `sure_from` or
more is believed. The first is in the quality rules.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import process_time

import msgspec
import numpy as np
from film import made_of
from numpy.typing import NDArray

from blastline import scene
from blastline.detect import Verifier, find_shots, fire, verifier_of
from blastline.detect.backdrop import LEVELS
from blastline.detect.candidates import Passes, candidate_places, describe_candidates, let_all_pass
from blastline.detect.chunks import chunks
from blastline.detect.contrast import contrasts
from blastline.detect.find import select_shots
from blastline.detect.forest import forest_log_odds
from blastline.detect.network import network_log_odds
from blastline.detect.segment import segment
from blastline.detect.spectrogram import spectrograms
from blastline.detect.tracks import Grid, pieces
from blastline.detect.verify import Sieve, Verdicts, combined_log_odds, log_odds_in
from blastline.model import FIRE, DriveChoice, DriveModel, Shot, ShotEvidence, Span
from blastline.render import drive_filters, hear_window, measure, needed_audio, plan_windows, render_window
from blastline.render.filters import felt
from blastline.ruleset import Rules, load_actuator, load_rules
from blastline.soundtrack import Soundtrack, open_soundtrack
from blastline.study.matching import Counts, count
from blastline.study.truth import synthesised
from blastline.synth import Truth, decode_truth

BLOCK = 65_536
LOOK_FROM = (0.0, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.15)
LOSS = 0.005
SURE_FROM = (1.0, 0.99, 0.98, 0.97, 0.95, 0.9)
BEDS = ("dialogue", "music", "ambience", "engine", "crowd", "drums", "wind", "rain")


@dataclass
class Way:
    """What one way of working a set of films took and found."""

    detect_s: float = 0.0
    render_s: float = 0.0
    counts: Counts = field(default_factory=lambda: Counts(0, 0, 0))
    ratio: list[float] = field(default_factory=list)
    correlation: list[float] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class SeenFilm:
    """What was seen of a film's candidates: the screen's log-odds, those of each network, and the parts of each."""

    screen: NDArray[np.float64]
    networks: NDArray[np.float64]
    shots: tuple[Shot, ...]
    truth: Truth
    look_s: float


def mixed_film(minutes: float) -> str:
    """Return a film of scenes of a minute, each with its own beds; shots in bursts of scenes, others without a gun."""
    lines = ["schema = 1", "rate_hz = 48000", f"duration_s = {minutes * 60.0}", "seed = 2024"]
    for minute in range(int(minutes)):
        for number, level in ((minute % 8, -30.0), ((minute * 3 + 1) % 8, -42.0)):
            lines += ["[[beds]]", f'kind = "{BEDS[number]}"', f"level_dbfs = {level}"]
            lines += [f"start_s = {minute * 60.0}", f"stop_s = {minute * 60.0 + 60.0}"]
    shots = round(4 * minutes)
    return "\n".join([*lines, "[random]", f"shots = {shots}", f"negatives = {shots}", "shot_snr_db = [8.0, 40.0]", ""])


def _probability(odds: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.round(1.0 / (1.0 + np.exp(-odds)), 4), np.float64)


def passing(sieve: Sieve, least: float | None) -> Passes:
    """Return what a sieve lets pass, wherever it is: what it gives so much, or without that its own threshold."""
    return lambda rows, _: sieve.probabilities(rows) >= (sieve.threshold if least is None else least)


def look_at(track: Soundtrack, truth: Truth, rules: Rules, verifier: Verifier, *, sieved: bool) -> SeenFilm:
    """Show the candidates of a film, or what of them is `sieved`, to all networks at all speeds and segment them."""
    grid, tier = Grid(track.rate_hz), rules.tier
    gate = passing(verifier.gate, tier.verify.gate_from) if sieved else let_all_pass
    screen = passing(verifier.screen, tier.verify.row_from) if sieved else let_all_pass
    odds, networks, shots, look_s = [], [], [], 0.0
    for chunk in chunks(pieces(track.blocks(BLOCK), track.rate_hz)):
        found = describe_candidates(chunk, grid, tier, gate=gate, screen=screen)
        began = process_time()
        speeds = (1.0, *tier.verify.speeds)
        looks = [contrasts(spectrograms(chunk.samples, found.onsets, track.rate_hz, speed=speed)) for speed in speeds]
        by_look = [[network_log_odds(each, found.rows, seen) for each in verifier.networks] for seen in looks]
        networks.append(np.mean(by_look, axis=0))
        look_s += process_time() - began
        odds.append(forest_log_odds(found.rows, verifier.screen.forest))
        part = partial(segment, chunk.samples, film_start=chunk.start, film_stop=chunk.stop, confidence=0.0)
        shots += [part(int(onset), rate_hz=track.rate_hz, rules=tier.segment) for onset in found.onsets]
    return SeenFilm(np.concatenate(odds), np.concatenate(networks, axis=1), tuple(shots), truth, look_s)


def believed(film: SeenFilm, probability: NDArray[np.float64], rules: Rules) -> tuple[Shot, ...]:
    """Return the shots that a run makes of a film's candidates with these probabilities; 0 for those never judged."""
    tier, rate_hz = rules.tier, film.truth.rate_hz
    seen = np.flatnonzero(probability > 0.0)
    onsets = np.array([film.shots[place].onset for place in seen], np.intp)
    peaks_dbfs = np.array([film.shots[place].peak_dbfs for place in seen])
    odds = log_odds_in(
        Verdicts(probability[seen], _probability(film.screen[seen]), np.full(seen.size, len(film.networks)))
    )
    unheard = np.zeros((seen.size, LEVELS), np.int16)  # rows do not ask what their sounds are like
    rows = fire.even_rows(fire.ScoredCandidates(onsets, peaks_dbfs, odds, unheard), rate_hz=rate_hz, tier=tier)
    enough = [
        msgspec.structs.replace(
            film.shots[place],
            confidence=float(probability[place]),
            evidence=ShotEvidence(None, 0, None, "background", even_row=row),
        )
        for place, row in zip(seen, rows, strict=True)
        if probability[place] >= tier.verify.round_threshold or row in FIRE
    ]
    return select_shots(enough, (), rate_hz=rate_hz, tier=tier).shots


def counted(shots: Sequence[Shot], truth: Truth) -> Counts:
    """Return hits, false events and misses at 10 ms, as `blastline study detection` counts them."""
    found_ms = np.array([shot.onset for shot in shots], np.float64) * 1000.0 / truth.rate_hz
    others = [tuple(at * 1000.0 / truth.rate_hz for at in shot.accept_samples) for shot in truth.shots]
    forgiven = [each.at_s * 1000.0 for each in truth.negatives if each.kind == "explosion"]
    true_ms = np.array([shot.onset_s * 1000.0 for shot in truth.shots])
    return count(found_ms, true_ms, 10.0, alternatives_ms=others, forgiven_ms=forgiven)


def scan_s(path: Path, rules: Rules) -> float:
    """Return the CPU seconds of reading a film and naming its candidates."""
    with open_soundtrack(path) as track:
        began = process_time()
        for chunk in chunks(pieces(track.blocks(BLOCK), track.rate_hz)):
            candidate_places(chunk, Grid(track.rate_hz), rules.tier)
        return process_time() - began


def rendered(track: Soundtrack, shots: Sequence[Shot], rules: Rules, choice: DriveChoice, way: Way) -> None:
    """Render the windows of some shots and add what it took and what is felt of each shot."""
    profile, _ = load_actuator("crowson-t108sm")
    filters, tier = drive_filters(profile, track.rate_hz, "causal"), rules.tier
    frames = track.source().frames
    for planned in plan_windows(shots, frames=frames, rate_hz=track.rate_hz, rules=tier.windows):
        began = process_time()
        audio = track.read(needed_audio(planned, frames=frames, filters=filters, rules=tier.render))
        heard = hear_window(audio, planned, filters=filters, rules=tier.render)
        model: DriveModel = "constrained"
        reason = ""
        if choice == "auto":
            model, reason = scene.choose(measure(heard), rules.scenes, choice)
        done = render_window(heard, shots, model=model, reason=reason, background="mute")
        way.render_s += process_time() - began
        vibration = felt(np.asarray(done.clip.driving, np.float64), filters)
        onsets = [shots[index].onset for index in planned.shots]
        for onset, stop in zip(onsets, [*onsets[1:], planned.core.stop], strict=True):
            part = Span(onset, max(onset + 1, stop)) & planned.window.span
            inside = slice(part.start - planned.window.start, part.stop - planned.window.start)
            is_felt, wanted = vibration[inside], heard.target[inside]
            norms = float(np.linalg.norm(is_felt)), float(np.linalg.norm(wanted))
            if min(norms) > 0.0:
                way.ratio.append(norms[0] / norms[1])
                way.correlation.append(float(is_felt @ wanted) / (norms[0] * norms[1]))


def compared(films: Iterator[tuple[Path, Truth]], rules: Rules) -> tuple[Way, Way, Way, list[SeenFilm]]:
    """Return a set's films worked by choice, with every window constrained, and with everything done; what was seen."""
    verifier = verifier_of(rules.tier)
    chosen, constrained, everything, seen = Way(), Way(), Way(), []
    for path, truth in films:
        scanning_s = scan_s(path, rules)
        with open_soundtrack(path) as track:
            began = process_time()
            found = find_shots(track.blocks(BLOCK), rate_hz=track.rate_hz, tier=rules.tier, verifier=verifier)
            chosen.detect_s += process_time() - began - scanning_s
            chosen.counts += counted(found.shots, truth)
            rendered(track, found.shots, rules, "auto", chosen)
            rendered(track, found.shots, rules, "constrained", constrained)
        with open_soundtrack(path) as track:
            began = process_time()
            every = look_at(track, truth, rules, verifier, sieved=False)
            odds = combined_log_odds(every.networks.sum(axis=0), every.networks.shape[0], every.screen)
            shots = believed(every, _probability(odds), rules)
            everything.detect_s += process_time() - began - scanning_s
            everything.counts += counted(shots, truth)
            rendered(track, shots, rules, "constrained", everything)
        with open_soundtrack(path) as track:
            seen.append(look_at(track, truth, rules, verifier, sieved=True))
    return chosen, constrained, everything, seen


def spared(seen: Sequence[SeenFilm], rules: Rules, look_from: float, sure_from: float) -> tuple[float, Counts]:
    """Return the share of candidates behind gate and screen that networks look at, and what is found then."""
    counts, shown, every = Counts(0, 0, 0), 0, 0
    verify = msgspec.structs.replace(rules.tier.verify, look_from=look_from)
    tier = msgspec.structs.replace(rules.tier, verify=verify)
    for film in seen:
        screened = _probability(film.screen)
        onsets = np.array([shot.onset for shot in film.shots], np.intp)
        peaks_dbfs = np.array([shot.peak_dbfs for shot in film.shots])
        passed = fire.worth_a_look(onsets, peaks_dbfs, screened, least=0.0, rate_hz=film.truth.rate_hz, tier=tier)
        sure = (screened >= sure_from) & (sure_from < 1.0)
        odds = combined_log_odds(film.networks.sum(axis=0), film.networks.shape[0], film.screen)
        probability = np.where(sure, screened, np.where(passed, _probability(odds), 0.0))
        shown, every = shown + int((passed & ~sure).sum()), every + screened.size
        counts += counted(believed(film, probability, rules), film.truth)
    return shown / max(every, 1), counts


def show(name: str, chosen: Way, constrained: Way, everything: Way) -> None:
    """Print a set's rows."""
    for how, way in (("by scene", chosen), ("everything", everything)):
        felt_way = chosen if way is chosen else constrained
        fidelity = f"{np.mean(felt_way.ratio):.4f} | {np.mean(felt_way.correlation):.4f}"
        total_s = way.detect_s + way.render_s
        cpu = f"{way.detect_s:.2f} | {way.render_s:.2f} | {total_s:.2f}"
        print(f"| {name} | {how} | {cpu} | {way.counts.f1:.4f} | {fidelity} |", flush=True)
    spent = (chosen.detect_s + chosen.render_s) / (everything.detect_s + everything.render_s)
    print(f"{name}: {spent:.2f} of the CPU; rendering alone {chosen.render_s / constrained.render_s:.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quality", default="standard", choices=("draft", "standard", "reference"))
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--fixtures", type=Path, default=Path("fixtures"))
    options = parser.parse_args()
    rules = load_rules(options.quality)
    film = made_of(f"mixed{options.minutes:g}", mixed_film(options.minutes))
    truth = decode_truth(film.with_suffix(".truth.json").read_bytes())
    fixtures = ((path, truth) for _, path, truth in synthesised(sorted(options.fixtures.glob("*.toml"))))
    print("| films | way | detection, CPU s | rendering | both | F1 | ratio | correlation |\n" + "| --- " * 8 + "|")
    seen: list[SeenFilm] = []
    for name, films in (("fixtures", fixtures), (f"mixed, {options.minutes:g} min", iter([(film, truth)]))):
        chosen, constrained, everything, looks = compared(films, rules)
        show(name, chosen, constrained, everything)
        seen += looks
    look_s = sum(each.look_s for each in seen)
    print(f"\nNetworks at everything behind gate and screen: {look_s:.2f} CPU s\n")
    print("| look_from | sure_from | looked at | precision | recall | F1 |\n| --- | --- | --- | --- | --- | --- |")
    cheapest, (_, whole) = 0.0, spared(seen, rules, 0.0, 1.0)
    for look_from, sure_from in (*((low, 1.0) for low in LOOK_FROM), *((0.0, high) for high in SURE_FROM[1:])):
        share, counts = spared(seen, rules, look_from, sure_from)
        scores = f"{counts.precision:.3f} | {counts.recall:.3f} | {counts.f1:.4f}"
        print(f"| {look_from:g} | {sure_from:g} | {share:.3f} | {scores} |", flush=True)
        if sure_from == 1.0 and counts.f1 >= whole.f1 - LOSS:
            cheapest = max(cheapest, look_from)
    print(
        f"\n[verify] look_from = {cheapest:g} loses no more than {LOSS:g} of F1; it is {rules.tier.verify.look_from:g}"
    )


if __name__ == "__main__":
    main()
