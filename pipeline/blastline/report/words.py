"""How figures are said to people: checks by name, numbers with their units, text that is safe in a page."""

import html
import math
import re
from collections.abc import Iterable
from fractions import Fraction
from urllib.parse import quote

from ..model import Check, Event
from ..timecode import clock_text
from ..units import SILENCE_DB

CHECKS = {
    "sample_rate": "The drive has the film's sample rate",
    "frames": "The drive is as long as the film",
    "drive_samples": "Every sample of the drive is a number",
    "drive_peak": "The drive keeps to the actuator's limit",
    "silence_outside_windows": "Nothing moves between the shots",
    "sound_outside_windows": "Between the shots the drive is the film's sound",
    "fades": "The drive comes and goes as its windows fade",
    "timeline_order": "Shots and windows are in order",
    "shots_as_rendered": "The shots are those that were rendered",
    "drive_shift": "The drive as a whole is not displaced",
    "drive_drift": "The drive does not drift from first shot to last",
    "drive_speed": "The drive runs at the film's speed",
    "fade_in_before_onset": "The window is open before the bang",
    "felt_lag": "The vibration is felt with the bang",
    "felt_correlation": "The vibration follows the sound",
    "felt_onset": "The felt attack begins with the heard one",
    "drive_lag": "The drive comes with the bang",
    "drive_correlation": "The drive follows the sound",
    "drive_onset": "The drive's attack begins with the heard one",
    "lag_as_rendered": "The lag is the one that was rendered",
    "level_as_rendered": "The level is the one that was rendered",
    "peak_as_rendered": "The peak is the one that was rendered",
    "gain_as_rendered": "The gain is the one that was rendered",
    "onset_as_rendered": "The onset is the one that was rendered",
    "drive_as_rendered": "The drive is the one that was rendered, to the window's end",
    "drive_above_band": "The drive does nothing above the band that is not asked for",
    "pre_echo": "Nothing is felt before the bang",
    "peak": "The shot's drive keeps to the limit",
    "audio_rise": "The sound rises at the onset",
}
"""What each check claims; a check without an entry is called by its name."""

_OUTSIDE = {"silence_outside_windows", "sound_outside_windows"}
_EXACT = {"sample_rate", "frames", "drive_samples", "fades", "timeline_order", "onset_as_rendered"} | _OUTSIDE
_AT_LEAST = {"felt_correlation", "drive_correlation", "fade_in_before_onset", "audio_rise"}
_AS_RENDERED = {"lag_as_rendered", "level_as_rendered", "peak_as_rendered", "gain_as_rendered"}
_EITHER_WAY = {"drive_shift", "drive_drift", "felt_lag", "drive_lag"} | _AS_RENDERED
_ONSETS = {"felt_onset", "drive_onset"}
_COUNTED = {"frames": "the film", "shots_as_rendered": "were rendered"}
"""What the figures of these count more or fewer than."""

_MOST_DECIMALS = 16
_SPEED_DIGITS = 7


def claim(check: Check) -> str:
    """Return what a check claims, in words."""
    return CHECKS.get(check.name, check.name.replace("_", " "))


def by_name(checks: Iterable[Check]) -> list[list[Check]]:
    """Return the checks of each name together, in the order in which the names come."""
    kinds: dict[str, list[Check]] = {}
    for check in checks:
        kinds.setdefault(check.name, []).append(check)
    return list(kinds.values())


def safe(text: object) -> str:
    """Return text as it may stand in a page, in an element or in a quoted attribute."""
    return html.escape(str(text), quote=True)


def link(anchor: str) -> str:
    """Return the address of an element of this page; a browser reads `%41` in one as the letter A.

    >>> link("shot-take 2 %41")
    '#shot-take%202%20%2541'
    """
    return f"#{quote(anchor, safe='')}"


