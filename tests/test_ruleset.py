"""Rules as data: key by key the user's value wins, everything is hashed, and what does not fit is one clear line."""

import re
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from blastline.errors import RuleError
from blastline.model import Quality
from blastline.ruleset import (
    Rules,
    actuator_names,
    check_rules,
    load_actuator,
    load_perception,
    load_rules,
    perception_names,
    rules_path,
)
from blastline.ruleset.folder import require_folder

BUILTIN = Path(rules_path("scenes.toml")).parent
QUALITIES: tuple[Quality, ...] = get_args(Quality)
MERGED = ["quality/standard.toml", "scenes.toml", "align.toml"]

Leaf = tuple[str, tuple[str, ...], Any]


def leaves(plain: dict[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    for key, value in plain.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key), value


def every_leaf() -> list[Leaf]:
    found = [
        (file, path, value)
        for file in MERGED
        for path, value in leaves(tomllib.loads((BUILTIN / file).read_text(encoding="utf-8")))
        if path not in {("schema",), ("verify", "model")}
    ]
    assert len(found) > 40
    return found


def written(folder: Path, file: str, text: str) -> Path:
    """Write a rule file into a user's folder and return the folder."""
    (folder / file).parent.mkdir(parents=True, exist_ok=True)
    (folder / file).write_text(text, encoding="utf-8")
    return folder


def as_dict(rules: Rules) -> dict[str, dict[tuple[str, ...], Any]]:
    tables = (rules.tier, rules.scenes, rules.align)
    return {file: dict(leaves(msgspec.to_builtins(table))) for file, table in zip(MERGED, tables, strict=True)}


def other_values(value: Any) -> list[Any]:
    """Return values near a given one; some may be out of range."""
    if isinstance(value, str):
        return [value + " and so on"]
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value - 1]
    if isinstance(value, list):
        return [[*value, 1.5], value[1:]]
    return [value * 1.01, value * 0.99, value + 0.01, value - 0.01]


@pytest.mark.parametrize(("file", "path", "value"), every_leaf())
def test_one_key_of_the_user_changes_that_key_alone_and_the_digest(
    tmp_path: Path, file: str, path: tuple[str, ...], value: Any
) -> None:
    before = load_rules("standard")
    for other in [other for other in other_values(value) if other != value]:
        line = f"{path[-1]} = {msgspec.json.encode(other).decode()}\n"
        written(tmp_path, file, f"[{path[0]}]\n{line}" if len(path) == 2 else line)
        try:
            after = load_rules("standard", tmp_path)
        except RuleError:
            continue
        expected = as_dict(before)
        expected[file][path] = tuple(other) if isinstance(other, list) else other
        assert as_dict(after) == expected
        assert after.digest != before.digest
        return
    pytest.fail("no other value of this key is accepted")


def test_the_digest_depends_on_what_is_read_and_on_nothing_else(tmp_path: Path) -> None:
    before = load_rules("standard").digest
    shutil.copytree(BUILTIN, tmp_path, dirs_exist_ok=True)
    assert load_rules("standard", tmp_path).digest == before
    written(tmp_path, "quality/draft.toml", "[windows]\nguard_ms = 0.8765\n")
    assert load_rules("standard", tmp_path).digest == before
    assert load_rules("draft", tmp_path).digest != load_rules("draft").digest
    model = load_rules("standard").tier.verify.model
    written(tmp_path, f"verifier/{model}", (BUILTIN / "verifier" / model).read_text(encoding="utf-8") + " ")
    assert load_rules("standard", tmp_path).digest != before


def test_the_tiers_have_the_same_keys_and_different_rules() -> None:
    tiers = [load_rules(quality) for quality in QUALITIES]
    assert len({tier.digest for tier in tiers}) == len(tiers) == 3
    assert len({frozenset(as_dict(tier)[MERGED[0]]) for tier in tiers}) == 1


