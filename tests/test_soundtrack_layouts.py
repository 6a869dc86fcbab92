"""Films whose channels are in an order of their own: FFmpeg has a list for it that PyAV frees twice."""

import struct
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from av import AudioFrame, AudioLayout

from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.layouts import keep_list
from commands import blastline, blastline_alone
from media import impulses
from quicktime_films import film_with_layout


def by_tag(tag: int, channels: int) -> bytes:
    """Return the body of a layout of Core Audio that a tag names."""
    return bytes(4) + struct.pack(">III", tag << 16 | channels, 0, 0)


def by_labels(*labels: int) -> bytes:
    """Return the body of a layout of Core Audio with a label for each channel."""
    return bytes(4) + struct.pack(">III", 0, 0, len(labels)) + b"".join(struct.pack(">I16x", each) for each in labels)


FILM_ORDER = by_tag(123, 6)
ORDERS = {
    "110.mov": (by_tag(110, 6), "FL FR BL BR FC BC"),
    "116.mov": (by_tag(116, 4), "FC FL FR BC"),
    "122.mov": (by_tag(122, 6), "FL FR SL SR FC LFE"),
    "123.mov": (FILM_ORDER, "FL FC FR SL SR LFE"),
    "124.mov": (by_tag(124, 6), "FC FL FR SL SR LFE"),
    "127.mov": (by_tag(127, 8), "FC FLC FRC FL FR SL SR LFE"),
    "129.mov": (by_tag(129, 8), "FL FR SL SR FC LFE FLC FRC"),
    "labels.mov": (by_labels(4, 1, 2, 3), "LFE FL FR FC"),
    "positions.mp4": (bytes(4) + bytes([1, 0, 0, 2, 1, 4, 5, 3]), "FL FC FR SL SR LFE"),
}

MANY_PASSES = """
import gc, sys
from pathlib import Path
from blastline.soundtrack import open_soundtrack
for _ in range(50):
    with open_soundtrack(Path(sys.argv[1])) as track:
        frames = sum(len(clip.heard) for clip in track.blocks())
    gc.collect()
print(frames)
"""
LISTS_OF_A_DECODER = """
import av, gc, sys
from blastline.soundtrack.decode import Tally, decoded, packed
for _ in range(50):
    with av.open(sys.argv[1]) as container:
        frames = decoded(container, container.streams.audio[0], Tally())
        print(sum(len(each) for each in packed(frames, rate_hz=48_000, channels=6)))
    gc.collect()
"""


def in_a_process(script: str, film: Path) -> list[str]:
    """Return what a script says of a film, in a process of its own, which has to end well."""
    ended = subprocess.run([sys.executable, "-c", script, film], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended
    return ended.stdout.split()


@pytest.mark.parametrize("name", ORDERS)
def test_each_channel_of_a_film_is_heard_where_it_belongs(tmp_path: Path, name: str) -> None:
    """What the low-frequency channel has is not in the mains, and a centre is louder there than a side."""
    layout, order = ORDERS[name]
    weights = {"FC": 1.0, "LFE": 0.0, **dict.fromkeys(("FL", "FR", "FLC", "FRC"), 0.5**0.5)}
    sound = impulses(12_000, [6_000])
    assert in_a_process(MANY_PASSES, film_with_layout(tmp_path / name, [np.tile(sound, len(order.split()))], layout))
    for place, channel in enumerate(order.split()):
        columns = np.zeros((len(sound), len(order.split())), np.float32)
        columns[:, place] = sound[:, 0]
        with open_soundtrack(film_with_layout(tmp_path / name, [columns], layout)) as track:
            heard = np.concatenate([clip.heard for clip in track.blocks()])
        np.testing.assert_allclose(heard, weights.get(channel, 0.5) * sound[:, 0], atol=1e-6, err_msg=channel)


def test_commands_survive_a_film_in_film_order(tmp_path: Path) -> None:
    film = film_with_layout(tmp_path / "film.mov", [impulses(96_000, [30_000], channels=6)] * 2, FILM_ORDER)
    result = tmp_path / "result"
    made = blastline_alone("render", film, "-o", result, "--quality", "draft", "--stream", "1", "--no-report")
    assert made.code == 0, made
    checked = blastline_alone("check", result, "--audio", film)
    assert checked.code in (0, 1), checked
    copy = blastline_alone("conform", result, "--from", film, "--to", film, "--stream", "1", "-o", tmp_path / "copy")
    assert copy.code == 0, copy
    assert "1 (pcm_s16le, 6 channels)" in blastline("detect", film, "--stream", "2").complaint


def test_what_a_list_says_that_is_damaged_ends_no_process(tmp_path: Path) -> None:
    """Whatever is written in place of the order, the film is read, or refused in one line."""
    rng = np.random.default_rng(4)
    script = MANY_PASSES.replace("range(50)", "range(3)")
    for size in (12, 16, 40, 136):
        body = bytes(4) + bytes([0, rng.choice([0, 1, 123])]) + rng.bytes(size - 6)
        film_with_layout(tmp_path / "film.mov", [impulses(9_600, [], channels=6)], body)
        in_a_process(script, tmp_path / "film.mov")


@pytest.mark.parametrize(
    ("layout", "own_order"), [("FC+FL", True), ("LFE+FL", True), ("FL+FC", False), ("FL+FC+BC", False), ("5.1", False)]
)
def test_of_frames_only_those_in_an_order_of_their_own_are_kept_from_being_freed(layout: str, own_order: bool) -> None:
    """FFmpeg needs no list for channels in its own order: to keep those would only cost room."""
    frame = SimpleNamespace(layout=AudioLayout(layout))
    before = sys.getrefcount(frame.layout)
    keep_list(cast("AudioFrame", frame))
    kept = sys.getrefcount(frame.layout) - before
    assert kept == own_order


def test_a_list_that_a_decoder_made_itself_is_freed_once(tmp_path: Path) -> None:
    film = film_with_layout(tmp_path / "film.mov", [impulses(48_000, [], channels=6)], FILM_ORDER)
    assert set(in_a_process(LISTS_OF_A_DECODER, film)) == {"48000"}
