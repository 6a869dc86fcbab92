"""The tables of `study rendering`, `study detection` and `study segmentation`."""

import math
from typing import TYPE_CHECKING

from ..plurals import counted

if TYPE_CHECKING:
    from ..study.bootstrap import Interval
    from ..study.detection import DetectionStudy
    from ..study.peer_scores import PeerScore
    from ..study.rendering import RenderingScore
    from ..study.segmentation import SegmentationScore
    from ..study.tally import DetectionScore, Timing


def rendering_table(score: "RenderingScore") -> str:
    """Return the weak shots with their drives, the means and the bars, those of the optima among them."""
    from ..study.drives import DRIVES

    lines = [
        f"quality {score.quality}, {score.actuator}: {len(score.shots['causal'])} of {score.all_shots} shots are weak:",
        "felt at less than half in direct conversion, and the compensator exceeds the limit",
        "ratio: felt rms / that of the sound in the band; corr: their correlation; lag of the constrained drive, ms",
        "",
        f"{'':<22} {'needs':>6}" + "".join(f" {name:>13}" for name in DRIVES) + f" {'lag':>7} {'steps':>5}",
        f"{'':<22} {'x':>6}" + "  ratio   corr" * len(DRIVES),
    ]
    for row in score.shots["causal"]:
        cells = "".join(f" {row.felt[name].ratio:6.3f} {row.felt[name].correlation:6.3f}" for name in DRIVES)
        lag_ms = row.felt["constrained"].lag_ms
        lines.append(f"{row.scene[:12]:<12} {row.onset_s:7.3f} s {row.needed:6.2f}{cells} {lag_ms:7.3f} {row.steps:5d}")
    for phase in score.shots:
        lines += ["", f"means, phase {phase}"]
        for scene in (*dict.fromkeys(row.scene for row in score.shots[phase]), None):
            means = [score.means(phase, name, scene) for name in DRIVES]
            cells = "".join(f" {each.ratio:6.3f} {each.correlation:6.3f}" for each in means)
            lines.append(f"{scene or 'all':<29}{cells} {means[-1].lag_ms:7.3f}")
    return "\n".join([*lines, "", *map(str, score.bars)])


def detection_table(study: "DetectionStudy") -> str:
    """Return what was found film by film, the figures of all films, and those of the peers."""
    lines = [f"{'film':<40} {'min':>6} {'shots':>6} {'found':>6} {'false':>6} {'missed':>7}"]
    lines += [
        f"{case.name[:40]:<40} {case.minutes:6.2f} {case.hits + case.missed:6d} {case.hits:6d} "
        f"{case.false:6d} {case.missed:7d}"
        for case in study.cases
        if case.hits + case.missed or case.false
    ]
    lines += [
        "",
        f"{study.protocol}; quality {study.quality}: {counted(study.score.shots, 'shot')} in "
        f"{study.score.minutes:.1f} min",
    ]
    lines += _figures(study.score)
    if study.peak_memory_mb is not None:
        lines.append(f"memory  {study.peak_memory_mb:.0f} MB at most, on the longest film")
    if study.peers:
        lines += ["", "peers, each window at the threshold that is best for it, chosen on what is scored"]
        lines += [_peer_line(peer) for peer in study.peers]
    if study.absent:
        lines.append(f"not installed: {', '.join(study.absent)}")
    return "\n".join(lines)


def _figures(score: "DetectionScore") -> list[str]:
    sure, bursts = score.intervals, score.bursts
    lines = [
        f"F1      {_by_window(score.f1_by_window_ms)}",
        f"at 10 ms, 95 % of films drawn anew: F1 {score.f1:.3f} ({sure.f1.low:.3f}-{sure.f1.high:.3f}), "
        f"precision {score.precision:.3f} ({sure.precision.low:.3f}-{sure.precision.high:.3f}), "
        f"recall {score.recall:.3f} ({sure.recall.low:.3f}-{sure.recall.high:.3f})",
    ]
    known = {window: rate for window, rate in score.error_rate_by_window_ms.items() if rate is not None}
    lines += [f"ER      {_by_window(known)}"] if known else []
    levels = ", ".join(f"{value:.3f} at {level} dB" for level, value in score.recall_by_snr_db.items())
    lines += [f"recall  {levels}"] if levels else []
    lines += [_timing_line("onset error of shots found within 50 ms", score.timing)] if score.timing else []
    lines += [_timing_line("onset error of clear shots within 10 ms", score.clear_timing)] if score.clear_timing else []
    if bursts is not None:
        lines.append(
            f"bursts  {bursts.bursts} of {bursts.shots} shots: recall {bursts.recall:.3f}, exact count "
            f"{bursts.exact:.3f}, count error {bursts.mean_error:+.2f}, without sign {bursts.mean_absolute_error:.2f}"
        )
    rate = "" if score.false_per_gun_free_hour is None else f", {score.false_per_gun_free_hour:.1f} an hour"
    lines.append(f"false events in {score.gun_free_minutes:.1f} gun-free minutes: {score.gun_free_false}{rate}")
    cost = score.cost
    lines.append(
        f"cost    {cost.times_read:.2f} times soundfile's read, {cost.cpu_s_per_hour:.2f} s of CPU an hour of film"
    )
    return lines


def _peer_line(peer: "PeerScore") -> str:
    thresholds = "/".join(f"{value:g}" for value in dict.fromkeys(peer.thresholds_by_window_ms.values()))
    cost = f"{peer.cost.times_read:.1f} times the read"
    return f"{peer.name:<22} F1 {_by_window(peer.f1_by_window_ms)}; {cost}; threshold {thresholds}"


def _by_window(scores: dict[str, float]) -> str:
    return ", ".join(f"{value:.3f} at {window} ms" for window, value in scores.items())


def _timing_line(name: str, timing: "Timing") -> str:
    return (
        f"{name}: median {timing.median_ms:.3f} ms, 95 % within {timing.p95_ms:.3f} ms, "
        f"bias {timing.bias_ms:+.3f} ms ({timing.shots})"
    )


def segmentation_table(score: "SegmentationScore") -> str:
    """Return how the reflections were found at true and at found onsets, and the bars."""

    def drawn(f1: float, within: "Interval") -> str:
        return f"{f1:.3f} ({within.low:.3f}-{within.high:.3f})"

    lines = [
        f"quality {score.quality}, {counted(score.films, 'film')}; reflections at 2 ms, 8-500 ms after the onset",
        "",
    ]
    lines += [f"{'':<16} {'heard':>6} {'precision':>10} {'recall':>8}  F1 and 95 % of draws"]
    for name, at in (("true onsets", score.at_true), ("found onsets", score.at_found)):
        strong = f"{at.asked:6d} {at.precision:10.3f} {at.recall:8.3f}  {drawn(at.f1, at.f1_range)}"
        every = f"{at.every_asked:6d} {at.every_precision:10.3f} {at.every_recall:8.3f}  "
        every += drawn(at.every_f1, at.every_f1_range)
        lines += [
            f"{name}, {counted(at.shots, 'shot')}",
            f"{'  from -12 dB on':<16} {strong}",
            f"{'  every':<16} {every}",
        ]
    lines += [
        "",
        f"{score.echoes_as_shots} of {score.echoes_heard} echoes are among the {score.found_shots} found shots",
    ]
    if any(math.isnan(bar.measured) for bar in score.bars):
        lines.append("nan: there is nothing that it could be measured on")
    return "\n".join([*lines, "", *(str(bar) for bar in score.bars)])