def test_every_shipped_file_is_sound() -> None:
    assert set(check_rules(BUILTIN)) == {path.relative_to(BUILTIN).as_posix() for path in BUILTIN.rglob("*.toml")}


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        ("quality/standard.toml", "[windows]\nbogus = 1\n", "windows.bogus: no such key"),
        ("quality/standard.toml", "bogus = 1\n", "bogus: no such key"),
        ("quality/standard.toml", "windows = 1\n", "windows = 1: expected a group of keys, not a whole number"),
        (
            "quality/standard.toml",
            "[windows]\nguard_ms = '1 ms'\n",
            "windows.guard_ms = '1 ms': expected a number, not",
        ),
        (
            "quality/standard.toml",
            '[scan]\nband_jump_db = "off"\n',
            "scan.band_jump_db = 'off': expected a number, not a text",  # TOML has no null
        ),
        ("quality/standard.toml", "[windows]\nguard_ms = -1\n", "windows.guard_ms = -1: expected a number, 0 or more"),
        ("quality/standard.toml", "[windows]\nguard_ms = true\n", "windows.guard_ms = true: expected a number, not"),
        (
            "quality/standard.toml",
            "[windows]\nguard_ms = inf\n",
            "windows.guard_ms = inf: expected a number, 10000 or less",
        ),
        ("align.toml", "rise_db = inf\n", "rise_db = inf: expected a number, 1000000 or less"),
        ("align.toml", "preecho_guard_ms = 1e308\n", "preecho_guard_ms = 1e+308: expected a number, 1000 or less"),
        (
            "quality/standard.toml",
            "[segment]\nlongest_blast_ms = 1e308\n",
            "segment.longest_blast_ms = 1e+308: expected a number, 3000 or less",
        ),
        (
            "quality/standard.toml",
            "[rows]\nlongest_loop_s = 0.001\n",
            "rows: longest_loop_s = 0.001: expected at least",
        ),
        (
            "quality/standard.toml",
            "[rows]\nlongest_gap_ms = 1e300\n",
            "rows.longest_gap_ms = 1e+300: expected a number, ",
        ),
        ("quality/standard.toml", "[verify]\ncompany_s = 1e300\n", "verify.company_s = 1e+300: expected a number, "),
        ("quality/standard.toml", "[bursts]\nshortest_gap_ms = 0.001\n", "bursts.shortest_gap_ms = 0.001: expected"),
        ("quality/standard.toml", "[bursts]\nlongest_gap_ms = 30\n", "bursts: shortest_gap_ms = 35.0: expected less"),
        (
            "quality/standard.toml",
            "[channels]\nazimuth_rise_db = 1e9\n",
            "channels.azimuth_rise_db = 1000000000.0: exp",
        ),
        ("quality/standard.toml", "[render]\ntolerance = 0\n", "render.tolerance = 0: expected a number, "),
        ("quality/standard.toml", "[render]\npreroll_ms = 1e300\n", "render.preroll_ms = 1e+300: expected a number, "),
        ("quality/standard.toml", "[windows]\nguard_ms = nan\n", "windows.guard_ms = nan: expected"),
        (
            "quality/standard.toml",
            "[bursts]\nfewest_shots = 1\n",
            "bursts.fewest_shots = 1: expected a whole number, 2 or more",
        ),
        (
            "quality/standard.toml",
            "[bursts]\nfewest_shots = 2.5\n",
            "bursts.fewest_shots = 2.5: expected a whole number, not",
        ),
        (
            "quality/standard.toml",
            "[segment]\nlongest_ms = 3001\n",
            "segment.longest_ms = 3001: expected a number, 3000 or less",
        ),
        (
            "quality/standard.toml",
            "[segment]\nlatest_reflection_ms = 1e9\n",
            "segment.latest_reflection_ms = 1000000000.0: expected a number, 3000 or less",
        ),
        (
            "quality/standard.toml",
            "[scan]\nsource = ''\n",
            "scan.source = '': expected a text of at least 3 characters",
        ),
        ("quality/standard.toml", "schema = 2\n", "schema = 2: expected 1, the only layout that this version reads"),
        (
            "quality/standard.toml",
            "[scan\n",
            "not a TOML file: Expected ']' at the end of a table declaration (at line 1",
        ),
        ("align.toml", "correlation = 1.5\n", "correlation = 1.5: expected a number, 1 or less"),
        ("scenes.toml", "[scan]\n", "scan: no such key"),
        ("measuring.toml", "[fit]\nrumble_hz = 2000.0\n", "fit: rumble_hz = 2000.0: expected less than band_hz = "),
    ],
)
def test_a_rule_that_does_not_fit_is_named(tmp_path: Path, file: str, text: str, complaint: str) -> None:
    written(tmp_path, file, text)
    with pytest.raises(RuleError, match=re.escape(f"{tmp_path / file}: {complaint}")) as raised:
        list(check_rules(tmp_path))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "file",
    sorted(p.relative_to(BUILTIN).as_posix() for each in ("*", "quality/*") for p in BUILTIN.glob(f"{each}.toml")),
)
def test_the_check_reads_each_rule_file_that_there_is(tmp_path: Path, file: str) -> None:
    written(tmp_path, file, "nothing_reads_this = 1\n")
    with pytest.raises(RuleError, match=re.escape(f"{tmp_path / file}: nothing_reads_this: no such key")):
        list(check_rules(tmp_path))


