"""What the command line says and how it ends, without a film."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from blastline import __version__, interruption
from blastline.cli import app
from blastline.errors import OutputError, SoundtrackError
from blastline.export import FORMATS
from blastline.ruleset import load_rules
from commands import COMMAND, Ended, blastline, blastline_alone, write_film

HEAVY = {"av", "librosa", "matplotlib", "numba", "opentimelineio", "pandas", "scipy", "sklearn", "soundfile", "soxr"}


def every_command(group: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield each command's words; groups come before the commands in them."""
    group = group or typer.main.get_command(app)
    yield path
    for name, each in getattr(group, "commands", {}).items():
        yield from every_command(each, (*path, name))


def test_the_promised_commands_are_there() -> None:
    promised = {
        "render",
        "detect",
        "check",
        "export",
        "conform",
        "synth",
        "actuator list",
        "actuator show",
        "actuator identify",
        "actuator fit",
        "rules show",
        "rules check",
    }
    assert {" ".join(words) for words in every_command()} >= promised


@pytest.mark.parametrize("words", list(every_command()), ids=" ".join)
def test_help_teaches_by_an_example(words: tuple[str, ...]) -> None:
    ended = blastline(*words, "--help")
    assert (ended.code, ended.err) == (0, "")
    text = " ".join(ended.out.split())
    assert f"Usage: {' '.join(['blastline', *words])} " in text
    is_group = not words or words in {("actuator",), ("rules",), ("study",)}
    assert is_group or f"Example: blastline {' '.join(words)}" in text


def test_no_arguments_show_the_help() -> None:
    assert blastline() == blastline("--help")


def test_help_names_every_format_and_every_default() -> None:
    text = " ".join(blastline("render", "--help").out.replace("│", " ").split())
    assert ", ".join(FORMATS) in text
    for default in ("(standard)", "auto", "causal", "mute", "mains", "crowson-t108sm", "json,csv", "report"):
        assert f"[default: {default}]" in text


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, blastline.cli; blastline.cli.main(['render', '--help']); sys.stderr.write(' '.join(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in done.stderr.split()}
    assert {"blastline", "typer"} <= loaded
    assert loaded & HEAVY == set()


def test_the_version() -> None:
    assert blastline("--version") == Ended(0, f"blastline {__version__}\n", "")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ("bogus", "No such command 'bogus' (see `blastline --help`)"),
        ("rules", "Missing command (see `blastline rules --help`)"),
        ("render", "Missing argument 'INPUT' (see `blastline render --help`)"),
        ("render film.wav", "Missing option '-o' / '--output' (see `blastline render --help`)"),
        ("render film.wav -o out --no-such-option", "No such option: --no-such-option"),
        ("detect film.wav --quality best", "--quality 'best': expected one of: draft, standard, reference (see `"),
        ("render film.wav -o out --drive loud", "--drive 'loud': expected one of: auto, "),
        ("detect film.wav --stream first", "--stream 'first': expected the number of a sound stream, from 0, or those"),
        ("detect film.wav --stream 1.5", "--stream '1.5': expected the number of a sound stream, from 0, or those"),
        ("detect film.wav --stream -1", "--stream '-1': expected the number of a sound stream, from 0, or those"),
        ("render film.wav -o out --stream 5-0", "--stream '5-0': expected the number of a sound stream, from 0, or"),
        ("check out --stream 0,0", "--stream '0,0': names sound stream 0 twice"),
        ("detect film.wav --max-cost abc", "--max-cost 'abc': expected a number (see `blastline detect --help`)"),
        ("study conform --minutes 99", "--minutes '99': expected a number from 1 to 60"),
        ("detect film.wav --stream", "Option '--stream' requires an argument"),
        ("rules show --rules=", "--rules '': expected the name of a folder with rule files"),
        ("actuator list --rules=", "--rules '': expected the name of a folder with rule files"),
        ("detect film.wav other.wav", "other.wav"),
        ("export timeline.json -o out", "Missing option '--format'"),
    ],
)
def test_wrong_arguments_are_one_line(arguments: str, complaint: str) -> None:
    assert complaint in blastline(*arguments.split()).complaint


