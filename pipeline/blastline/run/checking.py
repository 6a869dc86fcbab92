"""Checking results again: files against their timeline, however they came to be what they are."""

import os
from collections.abc import Mapping
from contextlib import nullcontext
from glob import escape, glob
from pathlib import Path

import msgspec

from .. import __version__
from ..align import changed_shots, check_files, check_timeline
from ..errors import TimelineError
from ..export import read_timeline
from ..misfits import listed
from ..model import Source, Timeline
from ..progress import Note, Progress, no_note, no_progress, report_progress
from ..ruleset import ActuatorProfile, Rules, load_rules
from ..soundtrack import Soundtrack, open_soundtrack, written_cues
from ..streams import Streams
from . import names
from .belonging import profile_of, require_length, require_same_film, require_unchanged, tell_other_file
from .driving import open_drive
from .listening import BLOCK


def check(
    target: Path,
    *,
    audio: Path | None = None,
    drive: Path | None = None,
    actuator: str | None = None,
    stream: Streams | None = None,
    rules: Path | None = None,
    progress: Progress = no_progress,
    note: Note = no_note,
) -> Timeline:
    """Check files against a timeline, given as its file or its folder, and return it with the fresh checks.

    Without `audio` the film is looked for beside the results, without `drive` the drive; without `stream` its sound
    is the stream that the timeline was made from. A timeline without a drive is checked against the sound alone. `note`
    is told where it was made with other rules, for another actuator or from another file than `audio`, and which shots
    were rendered and are no more in it, or the other way round. Raises BlastlineError where a file that is needed is
    missing or unusable.
    """
    path = names.timeline_of(target)
    timeline = read_timeline(path)
    read = load_rules(timeline.quality, rules)
    _tell_other_rules(path, timeline, read, note)
    film = audio or _find_film(timeline.source, path)
    heard = timeline.source.stream if stream is None else stream
    has_drive = timeline.actuator is not None or drive is not None
    # before the film is decoded, which takes minutes, whatever can be told without it
    profile = profile_of(timeline, path, actuator=actuator, rules=rules, note=note) if has_drive else None
    drive = drive or path.parent / names.DRIVE
    markers = markers_of(drive) if has_drive else None
    _tell_changed_shots(path, timeline, markers, note)
    with (
        open_soundtrack(film, stream=heard, mix=timeline.source.mix) as track,
        open_drive(drive) if has_drive else nullcontext() as made,
    ):
        _require_sides(timeline, film, track)
        for _ in report_progress(track.blocks(BLOCK, sides=True), progress, track.expected_frames):
            pass
        _require_film(film, track.source(), path, timeline, named=audio is not None, note=note)
        if profile is None or made is None:
            found = msgspec.structs.replace(timeline, checks=check_timeline(timeline, audio=track, rules=read.align))
        else:
            found = checked(timeline, track, made, profile=profile, rules=read, progress=progress, markers=markers)
    require_unchanged(path, timeline)
    return found


def checked(
    timeline: Timeline,
    track: Soundtrack,
    drive: Soundtrack,
    *,
    profile: ActuatorProfile,
    rules: Rules,
    progress: Progress,
    markers: Mapping[str, int] | None = None,
) -> Timeline:
    """Return the timeline with the checks of the files: `track` has been decoded, `drive` has just been opened.

    `markers` are those of the shots that it was rendered with, by `markers_of`.
    """
    progress("checking", 0, None)
    checks = check_files(
        timeline,
        audio=track,
        drive=drive,
        profile=profile,
        rules=rules.align,
        lead_ms=rules.tier.render.lead_ms,
        preroll_ms=rules.tier.render.preroll_ms,
        corner_ms=1000.0 / min(rules.tier.render.solver_rate_hz, track.rate_hz),
        phase=timeline.phase,
        background=timeline.background,
        markers=markers,
    )
    return msgspec.structs.replace(timeline, checks=checks)


def _tell_other_rules(path: Path, timeline: Timeline, rules: Rules, note: Note) -> None:
    """Tell where a timeline of this version was made with other rules; another version's are not to be had."""
    if timeline.version == __version__ and timeline.rules_digest != rules.digest:
        note(
            f"{path}: was made with other rules (digest {timeline.rules_digest[:12]}) than it is checked by "
            f"({rules.digest[:12]}); give them with --rules"
        )


def markers_of(drive: Path) -> Mapping[str, int] | None:
    """Return the samples of the shots that a drive was rendered with, by their ids; None where it does not tell."""
    cues = written_cues(drive)
    return None if cues is None else {cue.label: cue.sample for cue in cues}


def _tell_changed_shots(path: Path, timeline: Timeline, markers: Mapping[str, int] | None, note: Note) -> None:
    """Tell which shots were rendered and have no drive in the timeline any more, and which have one there alone."""
    if timeline.actuator is None:
        return
    for what, shots, how in zip(("lacks", "has"), changed_shots(timeline, markers), ("", "not "), strict=True):
        if shots:
            note(
                f"{path}: {what} {listed(shots)}, which the drive was {how}rendered with; render it again "
                "with --timeline and --original: what else fails may come of that"
            )


def _require_film(film: Path, found: Source, path: Path, timeline: Timeline, *, named: bool, note: Note) -> None:
    """Raise TimelineError where a film is not as long as its timeline, or was found and is not the one it names.

    Of a film that the user `named`, `note` is told that it is another file.
    """
    cut = "the film of this timeline; `blastline conform` finds its shots in another cut"
    require_length(timeline, film, rate_hz=found.sample_rate_hz, frames=found.frames, what=cut)
    if named:
        tell_other_file(film, found, path, timeline.source, note)
    else:
        advice = "; give --audio to check against it all the same"
        require_same_film(film, found, path, timeline.source, advice=advice)


def _require_sides(timeline: Timeline, film: Path, track: Soundtrack) -> None:
    """Raise TimelineError where a drive was made of what only a film of two channels has, and this is none."""
    for event in timeline.events:
        if event.made_of != "mains" and not track.is_pair:
            raise TimelineError(
                f"{film}: has no two channels that play against each other, and the drive of {event.id} was made of "
                f"what they do (drive.made_of = {event.made_of!r}); expected a film with both"
            )


def _find_film(source: Source, timeline: Path) -> Path:
    """Return the film that a timeline names: beside it, one folder up, in the current folder, or in one beside its own.

    Folders beside it come last, and only one may hold a file of that name: which is meant, the name does not tell.
    """
    above = os.path.normpath(timeline.parent / "..")  # `Path.parent` knows no folder above the current one
    for folder in (timeline.parent, Path(above), Path()):
        if (folder / source.name).is_file():
            return folder / source.name
    beside = sorted(filter(os.path.isfile, glob(os.path.join(escape(above), "*", escape(source.name)))))
    if len(beside) > 1:
        raise TimelineError(
            f"{timeline}: source.name = {source.name!r}: may be any of {listed(beside)}; expected one of them, named "
            "with --audio"
        )
    if beside:
        return Path(beside[0])
    raise TimelineError(
        f"{timeline}: source.name = {source.name!r}: not in its folder, the one above, one beside it or the current "
        "one; expected the film there, or named with --audio"
    )
