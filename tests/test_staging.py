"""Results appear whole or not at all, wherever a run is broken off."""

import errno
import os
import re
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from blastline.errors import OutputError
from blastline.staging import staged

NAMES = ["a.wav", "b.json", "c.csv"]


def write_all(folder: Path, text: str) -> None:
    for name in NAMES:
        (folder / name).write_text(f"{text} {name}")


def state(folder: Path) -> dict[str, str]:
    """Return every file below a folder, hidden ones too, with its text."""
    return {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}


def run_into(folder: Path, text: str = "new", *, overwrite: bool = False) -> None:
    with staged(folder, names=NAMES, overwrite=overwrite) as hidden:
        write_all(hidden, text)


def test_nothing_shows_before_the_end_and_everything_after(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "er"
    with staged(out, names=NAMES, overwrite=False) as hidden:
        write_all(hidden, "new")
        assert not [path for path in out.iterdir() if not path.name.startswith(".")]
    assert state(out) == {name: f"new {name}" for name in NAMES}
    assert len([*out.iterdir()]) == len(NAMES)


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, RuntimeError, MemoryError])
def test_a_run_that_is_broken_off_leaves_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    def broken_off() -> None:
        with staged(tmp_path / "deep" / "er", names=NAMES, overwrite=False) as hidden:
            write_all(hidden, "half")
            raise error

    with pytest.raises(error):
        broken_off()
    assert [*tmp_path.iterdir()] == []


def test_a_run_that_is_broken_off_leaves_others_files_and_folders(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "mine.txt").write_text("mine")

    def broken_off(folder: Path) -> None:
        with staged(folder, names=NAMES, overwrite=False):
            raise KeyboardInterrupt

    for folder in (tmp_path, tmp_path / "empty", tmp_path / "empty" / "new"):
        with pytest.raises(KeyboardInterrupt):
            broken_off(folder)
    assert state(tmp_path) == {"mine.txt": "mine"}
    assert [*(tmp_path / "empty").iterdir()] == []


@pytest.mark.parametrize("earlier", [[], ["b.json"], NAMES])
def test_breaking_off_while_the_files_move_puts_everything_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, earlier: list[str]
) -> None:
    """The moves are broken off before the first, after the first, and so on until a run comes through."""
    move = Path.replace
    came_through = False
    for allowed in range(20):
        out = tmp_path / str(allowed)
        out.mkdir()
        for name in earlier:
            (out / name).write_text(f"old {name}")
        left = allowed

        def some_moves(path: Path, target: Any) -> Path:
            nonlocal left
            left -= 1
            if left == -1:
                raise KeyboardInterrupt
            return move(path, target)

        with monkeypatch.context() as patch:
            patch.setattr(Path, "replace", some_moves)
            try:
                run_into(out, overwrite=True)
                came_through = True
            except KeyboardInterrupt:
                assert state(out) == {name: f"old {name}" for name in earlier}
        if came_through:
            assert allowed == len(NAMES) + len(earlier)
            assert state(out) == {name: f"new {name}" for name in NAMES}
            break
    assert came_through


def test_an_earlier_result_is_replaced_only_when_that_is_asked_for(tmp_path: Path) -> None:
    run_into(tmp_path, "first")
    with pytest.raises(OutputError, match=r"a\.wav: exists already; give --overwrite"):
        run_into(tmp_path, "second")
    assert state(tmp_path) == {name: f"first {name}" for name in NAMES}
    run_into(tmp_path, "third", overwrite=True)
    assert state(tmp_path) == {name: f"third {name}" for name in NAMES}


def test_a_file_in_the_way_of_a_folder_and_a_folder_in_the_way_of_a_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=r"file: is a file; expected a folder"):
        run_into(tmp_path / "file", overwrite=True)
    with pytest.raises(OutputError, match=r"cannot write here: Not a directory"):
        run_into(tmp_path / "file" / "deeper", overwrite=True)
    (tmp_path / "out" / "b.json").mkdir(parents=True)
    (tmp_path / "out" / "b.json" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"b\.json: is a folder; expected the name of a file"):
        run_into(tmp_path / "out", overwrite=True)
    assert state(tmp_path) == {"file": "mine", "out/b.json/mine.txt": "mine"}


def test_a_full_disk_is_told_with_the_files_final_name(tmp_path: Path) -> None:
    def full() -> None:
        with staged(tmp_path / "out", names=NAMES, overwrite=False) as hidden:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(hidden / "a.wav"))

    with pytest.raises(OutputError, match=r"out/a\.wav: cannot write: No space left on device$"):
        full()
    assert [*tmp_path.iterdir()] == []


