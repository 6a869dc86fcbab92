"""What a file is that somebody took for a timeline: called by its name, it is sooner swapped for the right one."""

import re
from collections.abc import Sequence
from typing import Any

_LONGEST_HEAD = 4096

_MAGIC = (
    (re.compile(rb"(RIFF|RF64|RIFX)....WAVE", re.DOTALL), "a WAV file"),
    (re.compile(rb"fLaC|OggS|ID3[\x02-\x04]"), "a sound file"),
    (re.compile(rb"MThd"), "a MIDI file"),
    (re.compile(rb"....ftyp|....moov", re.DOTALL), "an MP4 or QuickTime film"),
    (re.compile(rb"\x1a\x45\xdf\xa3"), "a Matroska film"),
    (re.compile(rb"\x06\x0e\x2b\x34"), "an MXF film"),
    (re.compile(rb"\xd0\xcf\x11\xe0"), "an AAF file or an old Office document"),
    (re.compile(rb"PK\x03\x04"), "a workbook or another zip file"),
    (re.compile(rb"\x1f\x8b"), "a project or another gzip file"),
    (re.compile(rb"%PDF"), "a PDF"),
)
_TEXTS = (
    (re.compile(r"TITLE:|FCM:|\d{3,6} +\S+ +(A|V|B|AA|NONE)\S* +C "), "an EDL"),
    (re.compile(r"<REAPER_PROJECT\b"), "a REAPER project"),
    (re.compile(r"<(?:[^<]|<[?!])*?<fcpxml\b|<fcpxml\b"), "FCPXML"),
    (re.compile(r"<(?:[^<]|<[?!])*?<xmeml\b|<xmeml\b"), "Final Cut Pro 7 XML"),
    (re.compile(r"<!doctype html|<html\b", re.IGNORECASE), "a web page"),
    (re.compile(r"<"), "XML"),
    (re.compile(r"WEBVTT\b|\d+\s*\n\d\d:\d\d:\d\d,\d{3} -->"), "subtitles"),
    (re.compile(r"SESSION NAME:"), "a Pro Tools session as text"),
    (re.compile(r"[^\t\n]*\t\d\d:\d\d:\d\d[:;]\d\d\t"), "Avid's markers"),
)
"""How texts of other tools begin. Their times are whole frames or milliseconds, too coarse to be read for onsets."""

_LABELS = re.compile(r"-?\d+[.,]\d+\t-?\d+[.,]\d+")
_TABLES = (
    (re.compile(r'"?#"?[,;\t]'), "REAPER's markers and regions"),
    (re.compile(r"(?![{\[])[^\n]*\bonset_s(ample)?\b"), "a table of shots"),
    (_LABELS, "an Audacity label track"),
)
"""What only `render` reads, of an edited timeline."""

_JSON = (
    ({"OTIO_SCHEMA"}, "OpenTimelineIO"),
    ({"Pattern", "Version"}, "a Core Haptics pattern"),
    ({"perceptions"}, "an MPEG haptic file"),
    ({"signals", "version"}, "a Meta haptic clip"),
    ({"$schema"}, "a JSON Schema"),
)
_TRUTH = "blastline.truth/"


def kind_of_content(content: bytes) -> str | None:
    """Return what a file that is no text is, by how it begins; None where that is not known."""
    return next((what for magic, what in _MAGIC if magic.match(content)), None)


def kind_of_text(text: str) -> str | None:
    """Return what a text is that another tool has written and that is never read back; None where that is not known."""
    return _begun_as(text, _TEXTS)


def kind_of_table(text: str) -> str | None:
    """Return what a text is that `render --timeline` reads and nothing else does."""
    return _begun_as(text, _TABLES)


def _begun_as(text: str, kinds: Sequence[tuple[re.Pattern[str], str]]) -> str | None:
    head = text.lstrip()[:_LONGEST_HEAD]
    return next((what for beginning, what in kinds if beginning.match(head)), None)


def begins_as_labels(text: str) -> bool:
    """Return whether a text begins as an Audacity label track does: with two times, parted by a tab."""
    return _LABELS.match(text.lstrip()) is not None


def kind_of_json(plain: Any) -> str | None:
    """Return what JSON holds that is no timeline; None where that is not known."""
    if not isinstance(plain, dict):
        return None
    if str(plain.get("schema", "")).startswith(_TRUTH):
        return "the truth about a scene's shots"
    return next((what for keys, what in _JSON if keys <= plain.keys()), None)
