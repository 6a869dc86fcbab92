"""What a marker says: the event's name, how sure it is, its place in a burst, its level and its drive."""

import unicodedata
from fractions import Fraction

from ..model import Event
from ..timecode import FrameTime

_NOT_TEXT = frozenset({"Cc", "Cs", "Zl", "Zp"})


def one_line(text: str) -> str:
    """Return the text as one line without control characters: what every text format and XML can hold.

    >>> one_line("reel\\t1\\nnew \\x00cut")
    'reel 1 new cut'
    """
    kept = "".join(" " if unicodedata.category(letter) in _NOT_TEXT else letter for letter in text)
    return " ".join(kept.translate({0xFFFE: " ", 0xFFFF: " "}).split())


def label(event: Event) -> str:
    """Return an event in a few words: its id first, then confidence, burst and shot, peak, drive model and gain.

    The gain is read back from it, so it has all its digits.
    """
    burst = "" if event.burst is None else f" burst {event.burst}.{event.shot_in_burst}"
    model = f" {event.drive.model}" if event.drive else ""
    gain = f" {gain_text(event.gain_db)}" if event.gain_db else ""
    return f"{one_line(event.id)} {event.confidence:.2f}{burst} {event.peak_dbfs:z.1f} dBFS{model}{gain}"


def note(event: Event, offset_s: Fraction) -> str:
    """Return what a marker on a frame does not show: the words of `label` in full, and the sub-frame offset."""
    said = [f"confidence {event.confidence:.2f}"]
    if event.burst is not None:
        said.append(f"burst {event.burst} shot {event.shot_in_burst}")
    said.append(f"peak {event.peak_dbfs:z.1f} dBFS")
    if event.azimuth_deg is not None:
        said.append(f"azimuth {azimuth_text(event.azimuth_deg)}")
    if event.drive is not None:
        said.append(f"drive {event.drive.model}")
    if event.gain_db:
        said.append(gain_text(event.gain_db))
    said.append(f"sub-frame {offset_text(offset_s)}")
    return ", ".join(said)


def gain_text(gain_db: float) -> str:
    """Return how much stronger or softer than usual an event was asked to be, with all digits.

    >>> gain_text(-60.0), gain_text(2.25)
    ('gain -60 dB', 'gain +2.25 dB')
    """
    return f"gain {f'{gain_db:+}'.removesuffix('.0')} dB"


def azimuth_text(azimuth_deg: float) -> str:
    """Return a direction in whole degrees and in words that need no convention.

    >>> azimuth_text(-110.0), azimuth_text(0.2), azimuth_text(180.0)
    ('110 deg left', '0 deg', '180 deg')
    """
    whole = round(abs(azimuth_deg))
    side = "" if whole in (0, 180) else " left" if azimuth_deg < 0.0 else " right"
    return f"{whole} deg{side}"


def offset_text(offset_s: Fraction) -> str:
    """Return a sub-frame offset with its sign, in milliseconds.

    >>> offset_text(Fraction(1, 80)), offset_text(Fraction(-1, 48_000)), offset_text(Fraction(-1, 10**6))
    ('+12.50 ms', '-0.02 ms', '+0.00 ms')
    """
    return f"{float(1000 * offset_s):+z.2f} ms"


def framed_label(event: Event, at: FrameTime) -> str:
    """Return the event in a few words with its sub-frame offset, for formats whose markers hold one text."""
    return f"{label(event)} {offset_text(at.offset_s)}"
