"""What does not fit a table is told in words of the file: its key, its value, and what would fit."""

import json
import re
from collections.abc import Iterator
from typing import Any, Literal

import msgspec
import pytest

from blastline.misfits import listed, misfit
from blastline.model import Timeline, encode
from blastline.ruleset.aligning import AlignRules
from blastline.ruleset.profiles import Response
from timelines import timeline

PLAIN: dict[str, Any] = json.loads(encode(timeline()))
PYTHON = re.compile(r"`|\b(str|int|float|bool|got|array|field|None|True|False)\b")
STRANGERS: tuple[Any, ...] = ("junk", 1, 2.5, True, None, [], {}, [[]], {"a": 1})


def keys(plain: Any, key: str = "") -> Iterator[str]:
    """Yield the path of every key below plain data, in lists of the first entry alone."""
    if isinstance(plain, dict):
        for name, each in plain.items():
            inner = f"{key}.{name}" if key else name
            yield inner
            yield from keys(each, inner)
    elif isinstance(plain, list) and plain:
        yield f"{key}[0]"
        yield from keys(plain[0], f"{key}[0]")


def refusal(plain: Any, table: type) -> str | None:
    """Return why plain data is no table; None where it is one."""
    try:
        msgspec.convert(plain, table)
    except msgspec.ValidationError as error:
        return misfit(plain, error, table)
    return None


def group_of(plain: Any, key: str) -> tuple[Any, Any]:
    """Return the group, or list, in which a key stands, and what it is called there."""
    *steps, last = (int(step) if step.isdigit() else step for step in re.findall(r"[^.\[\]]+", key))
    for step in steps:
        plain = plain[step]
    return plain, last


def with_value(key: str, value: Any) -> Any:
    """Return the timeline with another value at a key."""
    plain = json.loads(json.dumps(PLAIN))
    group, last = group_of(plain, key)
    group[last] = value
    return plain


def without(key: str) -> Any:
    """Return the timeline less a key."""
    plain = json.loads(json.dumps(PLAIN))
    group, last = group_of(plain, key)
    del group[last]
    return plain


@pytest.mark.parametrize("key", sorted(set(keys(PLAIN))))
def test_whatever_stands_at_a_key_of_a_timeline_is_refused_in_words_of_the_file(key: str) -> None:
    for value in STRANGERS:
        told = refusal(with_value(key, value), Timeline)
        if told is not None:
            place, _, complaint = told.partition(": ")
            assert re.match(rf"{re.escape(key)}\b|{re.escape(key.rpartition('.')[0])}", place), told
            assert not PYTHON.search(complaint), told
            assert "expected" in complaint or "must" in complaint, told


@pytest.mark.parametrize("key", sorted(set(keys(PLAIN))))
def test_of_a_key_that_is_missing_it_is_told_what_it_takes(key: str) -> None:
    told = refusal(without(key), Timeline)
    if told is not None:
        missing, _, taken = told.partition(": is missing; expected ")
        assert missing == key
        assert taken
        assert not PYTHON.search(taken), told
        assert ("null" in taken) == (refusal(with_value(key, None), Timeline) is None), told


class Words(msgspec.Struct):
    """Keys that take words, some of them null as well."""

    many: Literal["loud", "soft"] | None
    one: Literal["loud"] | None
    none: Literal["loud", "soft"]


@pytest.mark.parametrize(
    ("key", "words", "takes_null"),
    [("many", "one of: loud, soft", True), ("one", "loud", True), ("none", "one of: loud, soft", False)],
)
@pytest.mark.parametrize("null", ["null", ""])
def test_a_key_of_words_is_told_with_null_where_it_takes_that(
    key: str, words: str, null: str, *, takes_null: bool
) -> None:
    for value, said in ((None, f"{key}: is missing"), ("high", f"{key} = 'high'")):
        plain = {"many": "loud", "one": "loud", "none": "loud"} | {key: value}
        plain = {name: word for name, word in plain.items() if word is not None}
        with pytest.raises(msgspec.ValidationError) as raised:
            msgspec.convert(plain, Words)
        told = misfit(plain, raised.value, Words, null=null)
        assert told == f"{said}{': ' if value else '; '}expected {words}{' or null' * (takes_null and bool(null))}"


WINDOW = "events[0].window.start_sample: is missing; expected a whole number"


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("events[0].onset_s", "12", "events[0].onset_s = '12': expected a number, not a text"),
        ("events[0].onset_sample", 1.5, "events[0].onset_sample = 1.5: expected a whole number, not one with decimals"),
        ("events[0].burst", "1", "events[0].burst = '1': expected a whole number or null, not a text"),
        ("events[0].gain_db", None, "events[0].gain_db = null: expected a number, not null"),
        ("rejections[0].evidence.crest", [], "rejections[0].evidence.crest: expected a number, not a list"),
        ("source.stream", [1], "source.stream: expected a list of at least 2 entries"),
        ("events", {}, "events: expected a list, not a group of keys"),
        ("events[0].window", {}, f"{WINDOW}; missing, too: stop_sample, fade_in_samples, fade_out_samples"),
        ("events[0].drive", {}, "events[0].drive.model: is missing; expected one of: constrained, direct, filter"),
        ("events[0].window", {"stop_sample": 9}, f"{WINDOW}; missing, too: fade_in_samples, fade_out_samples"),
        ("events[0].id", ["x" * 900], "events[0].id: expected a text, not a list"),
        ("events[0].window", "x" * 900, f"events[0].window = '{'x' * 59}...: expected a group of keys, not a text"),
    ],
)
def test_a_misfit_says_its_value_and_what_would_fit(key: str, value: Any, told: str) -> None:
    assert refusal(with_value(key, value), Timeline) == told


@pytest.mark.parametrize("pole", [[], [-1400.0], [-1400.0, 0.0, 0.0]])
def test_a_pole_of_another_length_than_two_is_told_with_both(pole: list[float]) -> None:
    plain = {"source": "test", "gain": 1.0, "zeros_rad_s": [], "poles_rad_s": [[-20.0, 0.0], pole]}
    assert refusal(plain, Response) == f"poles_rad_s[1]: expected a list of 2 entries, not {len(pole)}"


@pytest.mark.parametrize(
    ("name", "meant"),
    [("korrelation", "correlation"), ("peak_db", "peak"), ("zzz", "one of: source, schema, longest_ms, ")],
)
def test_a_key_that_is_not_known_is_told_with_the_one_that_may_be_meant(name: str, meant: str) -> None:
    told = refusal({name: 1}, AlignRules)
    assert told is not None
    assert told.startswith(f"{name}: no such key; expected {meant}")


@pytest.mark.parametrize("count", range(1, 14))
def test_names_are_listed_whole_or_with_the_number_of_the_others(count: int) -> None:
    names = [f"name-{n}" for n in range(count)]
    said, _, more = listed(names).partition(" and ")
    shown = said.split(", ")
    assert (shown, len(shown)) == (names[: len(shown)], min(count, 10))
    assert more == (f"{count - len(shown)} more" if count > len(shown) else "")
