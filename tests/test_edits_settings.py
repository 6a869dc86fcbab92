"""An edited timeline that is rendered with other options than the first time says so."""

from pathlib import Path

import numpy as np
import pytest
import soundfile

from commands import blastline
from edited_films import edited_film, first_result, rendered

SEAT = Path(__file__).parent.parent / "rules" / "actuators" / "crowson-t108sm.toml"
TOLD = "note: other options than the "


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return edited_film(tmp_path_factory.mktemp("film"))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, film: Path) -> Path:
    return first_result(tmp_path_factory.mktemp("result"), film)


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [
        ("--level", "6", "--level 6 (there 0)"),
        ("--background", "direct", "--background direct (there mute)"),
        ("--phase", "zero", "--phase zero (there causal)"),
        ("--quality", "draft", "--quality draft (there standard)"),
    ],
)
def test_an_option_that_is_another_than_the_originals_is_told(
    tmp_path: Path, film: Path, result: Path, option: str, value: str, told: str
) -> None:
    (tmp_path / "edited.csv").write_text((result / "timeline.csv").read_text())
    asked = (film, tmp_path / "edited.csv", "--original", result)
    ended, _, _ = rendered(*asked, option, value)
    assert f"{TOLD}original was made with: {told}\n" in ended.err
    again = tmp_path / "out" / "timeline.json"
    assert TOLD not in rendered(film, again, option, value)[0].err
    backwards = told.split()
    assert f"{TOLD}timeline was made with: {option} {backwards[3][:-1]} (there {backwards[1]})\n" in (
        rendered(film, again)[0].err
    )


def test_another_seat_and_other_rules_are_told_by_their_options(tmp_path: Path, film: Path, result: Path) -> None:
    seat = SEAT.read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(seat.replace('name = "crowson-t108sm"', 'name = "mine"'), encoding="utf-8")
    (tmp_path / "rules" / "quality").mkdir(parents=True)
    (tmp_path / "rules" / "quality" / "standard.toml").write_text("[windows]\nfade_out_ms = 30\n")
    (tmp_path / "edited.csv").write_text((result / "timeline.csv").read_text())
    asked = (film, tmp_path / "edited.csv", "--original", result)
    ended = rendered(*asked, "--actuator", tmp_path / "mine.toml", "--rules", tmp_path / "rules")[0]
    told = "--actuator mine (there crowson-t108sm), --rules (there others)"
    assert f"{TOLD}original was made with: {told}\n" in ended.err


def test_of_the_same_options_nothing_is_told(tmp_path: Path, film: Path, result: Path) -> None:
    (tmp_path / "edited.csv").write_text((result / "timeline.csv").read_text())
    asked = (film, tmp_path / "edited.csv", "--original", result)
    assert TOLD not in rendered(*asked)[0].err
    assert TOLD not in rendered(*asked, "--level", "6", "--quiet")[0].err


def test_a_timeline_without_a_drive_was_made_with_no_options_of_one(tmp_path: Path, film: Path) -> None:
    """`detect` asks nothing of a drive; what was asked of one, before the film was cut anew, is told."""
    found = tmp_path / "found.json"
    assert blastline("detect", film, "-o", found, "--quality", "draft").code == 0
    told = rendered(film, found, "--level", "6", "--phase", "zero")[0].err
    assert f"{TOLD}timeline was made with: --quality standard (there draft)\n" in told
    found.write_text(found.read_text().replace('"phase": "causal"', '"phase": "zero"'))
    told = rendered(film, found, "--level", "6", "--quality", "draft")[0].err
    assert f"{TOLD}timeline was made with: --phase causal (there zero)\n" in told


@pytest.mark.parametrize(("first", "again"), [("1,0", "0,1"), ("0,1", "1, 0"), ("01,0", "0,1")])
def test_the_same_channels_in_another_order_are_the_same_mix(
    tmp_path: Path, film: Path, result: Path, first: str, again: str
) -> None:
    """A timeline from before mixes had an order in which they are written down is read as well."""
    samples, rate_hz = soundfile.read(film, dtype="int16")
    stereo = tmp_path / "stereo.wav"
    soundfile.write(stereo, np.stack([samples, samples // 2, 0 * samples], axis=1), rate_hz)
    (tmp_path / "edited.csv").write_text(table(result))
    _, made, drive = rendered(stereo, tmp_path / "edited.csv", "--mix", first)
    out = tmp_path / "out" / "timeline.json"
    assert made.source.mix == "0,1"
    assert out.read_text().count('"mix": "0,1"') == 1
    out.write_text(out.read_text().replace('"mix": "0,1"', f'"mix": "{first}"'))
    _, same, same_drive = rendered(stereo, out, "--mix", again)
    assert (same.source, same.events) == (made.source, made.events)
    assert np.array_equal(same_drive, drive)
    other = ("render", stereo, "-o", tmp_path / "other", "--timeline", out, "--mix", "2,0", "--quiet")
    assert blastline(*other).complaint.endswith(f"heard in the mix {first}, not 0,2; give --mix {first}")


def table(result: Path) -> str:
    """Return the onsets of a result, without what names its film."""
    return "".join(f"{line.split(',')[1]}\n" for line in (result / "timeline.csv").read_text().splitlines())
