"""The actuator's commands on real files: from two recordings to a profile that renders; refusals in one line."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
import soundfile

from actuator_signals import Seat, noise, run_through
from blastline.dsp import felt_response
from blastline.ruleset import load_actuator
from commands import BELIEVE, Ended, blastline, write_film

RATE_HZ = 16_000
SEAT = Seat(delay_s=0.0123)


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the recordings of a run, and its results."""
    folder = tmp_path_factory.mktemp("seat")
    sent = noise(16.0, RATE_HZ)
    came = run_through(SEAT, sent, RATE_HZ, snr_db=30.0)
    soundfile.write(folder / "sent.wav", sent, RATE_HZ, subtype="PCM_24")
    soundfile.write(folder / "came.wav", came, RATE_HZ, subtype="PCM_24")
    both = np.stack([came[: len(sent)], sent], axis=1)
    soundfile.write(folder / "both.wav", both, RATE_HZ, subtype="PCM_24")
    soundfile.write(folder / "rate.wav", came, 2 * RATE_HZ, subtype="PCM_24")
    soundfile.write(folder / "silence.wav", np.zeros(RATE_HZ), RATE_HZ, subtype="PCM_24")
    soundfile.write(folder / "other.wav", noise(16.0, RATE_HZ, seed=4), RATE_HZ, subtype="PCM_24")
    limit = float(np.std(came))
    soundfile.write(folder / "clipped.wav", np.clip(came, -limit, limit), RATE_HZ, subtype="PCM_24")
    soundfile.write(folder / "short.wav", came[:RATE_HZ], RATE_HZ, subtype="PCM_24")
    ended = identify(folder, "came.wav", folder / "seat.toml", "--csv", folder / "seat.csv")
    assert ended.code == 0, ended
    (folder / "said.txt").write_text(ended.out)
    return folder


def identify(folder: Path, response: str, output: Path, *more: str | Path) -> Ended:
    sent = ("--excitation", folder / "sent.wav", "--response", folder / response)
    return blastline("actuator", "identify", *sent, "-o", output, *more)


def off_db(profile: Path) -> float:
    """Return how far a profile is from the seat at most, from 20 to 1000 Hz."""
    frequencies_hz = np.geomspace(20.0, 1000.0, 300)
    felt = felt_response(load_actuator(str(profile))[0]).at(frequencies_hz)
    return float(np.max(np.abs(20.0 * np.log10(np.abs(felt)) - SEAT.level_db(frequencies_hz))))


def test_two_recordings_become_a_profile(run: Path) -> None:
    assert off_db(run / "seat.toml") < 0.5
    said = (run / "said.txt").read_text()
    assert re.search(r"^delay +12\.3\d\d ms, taken out$", said, flags=re.MULTILINE)
    assert "polarity   as sent\n" in said
    assert re.search(r"^usable +\d\S* to \d+ Hz, by the coherence of \d+ segments of 1 s$", said, flags=re.MULTILINE)
    rows = [[float(cell) for cell in line.split()] for line in said.splitlines() if re.match(r" +[0-9.]+ +-?\d", line)]
    assert [row[0] for row in rows][-7:] == [31.5, 63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0]
    assert max(abs(row[4]) for row in rows) < 0.6


def test_the_profile_says_where_it_comes_from(run: Path) -> None:
    plain = tomllib.loads((run / "seat.toml").read_text())
    assert plain["name"] == "seat"
    assert "measured from came.wav against sent.wav; no perception curve" in plain["source"]
    assert "Schwarz's criterion" in plain["source"]
    assert "inverse bounded to 60 dB" in plain["source"]


def test_the_written_response_is_fitted_as_the_recordings_are(run: Path, tmp_path: Path) -> None:
    assert blastline("actuator", "fit", run / "seat.csv", "-o", tmp_path / "seat.toml", "--quiet").out == ""
    first, second = (load_actuator(str(folder / "seat.toml"))[0].response for folder in (run, tmp_path))
    assert first.gain == pytest.approx(second.gain, rel=1e-3)
    np.testing.assert_allclose(first.poles_rad_s, second.poles_rad_s, rtol=1e-3, atol=1e-3)


def test_channels_of_one_file_are_chosen(run: Path, tmp_path: Path) -> None:
    both = run / "both.wav"
    asked = ("actuator", "identify", "--excitation", both, "--response", both, "-o", tmp_path / "seat.toml")
    complaint = blastline(*asked, "--excitation-channel", "1", "-q").complaint
    assert complaint == f"{both}: has 2 channels; expected --response-channel N to say which, counted from 0"
    ended = blastline(*asked, "--excitation-channel", "1", "--response-channel", "0", "-q")
    assert ended.code == 0, ended
    assert off_db(tmp_path / "seat.toml") < 0.5
    assert "there is no channel 2" in blastline(*asked, "--excitation-channel", "2", "-q").complaint


@pytest.mark.parametrize(
    ("response", "complaint"),
    [
        ("rate.wav", "has a sample rate of 32000 Hz; expected 16000 Hz, as "),
        ("silence.wav", "is silent; expected a recording of a measurement"),
        ("other.wav", "follows "),
        ("clipped.wav", "is clipped: "),
        ("short.wav", "has "),
        ("none.wav", "no such file"),
        ("seat.csv", ""),
    ],
)
def test_recordings_that_tell_nothing_are_refused(run: Path, tmp_path: Path, response: str, complaint: str) -> None:
    ended = identify(run, response, tmp_path / "out" / "seat.toml", "--quiet")
    assert ended.complaint.startswith(f"{run / response}: {complaint}")
    assert not (tmp_path / "out").exists()