def figure(value: float | None, digits: int = 2) -> str:
    """Return a number for people, with a true minus sign; a dash where there is none.

    >>> figure(-0.126), figure(3.0), figure(None)
    ('−0.13', '3', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    rounded = f"{value:z.{digits}f}"
    if "." in rounded:
        rounded = rounded.rstrip("0").rstrip(".")
    return rounded.replace("-", "−")


def fixed(value: float, digits: int) -> str:
    """Return a number with so many decimals, as in a column of a table.

    >>> fixed(-0.25, 1), fixed(1.0, 3), fixed(-0.04, 1)
    ('−0.2', '1.000', '0.0')
    """
    return f"{value:z.{digits}f}".replace("-", "−")


def signed(value: float | None, digits: int = 1) -> str:
    """Return a number with its sign, as for levels.

    >>> signed(6.02), signed(-3.0)
    ('+6', '−3')
    """
    text = figure(value, digits)
    return f"+{text}" if value is not None and math.isfinite(value) and value > 0.0 and text != "0" else text


def typeset(text: str) -> str:
    """Return a sentence with true minus signs before its numbers; hyphens of names and ranges stay.

    >>> typeset("shot-0001 is felt -9.4 dB against it, after 3-4 ms")
    'shot-0001 is felt −9.4 dB against it, after 3-4 ms'
    """
    return re.sub(r"(?<![\w.)-])-(?=\d)", "−", text)


def by_hand(event: Event) -> str:
    """Return what somebody has set of a shot, in words; nothing where nobody has."""
    said: list[str] = [event.origin] if event.origin != "found" else []
    if event.gain_db:
        said.append(f"gain {signed(event.gain_db, 2)} dB")
    return ", ".join(said)


def is_decided(check: Check) -> bool:
    """Return whether a check failed, or was held to a limit; one without a figure or a limit says nothing."""
    return not check.passed or (check.measured is not None and check.limit is not None)


def measured(check: Check) -> str:
    """Return what a check measured, with its unit."""
    if check.measured is None:
        return "could not be measured" if not check.passed else "nothing to measure"
    if beside := _COUNTED.get(check.name):
        more = "more" if check.measured >= 0.0 else "fewer"
        return f"{figure(abs(check.measured), 0)} {more} than {beside}" if check.measured else f"as many as {beside}"
    if check.unit.startswith("dB") and check.measured <= SILENCE_DB:
        return "nothing at all"
    return _with_unit(check.measured, check)


def allowed(check: Check) -> str:
    """Return what a check allows, with its unit."""
    if check.limit is None:
        return "–"
    if check.name in _COUNTED:
        return "exactly as many"
    limit = _with_unit(check.limit, check)
    if check.name in _EXACT:
        return f"exactly {limit}"
    if check.name == "drive_speed":
        return f"from {figure(2.0 - check.limit, _digits(check))} to {limit}"
    if check.name in _EITHER_WAY:
        return f"up to {limit} either way"
    if check.name in _ONSETS:
        return f"up to {limit} late, up to that and the lead of the drive early"
    return f"at least {limit}" if check.name in _AT_LEAST else f"up to {limit}"


def _digits(check: Check) -> int:
    """Return how many decimals a check has: where it failed, as many as tell what was measured from what is allowed."""
    usual = _speed_digits(check.limit) if check.name == "drive_speed" else 2 if check.unit.startswith("dB") else 3
    value, limit = check.measured, check.limit
    if check.passed or value is None or limit is None:
        return usual
    bounds = (limit, 2.0 - limit if check.name == "drive_speed" else -limit)
    digits = range(usual, _MOST_DECIMALS)
    return next((n for n in digits if all(figure(value, n) != figure(bound, n) for bound in bounds)), usual)


def _speed_digits(limit: float | None) -> int:
    """Return how many decimals tell a speed's limit from 1, which it is the nearer to the longer the film is."""
    beyond = (limit or 1.0) - 1.0
    return (
        _SPEED_DIGITS if beyond <= 0.0 else min(_MOST_DECIMALS, max(_SPEED_DIGITS, 1 + math.ceil(-math.log10(beyond))))
    )


def _with_unit(value: float, check: Check) -> str:
    """Return a value of a check with its unit."""
    number = figure(value, _digits(check))
    if check.unit == "ratio":
        return number
    return f"{number} {'sample' if check.unit == 'samples' and abs(value) == 1.0 else check.unit}"


def duration(seconds: float) -> str:
    """Return a duration as h:mm:ss to the nearest second, or, where it is short, in seconds to the nearest tenth.

    >>> duration(7384.2), duration(12.34), duration(59.94), duration(59.97), duration(119.6)
    ('2:03:04', '12.3 s', '59.9 s', '0:01:00', '0:02:00')
    """
    tenths = figure(seconds, 1)
    return f"{tenths} s" if seconds < 60.0 and tenths != "60" else clock_text(Fraction(seconds), 0, hour_digits=1)
