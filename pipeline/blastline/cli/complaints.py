"""What is wrong with the arguments, in one line: the option, its value and what was expected."""

from typing import Any, get_args

import typer


def complaint(error: typer.TyperException) -> str:
    """Return an error of the arguments for people; where a value does not fit, with the value and what would."""
    param, cause = getattr(error, "param", None), error.__cause__
    problems: list[dict[str, Any]] = getattr(cause, "errors", list)()
    if param is None or not problems:
        return error.format_message().rstrip(".")
    raised, expected = problems[0].get("ctx", {}).get("error"), _expected(param)
    longest = max(param.opts, key=len)
    name = longest if longest.startswith("-") else param.metavar
    wanted = f"expected {expected}" if expected else str(raised or problems[0]["msg"])
    return f"{name} {problems[0]['input']!r}: {wanted}"


def _expected(param: Any) -> str | None:
    """Return what an option takes, where that is a number or one of some words.

    `param` is what the command line knows of the option.
    """
    kind = getattr(getattr(param, "type_descriptor", None), "annotation", None)
    if get_args(kind):
        return f"one of: {', '.join(map(str, get_args(kind)))}"
    if kind not in (int, float):
        return None
    number = "a whole number" if kind is int else "a number"
    if param.min is None and param.max is None:
        return number
    if param.max is None:
        return f"{number}, {param.min:g} or more"
    return f"{number}, {param.max:g} or less" if param.min is None else f"{number} from {param.min:g} to {param.max:g}"
