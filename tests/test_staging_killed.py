"""What a killed run leaves: no seal of a result that is not whole, and nothing that the next run cannot clear away."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from blastline import abandoned
from blastline.errors import OutputError
from blastline.interruption import let_signals_interrupt
from blastline.moving import alone_in
from blastline.staging import staged
from moments import moments, shown

pytestmark = pytest.mark.skipif(os.name != "posix", reason="no locks that end with their process")

SEAL = "m.json"
EARLIER, LATER = ("a.wav", SEAL, "reel-1.x", "reel-2.x", "z.mid"), ("a.wav", SEAL, "reel-1.x", "z.vtt")
"""The files of two runs: sorted by name, the seal is neither the first nor the last."""


def run_into(folder: Path, text: str, files: tuple[str, ...] = LATER) -> None:
    """Write files into a folder, which take the place of whatever an earlier run wrote."""
    names, stale = [name for name in files if "reel" not in name], ["z.*"]
    with staged(folder, names=names, sets=["reel-*.x"], stale=stale, seal=SEAL, overwrite=True) as hidden:
        for name in files:
            (hidden / name).write_text(f"{text} {name}")


def whole(text: str, files: tuple[str, ...] = LATER) -> dict[str, bytes]:
    return {name: f"{text} {name}".encode() for name in files}


@pytest.mark.parametrize("earlier", [{}, whole("earlier", EARLIER)], ids=["alone", "over another"])
def test_a_seal_never_stands_beside_files_of_another_run_or_without_its_own(
    tmp_path: Path, earlier: dict[str, bytes]
) -> None:
    """Whenever a run is killed, while files move or, after Ctrl-C, go back; and when Ctrl-C comes a second time."""
    for first in range(12):
        for second in range(first + 1, 2 * first + 3):
            out = tmp_path / f"{first}-{second}"
            if earlier:
                run_into(out, "earlier", EARLIER)
            with moments(out, broken_off=(first, second)) as seen, suppress(KeyboardInterrupt):
                run_into(out, "later")
            sealed = [files for files in seen if SEAL in files]
            assert [files for files in sealed if files not in (earlier, whole("later"))] == []
            everywhere = {path.read_bytes() for path in out.rglob("*") if path.is_file()}
            assert shown(out) == whole("later") or everywhere >= set(earlier.values()), "an earlier file is lost"
    assert shown(out) == whole("later"), "not every move was broken off"


@pytest.mark.parametrize("first", range(9))
def test_an_earlier_result_that_could_not_be_put_back_is_not_thrown_away(tmp_path: Path, first: int) -> None:
    run_into(tmp_path, "earlier", EARLIER)
    with moments(tmp_path, broken_off=(first, first + 1)) as seen, pytest.raises(KeyboardInterrupt):
        run_into(tmp_path, "later")
    missing = whole("earlier", EARLIER).items() - seen[-1].items()
    run_into(tmp_path, "third")
    assert shown(tmp_path) == whole("third")
    assert {(path.name, path.read_bytes()) for path in tmp_path.glob(".blastline-*/earlier-*/*")} == missing
    assert bool(missing) == (first > 0)


KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from blastline.staging import staged

def kill(*_, **__):
    os.kill(os.getpid(), signal.SIGKILL)

def replace_last(path, target, replace=Path.replace):
    replace(path, target)
    kill()

folder, at = Path(sys.argv[1]), sys.argv[2]
with staged(folder, names=["a.wav"], overwrite=True) as hidden:
    if at == "listening":
        kill()
    (hidden / "a.wav").write_text("half")
    if at == "writing":
        kill()
    if at == "moving":
        Path.replace = replace_last
    shutil.rmtree = kill
"""


@pytest.mark.parametrize("at", ["listening", "writing", "moving", "clearing"])
def test_what_a_killed_run_left_goes_with_the_next_even_at_once(tmp_path: Path, at: str) -> None:
    if at == "clearing":  # its files are in place, and the earlier ones of no use
        (tmp_path / "a.wav").write_text("earlier")
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path), at], check=False)
    assert [path.name for path in tmp_path.glob(".blastline-*")]
    if at == "moving":
        os.utime(tmp_path / ".blastline-moving", (1e9, 1e9))  # or the next would wait for it
    run_into(tmp_path, "next")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(LATER)


