"""Requests to end the run: one that comes at any moment of another's is heeded, and waits for nothing."""

import subprocess
import sys

import pytest

ASKED_AGAIN = """
import os, signal, sys
from blastline import interruption

interruption.let_signals_interrupt()
lines = int(sys.argv[1])

def ask_again(frame, event, argument):
    global lines
    if event == "line":
        lines -= 1
        if lines == 0:
            os.kill(os.getpid(), signal.SIGTERM)
    return ask_again

sys.settrace(ask_again)
try:
    os.kill(os.getpid(), signal.SIGTERM)
    for _ in range(1000):
        pass
except KeyboardInterrupt:
    sys.settrace(None)
    print("ended", interruption.is_interrupted())
"""


@pytest.mark.parametrize("lines", range(1, 13))
def test_a_request_to_end_amid_another_waits_for_nothing(lines: int) -> None:
    command = [sys.executable, "-c", ASKED_AGAIN, str(lines)]
    ended = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stdout) == (0, "ended True\n"), ended.stderr