def test_a_name_that_is_too_long_is_told_before_the_work_begins(tmp_path: Path) -> None:
    name = "x" * 300
    with (
        pytest.raises(OutputError, match=f"^{re.escape(str(tmp_path / name))}: cannot write: .*[Tt]oo long"),
        staged(tmp_path, names=["a.wav", name], overwrite=True),
    ):
        pytest.fail("the work began")
    assert [*tmp_path.iterdir()] == []


def test_an_error_of_reading_is_not_told_as_one_of_writing(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), staged(tmp_path, names=NAMES, overwrite=False):
        (tmp_path / "film.mkv").read_bytes()


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_must_not_be_written_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match=r"cannot write here: Permission denied"):
        run_into(tmp_path / "out")


REELS = ("reel-1.haptic", "reel-2.haptic", "reel-3.haptic")


def reels_into(folder: Path, count: int, text: str, *, overwrite: bool = False) -> None:
    with staged(folder, names=["index.csv"], sets=["reel-*.haptic"], overwrite=overwrite) as hidden:
        for name in ("index.csv", *REELS[:count]):
            (hidden / name).write_text(f"{text} {name}")


def test_of_a_set_nothing_stays_that_an_earlier_run_left(tmp_path: Path) -> None:
    reels_into(tmp_path, 3, "first")
    (tmp_path / "reel.haptic").write_text("mine")
    reels_into(tmp_path, 1, "second", overwrite=True)
    assert state(tmp_path) == {
        "index.csv": "second index.csv",
        "reel-1.haptic": "second reel-1.haptic",
        "reel.haptic": "mine",
    }


def test_any_file_of_a_set_is_an_earlier_result(tmp_path: Path) -> None:
    (tmp_path / "reel-9.haptic").write_text("mine")
    with pytest.raises(OutputError, match=r"reel-9\.haptic: exists already; give --overwrite"):
        reels_into(tmp_path, 1, "second")
    assert state(tmp_path) == {"reel-9.haptic": "mine"}


def test_a_star_in_a_name_is_no_pattern(tmp_path: Path) -> None:
    (tmp_path / "found-mine.json").write_text("mine")
    with staged(tmp_path, names=["found*.json"], overwrite=True) as hidden:
        (hidden / "found*.json").write_text("new")
    assert state(tmp_path) == {"found-mine.json": "mine", "found*.json": "new"}


@pytest.mark.parametrize("allowed", range(8))
def test_a_set_that_cannot_be_replaced_whole_stays_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, allowed: int
) -> None:
    """Whichever move fails, what there was before is there again: four put the new in place, two clear away."""
    reels_into(tmp_path, 3, "first")
    before = state(tmp_path)
    replace, moves = Path.replace, 0

    def failing(self: Path, target: Path) -> Path:
        nonlocal moves
        moves += 1
        if moves == allowed + 1:
            raise OSError(errno.EIO, os.strerror(errno.EIO), str(self))
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", failing)
    if allowed < 6:
        with pytest.raises(OSError, match="Input/output error"):
            reels_into(tmp_path, 1, "second", overwrite=True)
        assert state(tmp_path) == before
    else:
        reels_into(tmp_path, 1, "second", overwrite=True)
        assert "reel-2.haptic" not in state(tmp_path)


@pytest.mark.parametrize("overwrite", [False, True])
def test_the_film_is_never_replaced(tmp_path: Path, overwrite: bool) -> None:
    film = tmp_path / "film.wav"
    film.write_text("film")
    os.link(film, tmp_path / "b.json")
    with (
        pytest.raises(OutputError, match=r"b\.json: is the film itself; choose another"),
        staged(tmp_path, names=NAMES, films=[film], overwrite=overwrite),
    ):
        pass
    assert state(tmp_path) == {"film.wav": "film", "b.json": "film"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes and links")
@pytest.mark.parametrize("overwrite", [False, True])
def test_what_is_no_regular_file_is_never_replaced(tmp_path: Path, overwrite: bool) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "link").symlink_to("mine")
    (tmp_path / "lost").symlink_to("nowhere")
    for name, what in (("pipe", "a pipe, a device or the like"), ("link", "a link"), ("lost", "a link")):
        with (
            pytest.raises(OutputError, match=f"{name}: is {what}; expected the name of a regular file to write"),
            staged(tmp_path, names=[name], overwrite=overwrite),
        ):
            pass
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "lost").is_symlink()
    assert len([*tmp_path.iterdir()]) == 4


def test_of_two_runs_at_once_the_first_to_end_stays_whole(tmp_path: Path) -> None:
    def second() -> None:
        with staged(tmp_path, names=NAMES, overwrite=False) as hidden:
            write_all(hidden, "second")
            run_into(tmp_path, "first")

    with pytest.raises(OutputError, match=r"a\.wav: exists already; give --overwrite"):
        second()
    assert state(tmp_path) == {name: f"first {name}" for name in NAMES}
    assert len([*tmp_path.iterdir()]) == len(NAMES)


