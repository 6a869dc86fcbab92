"""Whether a file belongs to a timeline, and the actuator that its drive was made for."""

from contextlib import suppress
from pathlib import Path

from ..errors import TimelineError
from ..export import read_timeline
from ..model import Source, Timeline
from ..progress import Note
from ..ruleset import ActuatorProfile, actuator_names, load_actuator


def film_of(timeline: Path) -> str | None:
    """Return the digest of the film that a timeline's file names; None where there is none that can be read."""
    with suppress(TimelineError):
        return read_timeline(timeline).source.sha256
    return None


def require_same_film(film: Path, found: Source, timeline: Path, expected: Source, *, advice: str = "") -> None:
    """Raise TimelineError where a film is not, to the last byte, the one of a timeline; `advice` ends the message."""
    for what, here, there in (
        ("sample rate", f"{found.sample_rate_hz} Hz", f"{expected.sample_rate_hz} Hz"),
        ("length", f"{found.frames} frames", f"{expected.frames} frames"),
        ("sha256", found.sha256[:12], expected.sha256[:12]),
    ):
        if here != there:
            made = f"is not the film that {timeline} was made from"
            raise TimelineError(f"{film}: {made}: its {what} is {here}, expected {there} ({expected.name}){advice}")


def tell_other_file(film: Path, found: Source, timeline: Path, expected: Source, note: Note) -> None:
    """Tell where a film of the right length is not the file of a timeline: a copy of its sound may well be another."""
    if expected.sha256 and found.sha256 != expected.sha256:
        note(
            f"{film}: is not the file that {timeline} was made from: its sha256 is {found.sha256[:12]}, expected "
            f"{expected.sha256[:12]} ({expected.name}); if its sound is another, what fails is not the drive's fault"
        )


def require_unchanged(path: Path, timeline: Timeline) -> None:
    """Raise TimelineError where a file no longer holds the timeline that was read from it.

    Another run has put its results there since: what was read beside it may be of either.
    """
    if read_timeline(path) != timeline:
        raise TimelineError(
            f"{path}: was changed while it was read; expected the results of one run, and that finished"
        )


def require_length(timeline: Timeline, name: Path, *, rate_hz: int, frames: int, what: str) -> None:
    """Raise TimelineError where a file has another rate or length than its timeline; `what` it should be is told."""
    for key, found, expected in (
        ("samples a second", rate_hz, timeline.source.sample_rate_hz),
        ("samples", frames, timeline.source.frames),
    ):
        if found != expected:
            raise TimelineError(f"{name}: has {found} {key}, the timeline {expected}: not {what}")


def profile_of(
    timeline: Timeline, path: Path, *, actuator: str | None, rules: Path | None, note: Note
) -> ActuatorProfile:
    """Return the profile of an actuator, by default of the one that the timeline in the file `path` names.

    `note` is told where the actuator given is not the one that the timeline's drive was made for.
    Raises TimelineError where that is the user's own, or is not what it was when the drive was made; RuleError where
    the actuator given does not exist or fit.
    """
    if actuator is None:
        if timeline.actuator is None:
            raise TimelineError(f"{path}: names no actuator; give the one that the drive was made for with --actuator")
        actuator = timeline.actuator.name
        if actuator not in actuator_names(rules):
            raise TimelineError(
                f"{path}: was made for {actuator}, which is not built in; give its file with --actuator"
            )
        profile, digest = load_actuator(actuator, rules)
        if digest != timeline.actuator.digest:
            raise TimelineError(
                f"{path}: was made for a profile named {actuator} (digest {timeline.actuator.digest[:12]}) that is "
                f"not the one of that name here ({digest[:12]}); give its file with --actuator"
            )
        return profile
    profile, digest = load_actuator(actuator, rules)
    made_for = timeline.actuator
    if made_for is not None and digest != made_for.digest:
        note(
            f"{path}: its drive was made for {made_for.name} (digest {made_for.digest[:12]}); --actuator gives another "
            f"profile, {profile.name} (digest {digest[:12]}), which is used all the same"
        )
    return profile
