"""Streams of one channel each with titles or names: as which channels they are joined, and what is told of them."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from blastline.errors import SoundtrackError
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.singles import layout_of
from blastline.soundtrack.titles import channel_of, titled_layout
from blastline.streams import parse_streams
from media import RATE_HZ, impulses, write_media
from single_films import SIX, Single, apart, different, heard, write_singles

USUAL = ("FL", "FR", "FC", "LFE", "SL", "SR")
FILM_ORDER = (0, 2, 1, 4, 5, 3)
"""Where channels of the usual order are among L C R Ls Rs LFE."""

MIXED = ("mains", "all", "lfe", "center")


@pytest.mark.parametrize(
    "titles",
    [
        ("L", "R", "C", "LFE", "Ls", "Rs"),
        ("left", "RIGHT", "Centre", "Sub", "Surround Left", "right surround"),
        ("FL", "FR", "FC", "LFE", "SL", "SR"),
        ("Front Left", "Front-Right", "front_center", "Low Frequency Effects", "Side Left", "Side Right"),
    ],
)
@pytest.mark.parametrize(("codec", "extension"), [("pcm_s16le", "mov"), ("pcm_s24le", "mkv"), ("alac", "mp4")])
def test_titles_say_which_channels_streams_are(
    tmp_path: Path, titles: Sequence[str], codec: str, extension: str
) -> None:
    """In an order that is not the usual one the sound is the same as where they lie in that."""
    film, write = different(), partial(write_media, codec=codec)
    usual = write(tmp_path / f"usual.{extension}", apart(film))
    shuffled = [titles[place] for place in FILM_ORDER]
    titled = write(tmp_path / f"titled.{extension}", apart(film[:, list(FILM_ORDER)]), titles=shuffled)
    for mix in MIXED:
        assert np.array_equal(heard(titled, stream=SIX, mix=mix)[0], heard(usual, stream=SIX, mix=mix)[0])
    # of the first three left and right, and the centre, are known; without titles nobody would guess
    front = film * np.isin(np.arange(6), (0, 1, 2))
    expected = heard(write(tmp_path / f"front.{extension}", apart(front)), stream=SIX)[0]
    assert np.array_equal(heard(titled, stream=(0, 1, 2))[0], expected)


@pytest.mark.parametrize(
    ("titles", "layout"),
    [
        (("Left", "Right"), ("FL", "FR")),
        (("R", "L"), ("FR", "FL")),
        (("L", "R", "C", "Ls", "Rs"), ("FL", "FR", "FC", "SL", "SR")),
        (("L", "R", "C", "LFE", "Ls", "Rs", "Lt", "Rt"), (*USUAL, "DL", "DR")),
        (("L", "R", "C", "LFE", "Ls", "Rs", "Lrs", "Rrs"), (*USUAL, "BL", "BR")),
        (("L", "R", "Ls", "Rs", "Cs"), ("FL", "FR", "SL", "SR", "BC")),
        (("L", "R", "C", "LFE", "Ls"), ()),  # one is missing
        (("L", "R", "L"), ()),
        (("C", "LFE"), ()),
        (("Lt", "Rt"), ("DL", "DR")),
        (("C", "Lt", "Rt"), ()),
        (("L", "R", "C", "LFE", "Ls", "Dialogue"), ()),
        (("English", "Français"), ()),
        ((None, ""), ()),
        ((), ()),
    ],
)
def test_titles_that_make_no_whole_layout_name_none(titles: Sequence[str | None], layout: Sequence[str]) -> None:
    assert titled_layout(titles) == layout


def test_a_title_is_that_of_one_channel_at_most() -> None:
    for side, other in (("Left", "Right"), ("Right", "Left")):
        for title in ("{}", "Front {}", "{} Surround", "Rear {}", "{} Center", "{} total", "Side {}"):
            here, there = channel_of(title.format(side)), channel_of(title.format(other).upper())
            assert here is not None
            assert there is not None
            assert here.replace(side[0], other[0]) == there
    assert all(channel_of(title) is None for title in ("S", "M&E", "Stereo", "Mono", "LR", "Left Right", "5.1", "A1"))


def test_what_the_file_says_of_its_channels_comes_before_titles() -> None:
    mono, titles = ("FC",), ("R", "L", "C", "LFE", "Ls", "Rs")
    assert layout_of([(name,) for name in USUAL], titles) == USUAL
    assert layout_of([None, None, mono, mono, mono, mono], titles)[:2] == ("FR", "FL")
    assert layout_of([("FL",), mono, mono, mono, mono, mono], titles) == ()


@pytest.mark.parametrize("titles", [("L", "C", "R", "Ls", "Rs", "Boom"), ("", "", "", "Ls", "Rs", "LFE")])
def test_titles_that_contradict_the_usual_order_leave_nothing_to_guess(tmp_path: Path, titles: Sequence[str]) -> None:
    path = write_media(tmp_path / "film.mkv", apart(different(2_000)), codec="pcm_s16le", titles=titles)
    for mix in MIXED:
        with pytest.raises(SoundtrackError, match="does not say what its 6 channels are; choose channels by number"):
            open_soundtrack(path, stream=SIX, mix=mix)
    assert heard(path, stream=SIX, mix="0,1")[0].shape[0] == 2_000


def test_titles_of_something_else_change_nothing(tmp_path: Path) -> None:
    film = different(2_000)
    plain = write_media(tmp_path / "plain.mkv", apart(film), codec="pcm_s16le")
    titles = ("L", "R", "Dialogue", "Boom", "Music 1", "Music 2")
    titled = write_media(tmp_path / "titled.mkv", apart(film), codec="pcm_s16le", titles=titles)
    assert np.array_equal(heard(titled, stream=SIX)[0], heard(plain, stream=SIX)[0])


def untitled(path: Path, count: int) -> Path:
    return write_media(path, [impulses(2_000, [500])] * count, codec="pcm_s16le")


def titled(path: Path, count: int, *, titles: Sequence[str]) -> Path:
    return write_media(path, [impulses(2_000, [500])] * count, codec="pcm_s16le", titles=titles[:count])


def named(path: Path, count: int, *, names: Sequence[str]) -> Path:
    sound = impulses(2_000, [500])
    return write_singles(path, *(Single(sound, channel=name) for name in (*names, *["FC"] * count)[:count]))


KINDS: dict[str, Callable[[Path, int], Path]] = {
    "untitled": untitled,
    "titled": partial(titled, titles=("L", "R", "C", "LFE", "Ls", "Rs", "Lrs", "Rrs")),
    "in film order": partial(titled, titles=("L", "C", "R", "Ls", "Rs", "LFE", "Lt", "Rt")),
    "titled otherwise": partial(titled, titles=("Boom", "LFE", "Dialogue", "Ls")),
    "named": partial(named, names=(*USUAL, "BL", "BR")),
    "named in pairs": partial(named, names=("FL", "FR") * 8),
    "a stereo mix behind": partial(named, names=(*USUAL, "FL", "FR")),
    "titled total": partial(titled, titles=("Lt", "Rt", "L", "R")),
    "left and right total": partial(named, names=("DL", "DR")),
    "all left": partial(named, names=("FL",) * 16),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", range(2, 17))
def test_what_the_hint_says_to_type_works(tmp_path: Path, kind: str, count: int) -> None:
    path = KINDS[kind](tmp_path / "film.mov", count)
    [warning] = heard(path, stream=None)[1].warnings
    assert warning.startswith(f"only sound stream 0 of {count} with one channel each is heard: --stream 0-")
    asked = re.findall(r"--stream (\S+)(?: --mix (\S+))? joins (\d+) ", warning)
    assert asked
    for streams, mix, joined in asked:
        found, source = heard(path, stream=parse_streams(streams), mix=mix or "mains")
        assert source.channels == int(joined)
        assert np.any(found)
        assert source.warnings == ()


def test_the_hint_calls_a_layout_by_its_name_or_its_channels(tmp_path: Path) -> None:
    for kind, count, told in (
        ("in film order", 8, "--stream 0-5 joins 6 as 5.1, --stream 0-7 joins 8 as FL FC FR SL SR LFE DL DR; "),
        ("named", 5, "--stream 0-4 joins 5 as FL FR FC LFE SL; "),
        ("a stereo mix behind", 8, "--stream 0-5 joins 6 as 5.1; "),
        ("all left", 3, "--stream 0-2 --mix 0,1,2 joins 3 and hears their mean; "),
    ):
        assert told in heard(KINDS[kind](tmp_path / "film.mov", count), stream=None)[1].warnings[0]


def test_streams_at_another_rate_or_from_another_moment_on_are_not_said_to_go_along(tmp_path: Path) -> None:
    sound = impulses(20_000, [100])
    others = (Single(sound, rate_hz=44_100), Single(sound, start_s=0.5))
    path = write_singles(tmp_path / "film.mov", Single(sound), others[0], Single(sound), others[1])
    [warning] = heard(path, stream=None)[1].warnings
    assert "only sound stream 0 of 2 with one channel each is heard: --stream 0,2 joins 2 as stereo; " in warning
    assert heard(path, stream=(0, 2))[1].sample_rate_hz == RATE_HZ
    alone = write_singles(tmp_path / "alone.mov", Single(sound), others[0])
    assert heard(alone, stream=None)[1].warnings == ()
