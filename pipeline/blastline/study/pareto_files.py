"""The files of a study of the trade: every figure as JSON, a row for each setting as CSV, the front as a picture, and
the tables for a README.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import msgspec

from ..report.drawing import ready_to_draw
from .bootstrap import Interval
from .pareto import ParetoStudy
from .pareto_picture import front_svg
from .peer_scores import PeerScore
from .settings import TIERS
from .tally import DetectionScore

FILES = ("pareto.json", "pareto.csv", "pareto.svg", "pareto.md")
_COLUMNS = (
    "kind",
    "name",
    "on_front",
    "times_read",
    "cpu_s_per_hour",
    "f1_2ms",
    "f1_10ms",
    "f1_10ms_low",
    "f1_10ms_high",
    "f1_50ms",
    "f1_500ms",
    "precision",
    "recall",
    "burst_recall",
    "burst_exact",
    "false_per_gun_free_hour",
    "timing_median_ms",
    "timing_p95_ms",
    "timing_bias_ms",
    "ratio",
    "correlation",
    "lost",
    "above_best",
    "cpu_s_per_window_s",
)


def write_pareto(folder: Path, study: ParetoStudy) -> None:
    """Write all files of the study into a folder that exists."""
    (folder / "pareto.json").write_bytes(msgspec.json.format(msgspec.json.encode(study), indent=1) + b"\n")
    with (folder / "pareto.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, _COLUMNS, restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(_rows(study))
    ready_to_draw(folder)
    (folder / "pareto.svg").write_text(front_svg(study), encoding="utf-8")
    (folder / "pareto.md").write_text(markdown(study), encoding="utf-8")


def markdown(study: ParetoStudy) -> str:
    """Return the tiers and the peers as a Markdown table."""
    lines = [
        "| detection | CPU / read | F1 at 2 / 10 / 50 ms | at 10 ms, 95 % | precision / recall |",
        "| --- | --- | --- | --- | --- |",
    ]
    for score in [each for each in study.detection if each.name in TIERS]:
        lines.append(_row(score, score.intervals.f1))
    lines += [_row(peer, peer.f1_interval) for peer in study.peers]
    if study.rendering is not None:
        lines += [
            "",
            "| rendering | CPU s per s of window | level felt / heard | correlation | energy not felt as heard |",
            "| --- | --- | --- | --- | --- |",
        ]
        shown = ("direct", "clipped", "scaled", *TIERS)
        points = {point.name: point for point in study.rendering.points}
        lines += [
            f"| {p.name} | {p.cpu_s_per_window_s:.3f} | {p.ratio:.3f} | {p.correlation:.3f} | {100.0 * p.lost:.2f} % |"
            for p in (points[name] for name in shown)
        ]
    return "\n".join(lines) + "\n"


def _row(score: DetectionScore | PeerScore, sure: Interval) -> str:
    f1 = " / ".join(f"{score.f1_by_window_ms[window]:.3f}" for window in ("2", "10", "50"))
    interval = f"{sure.low:.3f} to {sure.high:.3f}"
    shares = f"{score.precision:.3f} / {score.recall:.3f}"
    return f"| {score.name} | {score.cost.times_read:.1f} | {f1} | {interval} | {shares} |"


def _rows(study: ParetoStudy) -> Iterator[dict[str, object]]:
    for score in study.detection:
        row = _shared("detection", score, score.intervals.f1) | {"on_front": int(score.name in study.on_front)}
        if score.bursts is not None:
            row |= {"burst_recall": score.bursts.recall, "burst_exact": score.bursts.exact}
        if score.timing is not None:
            timing = msgspec.structs.asdict(score.timing)
            row |= {f"timing_{key}": value for key, value in timing.items() if key != "shots"}
        if score.false_per_gun_free_hour is not None:
            row["false_per_gun_free_hour"] = score.false_per_gun_free_hour
        yield row
    for peer in study.peers:
        yield _shared("peer", peer, peer.f1_interval) | {"on_front": int(peer.name in study.on_front)}
    for point in study.rendering.points if study.rendering else ():
        row = {key: value for key, value in msgspec.structs.asdict(point).items() if key in _COLUMNS}
        row |= msgspec.structs.asdict(point.cost)
        yield {"kind": "rendering", "on_front": int(point.name in study.rendering_on_front)} | row


def _shared(kind: str, score: DetectionScore | PeerScore, sure: Interval) -> dict[str, object]:
    """Return the columns that settings and peers share."""
    f1 = {f"f1_{window}ms": value for window, value in score.f1_by_window_ms.items()}
    sureness = {"f1_10ms_low": sure.low, "f1_10ms_high": sure.high}
    shares = {"precision": score.precision, "recall": score.recall}
    return {"kind": kind, "name": score.name} | msgspec.structs.asdict(score.cost) | f1 | sureness | shares
