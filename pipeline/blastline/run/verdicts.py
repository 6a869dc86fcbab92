"""What the checks came to, line by line, in the words of the report."""

from collections.abc import Iterator, Mapping, Sequence

from ..model import Check, Timeline
from ..plurals import counted
from ..report import allowed, by_name, claim, is_decided, measured
from ..units import db_from_gain

MOST_TOLD = 10
"""So many failures of one kind are told one by one: the wrong drive fails for every shot of a film."""


_FAINT = 0.1  # of the limit: 20 dB beneath the strongest that the seat can do


def told_failures(timeline: Timeline) -> Iterator[str]:
    """Yield a line for each check that failed: what it claims, the shot and its timecode, the figure, what is allowed.

    Of a kind that fails for more than `MOST_TOLD` shots the rest are a number, in one more line. Signs are hyphens,
    which every terminal's alphabet has.
    """
    timecodes = {event.id: event.timecode for event in timeline.events}
    for checks in by_name(check for check in timeline.checks if not check.passed):
        for check in checks[:MOST_TOLD]:
            yield _told(check, timecodes).replace("\N{MINUS SIGN}", "-")
        if len(checks) > MOST_TOLD:
            more = len(checks) - MOST_TOLD
            yield f"{claim(checks[0])}: not in {counted(more, 'more shot')} either"


def _told(check: Check, timecodes: Mapping[str, str]) -> str:
    """Return what failed, in a line."""
    where = ""
    if check.event is not None:
        at = f" at {timecodes[check.event]}" if check.event in timecodes else ""
        where = f"not in {check.event}{at}, "
    limit = f" ({allowed(check)})" if check.limit is not None else ""
    return f"{claim(check)}: {where}{measured(check)}{limit}"


def told_faintness(timeline: Timeline) -> Iterator[str]:
    """Yield a line where even the strongest drive will hardly be felt; no check fails there."""
    strongest = max((event.drive.peak for event in timeline.events if event.drive is not None), default=0.0)
    if 0.0 < strongest < _FAINT:
        at_db = f"{strongest:.2g} of the actuator's limit ({db_from_gain(strongest):.0f} dB)"
        yield f"the strongest drive peaks at {at_db}: --level raises it"


def told_passes(timeline: Timeline) -> Iterator[str]:
    """Yield a line for each kind of check that was held and not failed, with how many shots it was held against."""
    for checks in by_name(timeline.checks):
        if _held(checks) and all(check.passed for check in checks):
            yield f"{claim(checks[0])}{_extent(checks)}"


def told_unmeasured(timeline: Timeline) -> Iterator[str]:
    """Yield a line for each kind of check that could be held against nothing."""
    for checks in by_name(timeline.checks):
        if not _held(checks) and all(check.passed for check in checks):
            yield claim(checks[0])


def told_count(timeline: Timeline) -> str:
    """Return how many of the checks that decide anything passed, and how many could be held against nothing."""
    decided = [check for check in timeline.checks if is_decided(check)]
    undecided = len(timeline.checks) - len(decided)
    more = f"; {undecided} could not be held to a limit" if undecided else ""
    return f"{sum(check.passed for check in decided)} of {len(decided)} passed{more}"


def _held(checks: Sequence[Check]) -> int:
    """Return how many checks that passed were held against a limit."""
    return sum(check.passed and is_decided(check) for check in checks)


def _extent(checks: Sequence[Check]) -> str:
    """Return how many shots checks of one kind were held against."""
    if checks[0].event is None:
        return ""
    held = _held(checks)
    spared = f"; {len(checks) - held} could not be held to it" if held < len(checks) else ""
    return f" ({counted(held, 'shot')}{spared})"
