"""What can go wrong, as exceptions with one line for the user.

    BlastlineError
      RuleError        a rule file, profile or option       (also a ValueError)
      SoundtrackError  audio that cannot be read            (also an OSError)
      OutputError      a result that cannot be written      (also an OSError)
      TimelineError    a timeline file that cannot be used  (also a ValueError)

The message holds the file, the key or time, the value, and what was expected. The command line prints it and
exits with 2. A *finding* (a rejected candidate, a failed alignment check) is data, never an exception.
"""

import re
from typing import Any


class BlastlineError(Exception):
    """Base of every error that a user can cause and mend."""


class RuleError(BlastlineError, ValueError):
    """A rule file, an actuator profile or an option is unusable."""


class SoundtrackError(BlastlineError, OSError):
    """A soundtrack cannot be opened or decoded."""


class OutputError(BlastlineError, OSError):
    """A result cannot be written."""


class TimelineError(BlastlineError, ValueError):
    """A timeline file cannot be used."""


def misfit(plain: Any, error: Exception) -> str:
    """Return which key of plain data does not fit, its value and what was expected, from msgspec's complaint.

    >>> misfit({"scan": {"window_ms": 0}}, ValueError("Expected `float` > 0.0 - at `$.scan.window_ms`"))
    'scan.window_ms = 0: expected `float` > 0.0'
    """
    complaint, _, place = str(error).partition(" - at `$")
    key = place.strip(".`")
    value = _value_at(plain, key)
    shown = "" if isinstance(value, dict | list) else f" = {value!r}"
    complaint = re.sub(r"`str` of length >= (\d+)", r"a text of at least \1 characters", complaint)
    return f"{key or 'top level'}{shown}: {complaint[:1].lower()}{complaint[1:]}"


def _value_at(plain: Any, key: str) -> Any:
    """Return the value at a msgspec path such as `response.zeros[0]`; `[...]` stands for any key of a mapping."""
    for step in key.replace("[", ".").replace("]", "").replace("...", "").split("."):
        if step:
            plain = plain[int(step)] if isinstance(plain, list) else plain[step]
    return plain
