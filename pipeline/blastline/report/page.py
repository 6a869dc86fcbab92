"""The page, put together."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from ..model import Check, Event, MadeOf, RandomAccessSound, Timeline
from ..plurals import counted
from ..ruleset import ActuatorProfile
from .choice import MAX_FIGURES, failures, pictured, reasons, rule
from .drawing import ready_to_draw
from .exports import ExportRow, exports_table
from .figures import ShotPictures
from .overview import Overview
from .script import FILTER, SCRIPT
from .sounds import EventSound, event_sound
from .style import STYLE
from .summary import heading, tiles, verdict, warnings
from .tables import checks_tables, origin_list, rejections_table, shots_table
from .track import film_track
from .words import by_hand, claim, figure, fixed, is_decided, measured, safe, signed

_SECTIONS: Final = {
    "film": "The film",
    "pictures": "Shots in pictures",
    "shots-all": "Every shot",
    "checks": "Checks",
    "files": "Files for other tools",
    "rejected": "Not taken for shots",
    "origin": "How this was made",
}
"""The page's sections in order: their anchors and their titles."""

_MADE_OF: Final[dict[MadeOf, str]] = {
    "sides": "what the two channels play against each other",
    "left": "the left channel, since the two cancel",
    "right": "the right channel, since the two cancel",
}


def write_report(
    path: Path,
    timeline: Timeline,
    *,
    overview: Overview,
    audio: RandomAccessSound,
    drive: RandomAccessSound,
    profile: ActuatorProfile,
    exports: Sequence[ExportRow],
    options: Mapping[str, str],
) -> None:
    """Write the report of a finished run as one HTML page.

    `audio` and `drive` both have the timeline's number of frames and are read for the pictures. `options` are shown as
    they are, under how the result was made; `exports` are the files that other tools open.
    """
    why = pictured(timeline.events, timeline.checks)
    shown = [event for event in timeline.events if event.id in why]
    sounds = (event_sound(event, timeline, audio=audio, drive=drive, profile=profile) for event in shown)
    pictures = _drawn(sounds, why, timeline, path.parent)
    with path.open("w", encoding="utf-8") as file:  # part by part: the whole would be in memory several times
        file.writelines(_page(timeline, overview, why, pictures, exports, options))


def _page(
    timeline: Timeline,
    overview: Overview,
    why: Mapping[str, str],
    pictures: Iterable[str],
    exports: Sequence[ExportRow],
    options: Mapping[str, str],
) -> Iterator[str]:
    """Yield the page part by part."""
    failed = failures(timeline.checks)
    rejected = rejections_table(timeline.rejections, timeline.source)
    title = f"{timeline.source.name} – blastline report"
    yield (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{safe(title)}</title><style>{STYLE}</style></head><body>\n"
        f"<header>{heading(timeline)}{verdict(timeline)}{warnings(timeline)}{tiles(timeline)}{_contents(exports)}</header>\n<main>\n"
        f"{_section('film', _film(timeline, overview, failed, why))}"
        f'<section id="pictures"><h2>{_SECTIONS["pictures"]}</h2>'
    )
    yield from _pictures(timeline, pictures)
    yield (
        f"</section>\n{_section('shots-all', _shots(timeline, failed, why))}"
        f"{_section('checks', checks_tables(timeline.checks, linked=why))}"
        f"{_section('files', exports_table(exports)) if exports else ''}"
        f"{_section('rejected', rejected)}"
        f"{_section('origin', origin_list(timeline, options))}"
        f"</main>\n<footer>Made by blastline {safe(timeline.version)}. What is felt is predicted from the "
        f"actuator's profile, not measured on a seat.</footer>\n<script>{SCRIPT}</script></body></html>\n"
    )


def _contents(exports: Sequence[ExportRow]) -> str:
    links = (f"<a href=#{name}>{title}</a>" for name, title in _SECTIONS.items() if exports or name != "files")
    return f'<nav aria-label="On this page">{"".join(links)}</nav>'


def _section(name: str, content: str) -> str:
    return f'<section id="{name}"><h2>{_SECTIONS[name]}</h2>{content}</section>\n'


def _shots(timeline: Timeline, failed: Mapping[str, int], why: Mapping[str, str]) -> str:
    if not timeline.events:
        return "<p>No shots were found.</p>"
    return f'{FILTER}<div class="card">{shots_table(timeline.events, failed=failed, linked=why)}</div>'


def _film(timeline: Timeline, overview: Overview, failed: Mapping[str, int], why: Mapping[str, str]) -> str:
    legend = _legend(
        ("audio", "area", "level of the film"),
        ("felt", "", "shot: its height is its level, full where detection is sure"),
        ("limit", "", "a check failed (cross)"),
        ("drive", "", "burst (bracket)"),
    )
    track = film_track(timeline, overview, failed=failed, linked=why)
    return f'<div class="card">{legend}<div class="scroll">{track}</div></div>'


def _legend(*entries: tuple[str, str, str]) -> str:
    items = "".join(
        f'<li><i class="{kind}" style="{"background" if kind else "border-color"}:var(--{colour})"></i>{text}</li>'
        for colour, kind, text in entries
    )
    return f'<ul class="legend">{items}</ul>'


