"""`timeline.schema.json`: what `timeline.json` may hold, for programs that check or generate code from it."""

import json
from pathlib import Path

from ..model import Timeline, schema


def write_schema(timeline: Timeline, path: Path) -> None:
    """Write the JSON Schema that this version's timelines follow, whatever the timeline."""
    path.write_text(json.dumps(schema(), indent=1) + "\n", encoding="utf-8", newline="\n")