def test_what_a_living_run_writes_stays(tmp_path: Path) -> None:
    """Whether it has written something yet or not."""
    with staged(tmp_path, names=["b.wav"], overwrite=True) as living:
        run_into(tmp_path, "second")
        assert living.exists()
        (living / "b.wav").write_text("first")
        run_into(tmp_path, "third")
    assert shown(tmp_path) == whole("third") | {"b.wav": b"first"}


@pytest.mark.parametrize("takes_s", [0.0, 0.2])
def test_a_folder_that_another_run_clears_before_it_is_held_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, takes_s: float
) -> None:
    """The other run has done so at once, or holds the folder for a while before it removes it."""
    make, made = tempfile.mkdtemp, list[Path]()

    def clear(folder: Path, held: int | None) -> None:
        time.sleep(takes_s)
        folder.rmdir()
        assert held is not None
        os.close(held)

    def make_and_lose_the_first(**given: Any) -> str:
        made.append(Path(make(**given)))
        if len(made) == 1:
            clearing = threading.Thread(target=clear, args=(made[0], abandoned.hold(made[0])))
            clearing.start()
            if takes_s == 0.0:
                clearing.join()
        return str(made[-1])

    with monkeypatch.context() as patch:
        patch.setattr("blastline.abandoned.tempfile.mkdtemp", make_and_lose_the_first)
        hidden, held = abandoned.held_folder(tmp_path)
    assert [hidden] == made[1:]
    abandoned.clear_abandoned(tmp_path)
    assert [*tmp_path.iterdir()] == [hidden]
    assert held is not None
    os.close(held)
    abandoned.clear_abandoned(tmp_path)
    assert [*tmp_path.iterdir()] == []


MOVING = """
import os, sys
from pathlib import Path
from blastline.moving import alone_in
with alone_in(Path(sys.argv[1])):
    os.utime(Path(sys.argv[1]) / ".blastline-moving", (1e9, 1e9))
    print("moving", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("is_new", [True, False])
def test_a_run_that_was_killed_while_it_moved_its_files_hinders_none(tmp_path: Path, is_new: bool) -> None:
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", MOVING, str(tmp_path)], **pipes) as moving:
        assert moving.stdout is not None
        assert moving.stdout.readline() == b"moving\n"
        with pytest.raises(OutputError, match="another run is writing here"):
            run_into(tmp_path, "next")
        moving.kill()
    if is_new:
        run_into(tmp_path, "next")
    else:  # it was killed only after this run had begun
        with alone_in(tmp_path):
            pass
    assert not (tmp_path / ".blastline-moving").exists()


def test_earlier_results_in_what_a_killed_run_left_stay(tmp_path: Path) -> None:
    left = tmp_path / ".blastline-left"
    (left / "earlier-1").mkdir(parents=True)
    (left / "earlier-1" / "a.wav").write_text("mine")
    run_into(tmp_path, "next")
    assert (left / "earlier-1" / "a.wav").read_text() == "mine"


@pytest.fixture
def asked_to_end() -> Iterator[Callable[[], None]]:
    """Return what asks the run to end, as `timeout` does; the process listens meanwhile as the command does."""
    heeded = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, signal.SIG_DFL) for number in heeded}
    let_signals_interrupt()
    yield lambda: signal.raise_signal(signal.SIGTERM)
    let_signals_interrupt()  # forget it
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_second_request_to_end_does_not_disturb_what_is_tidied_up_after_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked_to_end: Callable[[], None]
) -> None:
    """`timeout` asks twice, and so does who presses Ctrl-C again."""

    def asked_again(self: Path, target: Path) -> Path:
        moved = real_replace(self, target)
        asked_to_end()
        return moved

    def removed(*words: Any, **options: Any) -> None:
        asked_to_end()
        real_remove(*words, **options)

    run_into(tmp_path / "out", "earlier", EARLIER)
    real_replace, real_remove = Path.replace, shutil.rmtree
    monkeypatch.setattr(Path, "replace", asked_again)
    monkeypatch.setattr("blastline.staging.shutil.rmtree", removed)
    with pytest.raises(KeyboardInterrupt):
        run_into(tmp_path / "out", "later")
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == whole("earlier", EARLIER)


def test_a_request_to_end_that_comes_when_all_is_in_place_leaves_nothing_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked_to_end: Callable[[], None]
) -> None:
    def removed(*words: Any, **options: Any) -> None:
        asked_to_end()
        real_remove(*words, **options)

    real_remove = shutil.rmtree
    monkeypatch.setattr("blastline.staging.shutil.rmtree", removed)
    with pytest.raises(KeyboardInterrupt):
        run_into(tmp_path / "out", "later")
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == whole("later")