def _pictures(timeline: Timeline, pictures: Iterable[str]) -> Iterator[str]:
    if not timeline.events:
        yield "<p>There is nothing to show: no shots were found in this film.</p>"
        return
    legend = _legend(
        ("audio", "", "sound"),
        ("band", "", "sound in the band of vibration: what should be felt"),
        ("direct", "", "felt by direct conversion"),
        ("drive", "", "drive"),
        ("felt", "", "felt with the drive"),
        ("limit", "", "actuator's limit"),
        ("blast", "area", "blast"),
        ("reflection", "area", "reflection"),
        ("window", "area", "window and its fades"),
    )
    note = rule() if len(timeline.events) > MAX_FIGURES else "Every shot is shown."
    yield f'<p class="note">{note}</p>{legend}'
    yield from pictures


def _drawn(sounds: Iterable[EventSound], why: Mapping[str, str], timeline: Timeline, folder: Path) -> Iterator[str]:
    """Yield the pictures; a page without any needs nothing that draws."""
    ready_to_draw(folder)
    draw = ShotPictures()
    for sound in sounds:
        yield _picture(sound.event, why[sound.event.id], timeline, draw.drawn(sound))


def _picture(event: Event, why: str, timeline: Timeline, drawn: str) -> str:
    own = [check for check in timeline.checks if check.event == event.id]
    return (
        f'<article class="card picture" id="shot-{safe(event.id)}">'
        f"<h3>{safe(event.id)} <span>{safe(event.timecode)}{f' · {why}' if why else ''}</span>{_badge(own)}</h3>"
        f"{_numbers(event, timeline.source.sample_rate_hz)}{_failures(own)}{reasons(event)}"
        f'<div class="scroll">{drawn}</div>'
        f"{_own_checks(own)}</article>\n"
    )


def _badge(checks: Sequence[Check]) -> str:
    failed = sum(not check.passed for check in checks)
    if not checks:
        return ""
    decided = sum(map(is_decided, checks))
    failing, passing = f"{failed} of {counted(decided, 'check')} failed", f"{counted(decided, 'check')} passed"
    kind, text = ("bad", failing) if failed else ("good", passing)
    return f'<span class="badge {kind}">{text}</span>'


def _failures(checks: Sequence[Check]) -> str:
    lines = "".join(f"<li>{safe(claim(c))}: <em>no</em>, {safe(measured(c))}</li>" for c in checks if not c.passed)
    return f'<ul class="failed">{lines}</ul>' if lines else ""


def _own_checks(checks: Sequence[Check]) -> str:
    passed = "".join(f"<li>{safe(claim(c))}: {safe(measured(c))}</li>" for c in checks if c.passed)
    return f"<details><summary>Checks that passed</summary><ul>{passed}</ul></details>" if passed else ""


def _numbers(event: Event, rate_hz: int) -> str:
    facts = {
        "Onset": f"{event.onset_s:.4f} s",
        "Sample": f"{event.onset_sample}",
        "Confidence": fixed(event.confidence, 2),
        "Peak": f"{fixed(event.peak_dbfs, 1)} dBFS",
        "Over background": f"{fixed(event.snr_db, 1)} dB",
        **_direction(event),
        "Blast": f"{figure(1000.0 * len(event.blast) / rate_hz, 1)} ms",
        "Reflections": _echoes(event),
    }
    if event.burst is not None:
        facts["Burst"] = f"{event.burst}, shot {event.shot_in_burst}"
    if set_by_hand := by_hand(event):
        facts["By hand"] = set_by_hand
    if event.drive is not None:
        facts["Felt against direct"] = f"{signed(event.drive.perceived_gain_db)} dB"
        facts["Fidelity"] = fixed(event.drive.fidelity, 3)
        if event.drive.made_of != "mains":
            facts["Drive made of"] = _MADE_OF[event.drive.made_of]
        if event.drive.explained is not None:
            facts["Energy felt as heard"] = f"{figure(100.0 * event.drive.explained, 1)} %"
        facts["Peak of the drive"] = f"{figure(event.drive.peak, 3)} of the limit"
    items = "".join(f"<div><dt>{name}</dt><dd>{safe(value)}</dd></div>" for name, value in facts.items())
    return f'<dl class="numbers">{items}</dl>'


def _direction(event: Event) -> dict[str, str]:
    """Return from where a shot comes and where it was heard, as far as that is worth a word."""
    facts = {}
    if event.azimuth_deg is not None and event.azimuth_focus is not None:
        facts["Azimuth"] = f"{fixed(event.azimuth_deg, 0)}°, focus {fixed(event.azimuth_focus, 2)}"
    if event.heard_in == "sides":
        facts["Heard in"] = "the sides: what the channels play beside their middle"
    return facts


def _echoes(event: Event) -> str:
    shown = [f"{figure(echo.delay_ms, 1)} ms at {figure(echo.level_db, 0)} dB" for echo in event.reflections[:3]]
    more = f" and {len(event.reflections) - 3} more" if len(event.reflections) > 3 else ""
    return "; ".join(shown) + more if shown else "none"