@pytest.mark.parametrize("kind", ["perception", "actuators"])
def test_the_check_reads_what_else_is_in_a_folder_of_rules(tmp_path: Path, kind: str) -> None:
    shipped = min((BUILTIN / kind).glob("*.toml"))
    file = f"{kind}/{shipped.name}"
    written(tmp_path, file, shipped.read_text(encoding="utf-8"))
    assert list(check_rules(tmp_path)) == [file]
    written(tmp_path, file, "nothing_reads_this = 1\n" + shipped.read_text(encoding="utf-8"))
    with pytest.raises(RuleError, match=re.escape(f"{tmp_path / file}: nothing_reads_this: no such key")):
        list(check_rules(tmp_path))


def test_a_table_of_thresholds_among_the_rules_is_a_curve_by_its_name(tmp_path: Path) -> None:
    table = "# source: my thesis\nfrequency_hz,threshold_db\n20,-5\n50,-17\n"
    written(tmp_path, "perception/skin.csv", table)
    assert list(check_rules(tmp_path)) == ["perception/skin.csv"]
    assert "skin" in perception_names(tmp_path)
    curve = load_perception("skin", tmp_path)
    assert (curve.name, curve.source, curve.threshold_db) == ("skin", "my thesis", (-5.0, -17.0))

    # the user's own comes before the built-in one, whatever its kind; two of one name leave open which is meant
    written(tmp_path, "perception/mpeg-psychohaptic.csv", table)
    assert load_perception("mpeg-psychohaptic", tmp_path).source == "my thesis"
    written(tmp_path, "perception/skin.toml", (BUILTIN / "perception/iso-2631-wk.toml").read_text(encoding="utf-8"))
    with pytest.raises(RuleError, match=re.escape(f"{tmp_path / 'perception/skin.toml'}: there is skin.csv as well")):
        load_perception("skin", tmp_path)
    with pytest.raises(RuleError, match=re.escape("there is skin.csv as well")):
        list(check_rules(tmp_path))
    (tmp_path / "perception/skin.toml").unlink()

    written(tmp_path, "perception/zone.csv", "frequency_hz,threshold_db\n20,-5\n")
    with pytest.raises(RuleError, match=re.escape(f"{tmp_path / 'perception/zone.csv'}: holds 1 row; expected")):
        list(check_rules(tmp_path))


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    profile = (BUILTIN / "actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    file = written(tmp_path, "own.toml", profile.replace("corner_hz = 5.0\n", "")) / "own.toml"
    with pytest.raises(RuleError, match=re.escape(f"{file}: highpass.corner_hz: is missing")):
        load_actuator(str(file))


def test_a_file_with_a_byte_order_mark_is_read_as_one_without(tmp_path: Path) -> None:
    text = "[windows]\r\nguard_ms = 0.8765\r\n"  # as editors on Windows write it
    marked = written(tmp_path, "quality/draft.toml", f"\ufeff{text}")
    assert list(check_rules(marked)) == ["quality/draft.toml"]
    assert load_rules("draft", marked).tier.windows.guard_ms == 0.8765


def test_a_file_that_is_no_utf_8_is_named(tmp_path: Path) -> None:
    (tmp_path / "scenes.toml").write_bytes(b"source = '\xff'\n")
    with pytest.raises(RuleError, match=r"scenes\.toml: line 1: the byte 0xff is not UTF-8; expected a TOML file"):
        load_rules("standard", tmp_path)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_a_file_in_utf_16_is_told_to_be_one(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "scenes.toml").write_bytes("source = 'mine'\n".encode(encoding))
    with pytest.raises(RuleError, match=r"scenes\.toml: line 1: begins as UTF-16 does; expected a TOML file in UTF-8"):
        load_rules("standard", tmp_path)


def test_a_folder_and_a_verifier_that_do_not_exist_are_named(tmp_path: Path) -> None:
    with pytest.raises(RuleError, match=r"none: not a folder; expected one with rule files"):
        load_rules("standard", tmp_path / "none")
    written(tmp_path, "quality/standard.toml", "[verify]\nmodel = 'own.json'\n")
    told = f"{tmp_path / 'quality/standard.toml'}: verify.model = 'own.json': expected the name of a file in "
    with pytest.raises(RuleError, match=re.escape(f"{told}{tmp_path / 'verifier'} or {BUILTIN / 'verifier'}")):
        load_rules("standard", tmp_path)


@pytest.mark.parametrize("name", ["best.toml", "quality/best.toml", "notes.txt", None])
def test_a_folder_without_any_rule_file_is_named(tmp_path: Path, name: str | None) -> None:
    if name is not None:
        written(tmp_path, name, "")
    none = f" ({name} is none)" if name and name.endswith(".toml") else ""
    complaint = f"{tmp_path}: has no rule file that blastline reads{none}; expected some of: align.toml, "
    for read in (lambda: load_rules("standard", tmp_path), lambda: [*check_rules(tmp_path)]):
        with pytest.raises(RuleError, match=re.escape(complaint)):
            read()


@pytest.mark.parametrize("file", ["actuators/seat.toml", "perception/skin.toml", "verifier/shots.json", "haptics.toml"])
def test_one_file_of_any_kind_that_is_read_makes_a_folder_of_rules(tmp_path: Path, file: str) -> None:
    require_folder(written(tmp_path, file, ""))


@pytest.mark.parametrize("name", ["Scenes.toml", "quality/standart.toml"])
def test_a_file_that_nothing_reads_is_named_by_whoever_is_given_the_folder(tmp_path: Path, name: str) -> None:
    written(tmp_path, "align.toml", "correlation = 0.8\n")
    written(tmp_path, name, "")
    complaint = rf"{re.escape(str(tmp_path / name))}: not a rule file that blastline reads; expected .*standard\.toml"
    for read in (lambda: load_rules("standard", tmp_path), lambda: [*check_rules(tmp_path)]):
        with pytest.raises(RuleError, match=complaint):
            read()


def test_a_file_in_a_folder_that_nothing_reads_is_named_by_the_check(tmp_path: Path) -> None:
    written(tmp_path, "align.toml", "correlation = 0.8\n")
    written(tmp_path, "qualities/standard.toml", "")
    checked = check_rules(tmp_path)
    assert next(checked) == "align.toml"
    with pytest.raises(RuleError, match=r"qualities/standard\.toml: not a rule file that blastline reads; expected "):
        next(checked)


def test_a_profile_is_the_same_by_name_and_by_file(tmp_path: Path) -> None:
    [name] = set(actuator_names()) & {"crowson-t108sm"}
    text = (BUILTIN / f"actuators/{name}.toml").read_text(encoding="utf-8")
    own = written(tmp_path, "actuators/own-seat.toml", text)
    assert load_actuator(name) == load_actuator(str(own / "actuators/own-seat.toml")) == load_actuator("own-seat", own)
    assert actuator_names(own) == sorted({*actuator_names(), "own-seat"})
    written(tmp_path, "actuators/own-seat.toml", text.replace("gain = 2.44e6", "gain = 2.45e6"))
    assert load_actuator("own-seat", own)[1] != load_actuator(name)[1]
    with pytest.raises(RuleError, match=r"none: no such actuator profile; .*one of: .*crowson-t108sm.*own-seat"):
        load_actuator("none", own)


@pytest.mark.parametrize(
    ("before", "after", "complaint"),
    [
        (
            "[[-1400.0, 0.0], ",
            "[[1400.0, 0.0], ",
            "response.poles_rad_s[0] = [1400.0, 0.0]: expected a negative real part",
        ),
        ("[[-1400.0, 0.0], ", "[[0.0, 0.0], ", "response.poles_rad_s[0] = [0.0, 0.0]: expected a negative real part"),
        ("[[-20.0, 0.0]]", "[[20.0, 0.0]]", "response.zeros_rad_s[0] = [20.0, 0.0]: expected a negative real part"),
        ("[[-20.0, 0.0]]", "[[nan, 0.0]]", "response.zeros_rad_s[0][0] = nan: expected a finite number"),
        ("[[-20.0, 0.0]]", "[[-20.0, 5.0]]", "expected its conjugate [-20.0, -5.0] in the list as well"),
        (
            "[[-1400.0, 0.0], [-1400.0, 0.0], [-1400.0, 0.0]]",
            "[[-9.0, 5.0], [-9.0, 5.0], [-9.0, -5.0]]",
            "expected its conjugate [-9.0, -5.0] in the list as well",
        ),
        ("[[-20.0, 0.0]]", "[[-20.0, 0.0], [-9.0, 0.0], [-8.0, 0.0]]", "expected more poles than zeros"),
        ("order = 3", "order = 2", "lowpass.order = 2: expected more than 2"),
        ("gain = 2.44e6 ", "gain = 0 ", "response.gain = 0: expected a number, more than 0"),
    ],
)
def test_an_actuator_that_cannot_be_compensated_is_refused(
    tmp_path: Path, before: str, after: str, complaint: str
) -> None:
    text = (BUILTIN / "actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    table = text[text.index("\n[response]") :].replace("gain = 2.44e6", "gain = 2.44e6 ")
    assert before in table
    head = text[: text.index("\n[response]")]
    file = written(tmp_path, "own.toml", head + table.replace(before, after)) / "own.toml"
    with pytest.raises(RuleError, match=re.escape(complaint)) as raised:
        load_actuator(str(file))
    assert str(raised.value).startswith(f"{file}: ")
