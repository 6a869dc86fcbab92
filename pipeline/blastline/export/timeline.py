"""`timeline.json`: the whole timeline, for blastline itself and for scripts."""

from pathlib import Path

from ..model import Timeline, encode


def write_json(timeline: Timeline, path: Path) -> None:
    """Write everything that is known; `read_timeline` returns an equal timeline."""
    path.write_bytes(encode(timeline))
