"""Why plain data does not become a table: the key, its value and what was expected, in words of the file.

The library that converts it speaks of types of Python; whoever wrote the file knows numbers, texts, lists and keys.
"""

import re
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any

_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "a group of keys",
    "null": "null",
}
"""What the names of types in a complaint are called."""

_TYPES = {"float": float, "int": int, "str": str, "bool": bool, "array": list, "object": dict, "null": type(None)}

_COMPARISONS = {">=": "{} or more", "<=": "{} or less", ">": "more than {}", "<": "less than {}"}
_LENGTHS = {">=": "at least ", "<=": "at most ", None: ""}
_EXPECTED = re.compile(
    r"Expected (?P<kinds>`[^`]+`)(?P<long> of length)?(?: (?:(?P<sign>[<>]=?) )?(?P<bound>[-+.\de]+))?"
)
_MISSING = re.compile(r"Object missing required field `(.+)`")
_UNKNOWN = re.compile(r"Object contains unknown field `(.+)`")
_FOUND = re.compile(r", got `?([^`]+)`?")
_LONGEST_SHOWN = 60
_MOST_LISTED = 10


def misfit(plain: Any, error: Exception, table: type, *, null: str = "null") -> str:
    """Return which key of plain data does not fit, its value and what was expected, from msgspec's complaint.

    Which words a key takes msgspec does not tell; `table`, what the data was to become, does. `null` is the word for a
    key that is left out, empty where there is none, as in TOML.

    >>> misfit({"rate": 0}, ValueError("Expected `float` > 0.0 - at `$.rate`"), dict[str, float])
    'rate = 0: expected a number, more than 0'
    """
    complaint, _, place = str(error).partition(" - at `$")
    key = place.strip(".`")
    if absent := _MISSING.fullmatch(complaint):
        return _absent(plain, table, key, absent[1], null)
    if unknown := _UNKNOWN.fullmatch(complaint):
        return f"{_joined(key, unknown[1])}: no such key{_meant(table, key, unknown[1])}"
    key = _with_key(plain, key, complaint)
    value = _value_at(plain, key)
    said = "" if isinstance(value, dict | list) else f" = {shown(value)}"
    if complaint.startswith("Invalid enum value"):
        complaint = _one_of(table, key, null) or complaint
    return f"{key or 'top level'}{said}: {_said(complaint, null)}"


def _said(complaint: str, null: str) -> str:
    """Return a complaint without the names of Python's types."""
    told = _EXPECTED.match(complaint)
    if told is None:
        return f"{complaint[:1].lower()}{complaint[1:]}"
    what, sign, bound = _kinds(told["kinds"], null), told["sign"], told["bound"]
    if told["long"] and bound:
        parts = "characters" if "str" in told["kinds"] else "entries"
        what = f"{what} of {_LENGTHS[sign]}{bound} {parts}"
    elif sign:
        what = f"{what}, {_COMPARISONS[sign].format(bound.removesuffix('.0'))}"
    whole = {"`int`", "`int | null`"} & {told["kinds"]}
    other = _WORDS | ({"float": "one with decimals"} if whole else {})
    rest = _FOUND.sub(lambda found: f", not {other.get(found[1], found[1])}", complaint[told.end() :])
    return f"expected {what}{rest}"


def _kinds(names: str, null: str) -> str:
    """Return types, as in `float | null`, in words."""
    words = _WORDS | {"null": null}
    return " or ".join(filter(None, (words.get(name, name) for name in names.strip("`").split(" | "))))


