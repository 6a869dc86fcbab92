"""What was chosen, and why: which shots get a picture, and how closely each was looked at and rendered.

Pictures are for where something failed, what was set by hand, where detection was least sure, and the strongest.
"""

from collections.abc import Sequence

from ..model import Check, Event
from .words import by_hand, safe, typeset

MAX_FIGURES = 24
_FAILED_SHARE, _BY_HAND_SHARE, _UNSURE_SHARE = 12, 4, 6


def pictured(events: Sequence[Event], checks: Sequence[Check]) -> dict[str, str]:
    """Return why each chosen shot is shown, by its id, in the order of the film; all of them where they are few."""
    if len(events) <= MAX_FIGURES:
        return {event.id: "" for event in events}
    failed = failures(checks)
    worst = sorted((e for e in events if failed.get(e.id)), key=lambda e: (-failed[e.id], e.onset_sample))
    edited = sorted((e for e in events if by_hand(e)), key=lambda e: e.onset_sample)
    unsure = sorted(events, key=lambda e: (e.confidence, e.onset_sample))
    loud = sorted(events, key=lambda e: (-e.peak_dbfs, e.onset_sample))
    why: dict[str, str] = {event.id: "a check failed" for event in worst[:_FAILED_SHARE]}
    _add(why, edited, "set by hand", len(why) + _BY_HAND_SHARE)
    _add(why, unsure, "among the least sure", len(why) + _UNSURE_SHARE)
    _add(why, loud, "among the strongest", MAX_FIGURES)
    return {event.id: why[event.id] for event in events if event.id in why}


def rule() -> str:
    """Return the rule in words."""
    return (
        f"A film with many shots shows {MAX_FIGURES} of them: up to {_FAILED_SHARE} in which a check failed, "
        f"up to {_BY_HAND_SHARE} that were set by hand, the {_UNSURE_SHARE} of which detection was least sure, and the "
        "strongest."
    )


def reasons(event: Event) -> str:
    """Return what was chosen for a shot and why, a line for each choice."""
    lines = [(each.about.capitalize(), each.choice, each.reason) for each in event.decisions]
    if event.drive is not None:
        lines.append(("Drive", event.drive.model, event.drive.reason))
    return "".join(f'<p class="why">{name}: {safe(typeset(f"{said}, {why}"))}.</p>' for name, said, why in lines)


def failures(checks: Sequence[Check]) -> dict[str, int]:
    """Return the number of failed checks of each shot that has any, by its id."""
    failed: dict[str, int] = {}
    for check in checks:
        if check.event is not None and not check.passed:
            failed[check.event] = failed.get(check.event, 0) + 1
    return failed


def _add(why: dict[str, str], ranked: Sequence[Event], reason: str, most: int) -> None:
    for event in ranked:
        if len(why) >= most:
            return
        why.setdefault(event.id, reason)
