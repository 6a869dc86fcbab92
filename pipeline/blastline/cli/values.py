"""What arguments and options are given, read: paths, none of which may be empty, and lists."""

from pathlib import Path

from ..errors import RuleError


def rules_folder(text: str) -> Path:
    """Return the folder that is named; RuleError where none is."""
    return _named(text, "a folder with rule files")


def results_folder(text: str) -> Path:
    """Return the folder that is named; RuleError where none is."""
    return _named(text, "a folder for the results")


def result_by_name(text: str) -> Path:
    """Return the result that is named; RuleError where none is."""
    return _named(text, "a result's folder or its timeline.json")


def edited_by_name(text: str) -> Path:
    """Return the edited timeline that is named; RuleError where none is."""
    return _named(text, "an edited timeline or a result's folder")


def film_file(text: str) -> Path:
    """Return the film that is named; RuleError where none is."""
    return _named(text, "a film or a sound file")


def timeline_file(text: str) -> Path:
    """Return the file that is named; RuleError where none is."""
    if text == "-":
        raise RuleError("expected the name of a file; without -o the timeline goes to standard output")
    return _named(text, "a file for the timeline")


def _named(text: str, what: str) -> Path:
    """Return a path; an empty name, such as a script's unset variable, would be the current folder."""
    if not text:
        raise RuleError(f"expected the name of {what}")
    return Path(text)


def items_of(text: str) -> tuple[str, ...]:
    """Return the items of a comma-separated option.

    >>> items_of("json, csv")
    ('json', 'csv')
    """
    return tuple(item.strip() for item in text.split(","))