def test_nothing_is_replaced_unasked_and_nothing_written_half(run: Path, tmp_path: Path) -> None:
    (tmp_path / "seat.toml").write_text("mine")
    asked = ("actuator", "fit", run / "seat.csv", "-o", tmp_path / "seat.toml", "-q")
    assert "seat.toml: exists already; give --overwrite" in blastline(*asked).complaint
    assert (tmp_path / "seat.toml").read_text() == "mine"
    assert blastline(*asked, "--overwrite").code == 0
    assert (tmp_path / "seat.toml").read_text() != "mine"
    (tmp_path / "seat.csv").write_text("mine")
    both = identify(run, "came.wav", tmp_path / "new.toml", "--csv", tmp_path / "seat.csv", "-q")
    assert "seat.csv: exists already" in both.complaint
    assert sorted(path.name for path in tmp_path.iterdir()) == ["seat.csv", "seat.toml"]
    wrong = identify(run, "came.wav", tmp_path / "new.toml", "--csv", tmp_path / "new.wav", "--quiet").complaint
    assert "new.wav: expected a name that ends in .csv" in wrong
    wrong = blastline(*asked[:4], tmp_path / "seat.txt", "-q").complaint
    assert "seat.txt: expected a name that ends in .toml" in wrong


def test_options_of_a_fit_reach_the_profile(run: Path, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    more = ("--perception", "mpeg-psychohaptic", "--peak-db", "-7", "--largest-gain-db", "30", "--name", "my seat")
    ended = blastline("actuator", "fit", run / "seat.csv", "-o", path, *more)
    assert ended.code == 0, ended
    assert re.search(r"^felt best +at \d+\.?\d* Hz, -7\.0 dB$", ended.out, flags=re.MULTILINE)
    profile, _ = load_actuator(str(path))
    assert profile.name == "my seat"
    assert "perception mpeg-psychohaptic" in profile.source
    assert "inverse bounded to 30 dB" in profile.source
    assert profile.lowpass.corner_hz < 500.0
    assert (
        "no such perception curve"
        in blastline("actuator", "fit", run / "seat.csv", "-o", path, "--perception", "x").err
    )


@pytest.mark.parametrize("corner_hz", [None, 150.0])
def test_a_fitted_profile_renders(run: Path, tmp_path: Path, corner_hz: float | None) -> None:
    """And passes its checks, also where its own low-pass delays by more than the built-in profile's."""
    film = write_film(tmp_path / "film.wav", length_s=3.0, shots_s=(1.0,))
    (tmp_path / "rules" / "quality").mkdir(parents=True)
    (tmp_path / "rules" / "quality" / "draft.toml").write_text(BELIEVE)
    options = ("--quality", "draft", "--rules", tmp_path / "rules", "--no-report", "-q")
    seat = (run / "seat.toml").read_text(encoding="utf-8")
    if corner_hz is not None:
        seat = re.sub(r"(\[lowpass\][^[]*corner_hz = )[0-9.e+]+", rf"\g<1>{corner_hz}", seat)
    (tmp_path / "seat.toml").write_text(seat, encoding="utf-8")
    own = ("--actuator", tmp_path / "seat.toml")
    ended = blastline("render", film, "-o", tmp_path / "out", *own, *options)
    assert ended.code == 0, ended
    samples, rate_hz = soundfile.read(tmp_path / "out" / "drive.wav")
    assert 0.0 < np.max(np.abs(samples)) <= 1.0
    lags = [
        c for c in json.loads((tmp_path / "out" / "timeline.json").read_text())["checks"] if c["name"] == "felt_lag"
    ]
    assert lags
    assert all((lag["measured"] > 0.5) == (corner_hz is not None) for lag in lags)
    soundfile.write(tmp_path / "late.wav", np.roll(samples, round(0.0005 * rate_hz)), rate_hz, subtype="PCM_24")
    assert blastline("check", tmp_path / "out", "--drive", tmp_path / "late.wav", *own).code == 1


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_pictures_are_drawn(run: Path, tmp_path: Path, suffix: str) -> None:
    picture = tmp_path / f"bode{suffix}"
    asked = ("actuator", "show", run / "seat.toml", "--picture", picture, "--measured", run / "seat.csv")
    ended = blastline(*asked, "--perception", "mpeg-psychohaptic")
    assert ended.code == 0, ended
    head = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
    assert picture.read_bytes().startswith(head)
    if suffix == ".svg":
        text = picture.read_text(encoding="utf-8")
        for words in ("seat", "Actuator, as measured", "coherence", "Compensator", "model", "level, dB", "Hz"):
            assert words in text
    assert "exists already" in blastline(*asked).complaint
    assert blastline(*asked, "--overwrite").code == 0


def test_a_picture_is_the_same_twice_and_needs_no_measurement(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg"):
        assert blastline("actuator", "show", "crowson-t108sm", "--picture", tmp_path / name).code == 0
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    wrong = blastline("actuator", "show", "crowson-t108sm", "--picture", tmp_path / "one.gif").complaint
    assert wrong == f"{tmp_path / 'one.gif'}: expected a name that ends in .png, .svg, .pdf"
    alone = blastline("actuator", "show", "crowson-t108sm", "--perception", "iso-2631-wk").complaint
    assert "expected --picture FILE as well" in alone
