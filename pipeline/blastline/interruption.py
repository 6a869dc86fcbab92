"""Requests to end the run (Ctrl-C, SIGTERM, a closed terminal) that cannot get lost.

Python swallows an exception that is raised while an object is being destroyed, and a signal may well come there. So a
request is remembered, and heeded at the next place that asks. Libraries written in C turn it into errors of their own.
Requests often come in pairs: `timeout` asks a command and then its group, and people press Ctrl-C again. What a run
tidies up after the first is not left half-done for the second.
"""

import signal
import sys
from collections.abc import Iterator
from types import FrameType


class _Run:
    """What is remembered of a run, without a lock: one that a second request waits for is held by the first."""

    is_asked_to_end = False
    has_written = False


def let_signals_interrupt() -> None:
    """Make every request to end clean up as Ctrl-C does, but for those that whoever started us has us ignore."""
    _Run.is_asked_to_end = _Run.has_written = False
    for number in _numbers():
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def hush_swallowed() -> None:
    """Let Python say nothing of an interruption that it swallows: it is heeded soon, and told then."""
    sys.unraisablehook = _without_interruptions


def ignore_interruption() -> None:
    """Let no request to end change the exit code of a process that has nothing left to do but to end."""
    for number in _numbers():
        signal.signal(number, signal.SIG_IGN)


def is_interrupted() -> bool:
    """Return whether an end was asked for, so that what goes wrong since then may come from that."""
    return _Run.is_asked_to_end


def forget_request() -> None:
    """Forget that an end was asked for: the command has ended, but the program that called it goes on."""
    _Run.is_asked_to_end = False


def remember_written() -> None:
    """Remember that the results of the run are in place, for who is asked to end from then on."""
    _Run.has_written = True


def has_written() -> bool:
    """Return whether the results of the run are in place."""
    return _Run.has_written


def heed_interruption() -> None:
    """Raise KeyboardInterrupt where an end was asked for, though the one raised then may have been swallowed."""
    if _Run.is_asked_to_end:
        raise KeyboardInterrupt


def _numbers() -> Iterator[signal.Signals]:
    """Yield the requests to end that this system has."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None:
            yield number


def _interrupt(number: int, frame: FrameType | None) -> None:
    is_ending = _Run.is_asked_to_end and sys.exception() is not None  # the first is on its way out
    _Run.is_asked_to_end = True
    if not is_ending:
        raise KeyboardInterrupt


def _without_interruptions(swallowed: "sys.UnraisableHookArgs") -> None:
    if not (_Run.is_asked_to_end and issubclass(swallowed.exc_type, KeyboardInterrupt)):
        sys.__unraisablehook__(swallowed)
