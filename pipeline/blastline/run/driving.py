"""The drive's file: every window rendered from the film and written as it comes."""

from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import msgspec

from .. import scene
from ..errors import SoundtrackError
from ..model import Clip, DriveInfo, Span
from ..render import (
    RenderedWindow,
    choose_made_of,
    compose,
    drive_filters,
    hear_window,
    measure,
    needed_audio,
    render_window,
)
from ..soundtrack import Cue, Soundtrack, open_soundtrack, write_drive
from .listening import BLOCK, HeardFilm
from .options import Setup


def write_drive_of(heard: HeardFilm, path: Path, setup: Setup) -> dict[int, DriveInfo]:
    """Render every window into the drive's file and return what was done for each shot, by its index."""
    drives: dict[int, DriveInfo] = {}  # filled as the windows pass by on their way into the file

    def noted() -> Iterator[RenderedWindow]:
        for number, done in enumerate(_render_windows(heard, setup), start=1):
            drives.update(zip(done.planned.shots, done.drives, strict=True))
            yield done
            setup.progress("rendering", number, len(heard.windows))

    source = heard.source
    film = _read_again(heard.track, source.frames) if setup.options.background == "direct" else ()
    write_drive(
        path,
        compose(film, noted(), setup.options.background),
        rate_hz=source.sample_rate_hz,
        frames=source.frames,
        time_reference=heard.track.time_reference,
        cues=_cues(heard),
        description=f"vibration drive for {setup.profile.name}",
    )
    return drives


def _cues(heard: HeardFilm) -> list[Cue]:
    """Return a marker for each shot, to the end of its window or to the next shot, as in all formats."""
    stops = {index: planned.window.stop for planned in heard.windows for index in planned.shots}
    onsets = [shot.onset for shot in heard.found.shots]
    nexts = (*onsets[1:], heard.source.frames)
    return [
        Cue(onset, mark.id, max(0, min(stops[index], nexts[index]) - onset))
        for index, (onset, mark) in enumerate(zip(onsets, heard.marks, strict=True))
    ]


def open_drive(path: Path) -> Soundtrack:
    """Open a drive as a seat plays it: one channel, as it is.

    Raises SoundtrackError for a file that cannot be read, or has more channels: which of them the seat gets is unknown.
    """
    drive = open_soundtrack(path, mix="0")
    if drive.channels > 1:
        drive.close()
        raise SoundtrackError(f"{path}: has {drive.channels} channels; expected a drive of 1: export it as mono")
    return drive


def _render_windows(heard: HeardFilm, setup: Setup) -> Iterator[RenderedWindow]:
    options, render_rules = setup.options, setup.rules.tier.render
    filters = drive_filters(setup.profile, heard.source.sample_rate_hz, options.phase)
    for planned in heard.windows:
        needed = needed_audio(planned, frames=heard.source.frames, filters=filters, rules=render_rules)
        audio = heard.track.read(needed, sides=heard.track.is_pair)
        made_of = choose_made_of(audio, [heard.found.shots[index].onset for index in planned.shots])
        window = hear_window(audio, planned, filters=filters, rules=render_rules, made_of=made_of)
        evidence = measure(window)
        model, reason = scene.choose(evidence, setup.rules.scenes, options.drive)
        done = render_window(window, heard.found.shots, model=model, reason=reason, background=options.background)
        yield replace(
            done, drives=tuple(msgspec.structs.replace(info, evidence=asdict(evidence)) for info in done.drives)
        )


def _read_again(track: Soundtrack, frames: int) -> Iterator[Clip]:
    """Read the film once more, exactly."""
    for start in range(0, frames, BLOCK):
        yield track.read(Span(start, min(start + BLOCK, frames)))