def test_a_file_of_a_set_that_came_meanwhile_is_an_earlier_result(tmp_path: Path) -> None:
    def second() -> None:
        with staged(tmp_path, names=["index.csv"], sets=["reel-*.haptic"], overwrite=False) as hidden:
            (hidden / "index.csv").write_text("second")
            (tmp_path / "reel-1.haptic").write_text("mine")

    with pytest.raises(OutputError, match=r"reel-1\.haptic: exists already"):
        second()
    assert state(tmp_path) == {"reel-1.haptic": "mine"}


def test_two_runs_do_not_move_their_files_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second begins to move while the first has moved one of three: it waits, and replaces all or nothing."""
    replace, begun = Path.replace, threading.Event()

    def slowly(self: Path, target: Path) -> Path:
        begun.set()
        time.sleep(0.05)
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", slowly)
    first = threading.Thread(target=run_into, args=(tmp_path, "first"), kwargs={"overwrite": True})
    first.start()
    assert begun.wait(10.0)
    run_into(tmp_path, "second", overwrite=True)
    first.join()
    assert state(tmp_path) == {name: f"second {name}" for name in NAMES}


def test_a_run_that_never_ends_moving_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("blastline.moving._LONGEST_WAIT_S", 0.05)
    monkeypatch.setattr("blastline.moving.hold", lambda _: None)  # as of a lock that another run holds
    (tmp_path / ".blastline-moving").mkdir()
    with pytest.raises(OutputError, match=r"\.blastline-moving: another run is writing here; remove it"):
        run_into(tmp_path)
    assert state(tmp_path) == {}


def test_a_full_disk_that_names_no_file_is_told_with_the_one_written_last(tmp_path: Path) -> None:
    def full(names: list[str], *written: str) -> None:
        with staged(tmp_path, names=names, overwrite=False) as hidden:
            for number, name in enumerate(written):
                (hidden / name).write_text("half")
                os.utime(hidden / name, (number, number))
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    for names, written in (([*NAMES], ["a.wav", "b.json"]), (["b.json"], [])):
        with pytest.raises(OutputError) as raised:
            full(names, *written)
        assert str(raised.value) == f"{tmp_path / 'b.json'}: cannot write: No space left on device"


def test_the_hidden_name_is_never_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    def refused(folder: Path) -> None:
        with staged(folder, names=NAMES, overwrite=False) as hidden:
            raise OutputError(f"{hidden / 'a.wav'}: cannot write the drive")

    for folder in (Path(), Path("out"), tmp_path):
        with pytest.raises(OutputError) as raised:
            refused(folder)
        assert str(raised.value) == f"{folder / 'a.wav'}: cannot write the drive"


def test_what_an_earlier_run_left_goes_when_it_is_overwritten_and_nothing_else(tmp_path: Path) -> None:
    """An earlier run's other files are in the way; the film, what is spared, and what is no file are not, and stay."""
    for name in ("x.otio", "edited.otio", "film.otio", "notes.txt", "reel-1.haptic"):
        (tmp_path / name).write_text("earlier")
    (tmp_path / "folder.otio").mkdir()
    kept = {"film.otio": "earlier", "edited.otio": "earlier", "notes.txt": "earlier"}
    before = state(tmp_path)

    def run(*, overwrite: bool) -> None:
        with staged(
            tmp_path,
            names=["new.json"],
            stale=["*.otio", "reel-*.haptic", "none.csv"],
            films=[tmp_path / "film.otio"],
            spared=[tmp_path / "edited.otio"],
            overwrite=overwrite,
        ) as hidden:
            (hidden / "new.json").write_text("new")

    with pytest.raises(OutputError, match=r"reel-1\.haptic: exists already, from another run; give --overwrite"):
        run(overwrite=False)
    assert state(tmp_path) == before
    run(overwrite=True)
    (tmp_path / "new.json").unlink()
    assert state(tmp_path) == kept
    assert (tmp_path / "folder.otio").is_dir()
    run(overwrite=False)


def test_what_another_run_leaves_meanwhile_is_in_the_way(tmp_path: Path) -> None:
    def run() -> None:
        with staged(tmp_path, names=["new.json"], stale=["*.otio"], overwrite=False) as hidden:
            (hidden / "new.json").write_text("new")
            (tmp_path / "x.otio").write_text("other")

    with pytest.raises(OutputError, match=r"x\.otio: exists already"):
        run()
    assert state(tmp_path) == {"x.otio": "other"}