def shown(value: Any) -> str:
    """Return a value as a file has it; the end of a long one is left out."""
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    text = repr(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."


def _joined(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name


def _meant(table: type, key: str, name: str) -> str:
    """Return which key may have been meant by one that is unknown, or else those that there are."""
    known = [field.encode_name for kind in _kinds_at(table, key) for field in getattr(kind, "fields", ())]
    names = get_close_matches(name, known, n=1) or known
    return f"; expected {'one of: ' * (len(names) > 1)}{', '.join(names)}" if names else ""


def _absent(plain: Any, table: type, key: str, name: str, null: str) -> str:
    """Return which keys a group lacks: the one that was complained of, what it takes, and all others."""
    there = _value_at(plain, key)
    others = [each for each in _required(_kinds_at(table, key)) if each not in there and each != name]
    too = f"; missing, too: {listed(others)}" if others else ""
    return f"{_joined(key, name)}: is missing{_wanted(table, _joined(key, name), null)}{too}"


def _required(kinds: Sequence[Any]) -> list[str]:
    """Return the keys that a group has to have, where it is of one type."""
    fields = getattr(kinds[0], "fields", ()) if len(kinds) == 1 else ()
    return [field.encode_name for field in fields if field.required]


def _wanted(table: type, key: str, null: str) -> str:
    """Return what a key that is missing takes, where the table tells; nothing where it takes whatever there is."""
    names = {
        "IntType": "int",
        "FloatType": "float",
        "StrType": "str",
        "BoolType": "bool",
        "StructType": "object",
        "DictType": "object",
        "VarTupleType": "array",
        "TupleType": "array",
        "ListType": "array",
        "NoneType": "null",
    }
    inner = _required(_kinds_at(table, key))
    if inner:
        return f"; expected a group of keys with {listed(inner)}"
    kinds = [names.get(type(kind).__name__) for kind in _kinds_at(table, key)]
    if words := _one_of(table, key, null):
        return f"; {words}"
    known = [kind for kind in kinds if kind]
    return f"; expected {_kinds(' | '.join(known), null)}" if known and len(known) == len(kinds) else ""


def _steps(key: str) -> list[str]:
    """Return the steps of a msgspec path such as `response.zeros[0]`; `...` stands for any key of a mapping."""
    return re.findall(r"\.\.\.|[^.\[\]]+", key)


def _with_key(plain: Any, path: str, complaint: str) -> str:
    """Return a path that ends in any key of a mapping with the first one whose value is of the type that was found."""
    found = _FOUND.search(complaint)
    if not path.endswith("[...]") or found is None:
        return path
    outer = path.removesuffix("[...]")
    kind = _TYPES.get(found[1], object)
    return next((f"{outer}.{key}" for key, value in _value_at(plain, outer).items() if type(value) is kind), path)


def _value_at(plain: Any, key: str) -> Any:
    for step in _steps(key):
        if step != "...":
            plain = plain[int(step)] if isinstance(plain, list) else plain[step]
    return plain


def _one_of(table: type, key: str, null: str) -> str:
    """Return that one of some words, or numbers, was expected; nothing where a key takes whatever has its type."""
    from msgspec import inspect

    kinds = _kinds_at(table, key)
    words = [str(value) for kind in kinds if isinstance(kind, inspect.LiteralType) for value in kind.values]
    if not words:
        return ""
    or_null = f" or {null}" if null and any(isinstance(kind, inspect.NoneType) for kind in kinds) else ""
    return f"expected {'one of: ' * (len(words) > 1)}{', '.join(words)}{or_null}"


def _kinds_at(table: type, key: str) -> list[Any]:
    """Return the types that a key of a table takes, as msgspec describes them."""
    from msgspec import inspect

    kinds: list[Any] = [inspect.type_info(table)]
    for step in _steps(key):
        kinds = [inner for kind in kinds for each in _alternatives(kind) for inner in _inside(each, step)]
    return [each for kind in kinds for each in _alternatives(kind)]


def _alternatives(kind: Any) -> tuple[Any, ...]:
    return getattr(kind, "types", (kind,))


def _inside(kind: Any, step: str) -> list[Any]:
    """Return the type of what a step of a path leads to from a type; none where it leads nowhere."""
    if hasattr(kind, "fields"):
        return [field.type for field in kind.fields if field.encode_name == step]
    return [inner for inner in (getattr(kind, name, None) for name in ("item_type", "value_type")) if inner is not None]


def listed(names: Sequence[str]) -> str:
    """Return the first ten of some names, and how many more there are.

    >>> listed(["shot-0001", "shot-0002"]), listed("abcdefghijklm")
    ('shot-0001, shot-0002', 'a, b, c, d, e, f, g, h, i, j and 3 more')
    """
    more = f" and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
    return f"{', '.join(names[:_MOST_LISTED])}{more}"