def test_a_folder_of_rules_needs_a_name_and_a_rule_file(tmp_path: Path) -> None:
    assert "DIR '': expected the name of a folder with rule files" in blastline("rules", "check", "").complaint
    complaint = f"{tmp_path}: has no rule file that blastline reads; expected some of: align.toml, "
    assert complaint in blastline("rules", "check", tmp_path).complaint
    assert complaint in blastline("rules", "show", "--rules", tmp_path).complaint


def test_an_error_of_the_users_is_one_line_however_many_it_had(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OutputError("out: cannot write\nbecause")

    monkeypatch.setattr("blastline.cli.rulefiles.load_rules", fail)
    assert blastline("rules", "show").complaint == "out: cannot write because"


def test_an_error_of_the_system_names_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("blastline.cli.rulefiles.load_rules", lambda *_: Path("/none/there").read_text())
    assert blastline("rules", "show").complaint == "/none/there: No such file or directory"


def test_a_bug_shows_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("blastline.cli.rulefiles.load_rules", lambda *_: 1 // 0)
    ended = blastline("rules", "show")
    assert ended.code == 70
    assert "ZeroDivisionError" in ended.err
    assert ended.err.endswith("blastline: this is a bug of blastline; please report it with the lines above\n")


def test_an_interruption_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("blastline.cli.rulefiles.load_rules", interrupt)
    ended = blastline("rules", "show")
    assert (ended.code, ended.err.splitlines()[-1]) == (130, "blastline: interrupted; nothing was written")


def test_an_interruption_that_comes_when_all_is_written_does_not_deny_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    film = write_film(tmp_path / "film.wav", length_s=1.0)
    monkeypatch.setattr("blastline.cli.film.say_summary", interrupt)
    ended = blastline("render", film, "-o", tmp_path / "out", "--no-report")
    assert (ended.code, ended.err.splitlines()[-1]) == (130, "blastline: interrupted; all results had been written")
    assert (tmp_path / "out" / "timeline.json").exists()
    monkeypatch.setattr("blastline.cli.rulefiles.load_rules", interrupt)
    assert blastline("rules", "show").err == "blastline: interrupted; nothing was written\n"


@pytest.mark.parametrize("error", [ValueError("Invalid matrix"), SoundtrackError("film.wav: cannot be read")])
def test_what_a_library_makes_of_an_interruption_is_one(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def interrupt(*_: object) -> None:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        raise error

    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)  # whoever runs the tests may have it ignored
    try:
        with monkeypatch.context() as patched:
            patched.setattr("blastline.cli.rulefiles.load_rules", interrupt)
            ended = blastline("rules", "show")
    finally:
        signal.signal(signal.SIGTERM, before)
    assert (ended.code, ended.err) == (130, "blastline: interrupted; nothing was written\n")
    assert blastline("rules", "show").code == 0


@pytest.mark.parametrize("options", [(), ("--quiet",)])
def test_an_interruption_that_was_swallowed_ends_the_run_at_its_next_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    """As Python swallows one that comes while an object is destroyed."""

    def go_on(*_: object, progress: Callable[[str, int, int | None], None], **__: object) -> tuple[Path, ...]:
        progress("first", 0, None)
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        progress("second", 0, None)
        return (Path("made"),)

    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with monkeypatch.context() as patched:
            patched.setattr("blastline.run.synthesise", go_on)
            ended = blastline("synth", "scene.toml", "-o", tmp_path, *options)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert (ended.code, ended.out, "second" in ended.err) == (130, "", False)
    assert ended.err.endswith("blastline: interrupted; nothing was written\n")
    interruption.heed_interruption()  # nobody asked the program that called the command to end


@pytest.mark.skipif(sys.platform == "win32", reason="processes are ended otherwise there")
def test_an_interruption_after_all_is_done_changes_no_exit_code() -> None:
    """Python has its own way with signals back while it puts its modules away, which takes a while."""
    code = (
        "import os, signal, sys\n"
        "class Late:\n"
        "    def __del__(self, kill=os.kill, process=os.getpid(), number=signal.SIGTERM): kill(process, number)\n"
        "late = Late()\n"
        "from blastline.cli import main\n"
        "sys.argv[1:] = ['--version']\n"
        "sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, f"blastline {__version__}\n")


def require_told_interrupted(interrupting: str) -> None:
    """Show the rules, whose reading is replaced by `interrupted` of some code, and hold the end against that of one."""
    code = (
        f"import signal, sys\n{interrupting}\n"
        "from blastline.cli import main, rulefiles\n"
        "rulefiles.load_rules = interrupted\n"
        "sys.argv[1:] = ['rules', 'show']\n"
        "sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "blastline: interrupted; nothing was written\n")


@pytest.mark.skipif(sys.platform == "win32", reason="processes are ended otherwise there")
def test_python_says_nothing_of_an_interruption_that_it_swallows() -> None:
    """It would tell of an exception that it ignores, though the run ends by it."""
    require_told_interrupted(
        "class Dying:\n"
        "    def __del__(self): signal.raise_signal(signal.SIGTERM)\n"
        "def interrupted(*_):\n"
        "    Dying()\n"
        "    raise ValueError('what a library makes of it')"
    )


@pytest.mark.skipif(sys.platform == "win32", reason="processes are ended otherwise there")
@pytest.mark.parametrize("error", ["KeyboardInterrupt", "ValueError('what a library makes of it')"])
def test_a_second_request_to_end_that_comes_when_the_first_is_told_changes_nothing(error: str) -> None:
    """Until requests are ignored, each may come: here one right before that."""
    require_told_interrupted(
        "set_handler = signal.signal\n"
        "def set_late(number, handler):\n"
        "    if handler is signal.SIG_IGN: signal.raise_signal(number)\n"
        "    return set_handler(number, handler)\n"
        "signal.signal = set_late\n"
        "def interrupted(*_):\n"
        "    try: signal.raise_signal(signal.SIGTERM)\n"
        f"    except KeyboardInterrupt: raise {error}"
    )


@pytest.mark.skipif(sys.platform == "win32", reason="pipes break otherwise there")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_goes_away_ends_the_command_quietly(unbuffered: str) -> None:
    with subprocess.Popen(
        [*COMMAND, "rules", "show"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == b""
    assert process.returncode == 141


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_that_cannot_be_written_is_one_line(unbuffered: str) -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*COMMAND, "rules", "show"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        )
    assert (done.returncode, done.stderr) == (2, "blastline: input or output: No space left on device\n")


def test_rules_show_is_what_a_folder_of_ones_own_may_hold(tmp_path: Path) -> None:
    shown = blastline("rules", "show", "--quality", "draft").out
    assert shown.startswith(f"# digest {load_rules('draft').digest}\n")
    parts = re.split(r"^# (\S+\.toml)$", shown, flags=re.MULTILINE)
    for name, text in zip(parts[1::2], parts[2::2], strict=True):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert load_rules("draft", tmp_path).digest == load_rules("draft").digest
    assert blastline("rules", "check", tmp_path).out.splitlines() == [
        "align.toml",
        "conform.toml",
        "haptics.toml",
        "measuring.toml",
        "quality/draft.toml",
        "scenes.toml",
    ]


def test_rules_show_says_what_every_key_does() -> None:
    shown = blastline("rules", "show").out
    for table in re.split(r"^(?:\[\w+\]|# \S+\.toml)$", shown, flags=re.MULTILINE)[1:]:
        keys = re.findall(r"^(\w+) = ", table, flags=re.MULTILINE)
        comments = " ".join(re.findall(r"^#.*$", table, flags=re.MULTILINE))
        assert keys
        assert [key for key in keys if key not in {"schema", "source"} and f"`{key}`" not in comments] == []


def test_the_rules_of_the_documentation_are_sound(tmp_path: Path) -> None:
    text = Path(__file__).parents[1].joinpath("docs/rules.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    (tmp_path / "quality").mkdir()
    (tmp_path / "quality" / "standard.toml").write_text(example, encoding="utf-8")
    assert blastline("rules", "check", tmp_path).out == "quality/standard.toml\n"
    shown = blastline("rules", "show", "--rules", tmp_path).out.splitlines()
    assert set(example.splitlines()) <= set(shown)


def test_rules_show_has_the_users_value_and_says_where_numbers_come_from(tmp_path: Path) -> None:
    (tmp_path / "align.toml").write_text("correlation = 0.8125\n")
    shown = blastline("rules", "show", "--rules", tmp_path).out
    assert "\ncorrelation = 0.8125\n" in shown
    assert shown.count("\nsource = ") >= 10


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        (
            "quality/draft.toml",
            '[verify]\nmodel = "nothere.json"\n',
            "draft.toml: verify.model = 'nothere.json': expected the name of a file in ",
        ),
        (
            "quality/reference.toml",
            "[verify]\nnetworks = 8\n",
            "networks: expected at least 8, as",
        ),
        ("verifier/shots.json", '{"broken"', "shots.json: not a verifier model: "),
        ("verifier/other.json", "{}", "other.json: not a verifier model"),
    ],
)
def test_rules_check_refuses_what_the_next_command_would(tmp_path: Path, file: str, text: str, complaint: str) -> None:
    (tmp_path / file).parent.mkdir()
    (tmp_path / file).write_text(text)
    assert complaint in blastline("rules", "check", tmp_path).complaint  # which is all that is said: nothing is sound


def test_rules_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    (tmp_path / "align.toml").write_text("correlation = 2\n")
    expected = f"{tmp_path}/align.toml: correlation = 2: expected a number, 1 or less"
    assert blastline("rules", "check", tmp_path).complaint == expected
    assert blastline("rules", "show", "--rules", tmp_path).complaint == expected


def test_an_actuator_is_listed_and_shown(tmp_path: Path) -> None:
    listed = blastline("actuator", "list").out.splitlines()
    assert any(line.startswith("crowson-t108sm ") for line in listed)
    shown = blastline("actuator", "show", "crowson-t108sm")
    assert shown.code == 0
    rows = [[float(cell) for cell in line.split()] for line in shown.out.splitlines() if re.match(r" +[0-9.]+ ", line)]
    assert len(rows) >= 10
    assert [row[0] for row in rows] == sorted({row[0] for row in rows})
    assert "no such actuator profile" in blastline("actuator", "show", "none").complaint
    assert "not a folder" in blastline("actuator", "list", "--rules", tmp_path / "none").complaint


def test_python_m_is_the_same_command() -> None:
    assert blastline_alone("--version") == Ended(0, f"blastline {__version__}\n", "")


@pytest.mark.parametrize("module", ["typer", "blastline.run"])
@pytest.mark.parametrize("how", ["raise KeyboardInterrupt", "exec('raise KeyboardInterrupt')"])
def test_an_interruption_while_modules_are_loaded_is_told_as_any_other(module: str, how: str) -> None:
    """Python ends by the signal where the interruption came inside an exec, as it may while dataclasses are made."""
    code = (
        "import importlib.abc, runpy, sys\n"
        "class Interrupted(importlib.abc.MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        f"        if name == {module!r}: {how}\n"
        "sys.meta_path.insert(0, Interrupted())\n"
        "sys.argv[1:] = ['detect', 'film.wav']\n"
        "runpy.run_module('blastline', run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "blastline: interrupted; nothing was written\n"
