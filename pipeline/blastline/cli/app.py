"""The commands put together, and what becomes of an error.

Exit codes
    0 done, all checks passed    1 done, a check failed    2 unusable input, rules or arguments
    70 a bug of blastline        130 interrupted           141 whoever read the output closed it
"""

import io
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated

import typer

from .. import __version__
from ..errors import BlastlineError
from ..interruption import (
    forget_request,
    hush_swallowed,
    ignore_interruption,
    is_interrupted,
    let_signals_interrupt,
)
from . import actuators, conform, film, results, rulefiles, study, synthesis
from .complaints import complaint
from .interruption import INTERRUPTED, told_interrupted

USAGE, BUG, CLOSED_PIPE = 2, 70, 141
_UNMAPPED = "failed to map segment"  # what the loader says of a library for which there is no memory

app = typer.Typer(
    name="blastline",
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(film.render)
app.command()(film.detect)
app.command()(results.check)
app.command()(results.export)
app.command()(results.formats)
app.command()(conform.conform)
app.add_typer(actuators.group, name="actuator")
app.add_typer(rulefiles.group, name="rules")
app.command()(synthesis.synth)
app.add_typer(study.group, name="study")


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"blastline {__version__}")
        raise typer.Exit


@app.callback()
def describe(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Find the gunshots of a film's soundtrack and render an aligned vibration drive for 4D cinema.

    Start with `blastline render film.mkv -o result`.
    """


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; what a user can mend is one line on stderr.

    Without `arguments` it is that of the process, which ends then.
    """
    try:
        let_signals_interrupt()
        if arguments is None:
            hush_swallowed()
        _make_output_whole()
        _spell_out_what_has_no_letter()
        words = (sys.argv[1:] if arguments is None else arguments) or ["--help"]
        code = app(words, prog_name="blastline", standalone_mode=False) or 0
        if arguments is None:
            ignore_interruption()  # here as well: a request right before it is still told
    except BaseException as error:
        if arguments is None and is_interrupted():  # while this one is on its way out, no other is raised
            ignore_interruption()
        code = _code_of(error)
    if arguments is None:
        ignore_interruption()
    else:
        forget_request()
    return told_interrupted() if code == INTERRUPTED else code


def _code_of(error: BaseException) -> int:
    """Return the exit code of a run that ended by an error, which is told unless an end was asked for."""
    if isinstance(error, BrokenPipeError | SystemExit):  # typer turns the first into the second
        _drop_unwritten_output()
        return CLOSED_PIPE
    if is_interrupted() or not isinstance(error, Exception):
        return INTERRUPTED
    return _told(error)


def _told(error: Exception) -> int:
    """Say what went wrong and return its exit code."""
    if isinstance(error, typer.TyperException):
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "blastline"
        return _say(f"{complaint(error)} (see `{command} --help`)", USAGE)
    if isinstance(error, BlastlineError):
        return _say(str(error), USAGE)
    if isinstance(error, OSError):
        _drop_unwritten_output()
        return _say(f"{error.filename or 'input or output'}: {error.strerror or error}", USAGE)
    if isinstance(error, MemoryError) or (isinstance(error, ImportError) and _UNMAPPED in str(error)):
        return _say("there is not enough memory", USAGE)
    traceback.print_exception(error)
    return _say("this is a bug of blastline; please report it with the lines above", BUG)


def _say(message: str, code: int) -> int:
    with suppress(OSError):  # where nobody can be told, the exit code still tells
        typer.echo("blastline: " + " ".join(message.splitlines()), err=True)
    return code


def _make_output_whole() -> None:
    """Let standard output write all of what it is given, or fail: without a buffer (`python -u`) it may write a part.

    A full disk takes what it has room for.
    """
    raw = getattr(sys.stdout, "buffer", None)
    if isinstance(sys.stdout, io.TextIOWrapper) and isinstance(raw, io.RawIOBase):
        encoding, errors = sys.stdout.encoding, sys.stdout.errors
        sys.stdout.detach()
        sys.stdout = io.TextIOWrapper(io.BufferedWriter(raw), encoding=encoding, errors=errors, line_buffering=True)


def _spell_out_what_has_no_letter() -> None:
    """Let standard output write `\\u05e9` for a letter that its alphabet lacks, as Python has standard error do."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")


def _drop_unwritten_output() -> None:
    """Let Python not try again at its end what cannot be written: it would end with 120 instead of our exit code."""
    try:
        sys.stdout.flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
