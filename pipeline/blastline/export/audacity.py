"""Label tracks: a text line per event, to see and hear the events over the film's sound."""

from pathlib import Path

from ..model import Timeline
from .words import label


def write_labels(timeline: Timeline, path: Path) -> None:
    """Write `start<TAB>end<TAB>label` per event, from its onset to the end of its window, in seconds.

    Nine decimals place a label to the sample at every rate; the decimal sign is a dot in any language.
    """
    rate_hz = timeline.source.sample_rate_hz
    lines = []
    for event in timeline.events:
        end_s = max(event.onset_sample, event.window.stop) / rate_hz
        lines.append(f"{event.onset_sample / rate_hz:.9f}\t{end_s:.9f}\t{label(event)}\n")
    path.write_text("".join(lines), encoding="utf-8", newline="\n")
