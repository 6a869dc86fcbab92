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


def misfit(plain: Any, error: Exception, table: type | None = None) -> str:
    """Return which key of plain data does not fit, its value and what was expected, from msgspec's complaint.

    Which words a key takes msgspec does not tell; `table`, what the data was to become, does.

    >>> misfit({"scan": {"window_ms": 0}}, ValueError("Expected `float` > 0.0 - at `$.scan.window_ms`"))
    'scan.window_ms = 0: expected `float` > 0.0'
    """
    complaint, _, place = str(error).partition(" - at `$")
    key = place.strip(".`")
    value = _value_at(plain, key)
    shown = "" if isinstance(value, dict | list) else f" = {value!r}"
    words = _words_at(table, key) if table and complaint.startswith("Invalid enum value") else ()
    if words:
        complaint = f"expected {'one of: ' * (len(words) > 1)}{', '.join(words)}"
    complaint = re.sub(r"`str` of length >= (\d+)", r"a text of at least \1 characters", complaint)
    return f"{key or 'top level'}{shown}: {complaint[:1].lower()}{complaint[1:]}"


def _steps(key: str) -> list[str]:
    """Return the steps of a msgspec path such as `response.zeros[0]`; `...` stands for any key of a mapping."""
    return re.findall(r"\.\.\.|[^.\[\]]+", key)


def _value_at(plain: Any, key: str) -> Any:
    for step in _steps(key):
        if step != "...":
            plain = plain[int(step)] if isinstance(plain, list) else plain[step]
    return plain


def _words_at(table: type, key: str) -> tuple[str, ...]:
    """Return the words, or numbers, that a key of a table takes; none where it takes whatever has its type."""
    from msgspec import inspect

    kinds: list[Any] = [inspect.type_info(table)]
    for step in _steps(key):
        kinds = [inner for kind in kinds for each in _alternatives(kind) for inner in _inside(each, step)]
    literals = [each for kind in kinds for each in _alternatives(kind) if isinstance(each, inspect.LiteralType)]
    return tuple(str(value) for literal in literals for value in literal.values)


def _alternatives(kind: Any) -> tuple[Any, ...]:
    return getattr(kind, "types", (kind,))


def _inside(kind: Any, step: str) -> list[Any]:
    """Return the type of what a step of a path leads to from a type; none where it leads nowhere."""
    if hasattr(kind, "fields"):
        return [field.type for field in kind.fields if field.encode_name == step]
    if hasattr(kind, "item_types"):
        return [kind.item_types[int(step)]]
    return [inner for inner in (getattr(kind, name, None) for name in ("item_type", "value_type")) if inner is not None]
