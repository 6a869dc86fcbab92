"""The actuator's commands on real files: from two recordings to a profile that renders; refusals in one line."""

import json
import re
import tomllib
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import soundfile
from scipy.signal import chirp

from actuator_signals import Seat, noise, run_through
from blastline.dsp import felt_response
from blastline.report import BodeCurve
from blastline.ruleset import ActuatorProfile, load_actuator, load_perception, rules_path
from blastline.run import draw_bode
from commands import BELIEVE, Ended, blastline, blastline_alone, write_film

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
    lost = np.concatenate([came[: len(sent) // 2], came[len(sent) // 2 + 200 :]])
    soundfile.write(folder / "lost.wav", lost, RATE_HZ, subtype="PCM_24")
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
    wrong = blastline(*asked, "--excitation-channel", "2", "--overwrite", "-q")
    assert wrong.complaint == f"--excitation-channel 2: {both} has 2 channels, counted from 0"
    words = ("actuator", "identify", "--excitation", run / "sent.wav", "--response", run / "came.wav", "-q")
    one = blastline(*words, "-o", tmp_path / "one.toml", "--response-channel", "1")
    assert one.complaint == f"--response-channel 1: {run / 'came.wav'} has 1 channel, counted from 0"


@pytest.mark.parametrize(
    ("response", "complaint"),
    [
        ("rate.wav", "has a sample rate of 32000 Hz; expected 16000 Hz, as "),
        ("silence.wav", "is silent; expected a recording of a measurement"),
        ("other.wav", "follows "),
        ("clipped.wav", "is clipped: "),
        ("lost.wav", "slips by 200."),
        ("short.wav", "has "),
        ("none.wav", "no such file"),
        ("seat.csv", ""),
    ],
)
def test_recordings_that_tell_nothing_are_refused(run: Path, tmp_path: Path, response: str, complaint: str) -> None:
    ended = identify(run, response, tmp_path / "out" / "seat.toml", "--quiet")
    assert ended.complaint.startswith(f"{run / response}: {complaint}")
    assert not (tmp_path / "out").exists()


def test_a_recording_of_hardly_any_steps_is_to_be_louder(run: Path, tmp_path: Path) -> None:
    felt, _ = soundfile.read(run / "came.wav")
    soundfile.write(tmp_path / "faint.wav", np.sign(felt) / 2**15, RATE_HZ, subtype="PCM_16")
    asked = ("actuator", "identify", "--excitation", run / "sent.wav", "--response", tmp_path / "faint.wav")
    complaint = blastline(*asked, "-o", tmp_path / "seat.toml", "--quiet").complaint
    assert "has few steps: " in complaint
    assert complaint.endswith("record it at a higher level")


def test_a_recorded_excitation_that_was_clipped_is_refused(run: Path, tmp_path: Path) -> None:
    sent, _ = soundfile.read(run / "sent.wav")
    soundfile.write(tmp_path / "sent.wav", np.clip(sent, -0.1, 0.1), RATE_HZ, subtype="PCM_24")
    soundfile.write(tmp_path / "came.wav", soundfile.read(run / "came.wav")[0], RATE_HZ, subtype="PCM_24")
    ended = identify(tmp_path, "came.wav", tmp_path / "seat.toml", "--quiet")
    assert ended.complaint.startswith(f"{tmp_path / 'sent.wav'}: is clipped: ")
    assert not (tmp_path / "seat.toml").exists()


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
        in blastline("actuator", "fit", run / "seat.csv", "-o", tmp_path / "x.toml", "--perception", "x").err
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


def readme_commands(folder: Path) -> list[list[str]]:
    """Return the commands of README that measure, fit and draw a seat, with the files in a folder."""
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"^blastline (actuator .*)$", text, flags=re.MULTILINE)
    return [[str(folder / word) if "." in word else word for word in line.split()] for line in lines]


def test_the_picture_of_readme_shows_the_model_beside_what_was_measured(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    curve = load_perception("mpeg-psychohaptic")
    rows = zip(curve.frequencies_hz, curve.threshold_db, strict=True)
    table = "\n".join(["frequency_hz,threshold_db", *(f"{hz},{level_db}" for hz, level_db in rows)])
    (tmp_path / "my-thresholds.csv").write_text(table)
    (tmp_path / "noise.wav").write_bytes((run / "sent.wav").read_bytes())
    (tmp_path / "seat.wav").write_bytes((run / "came.wav").read_bytes())
    drawn: list[tuple[ActuatorProfile, BodeCurve]] = []

    def write(path: Path, profile: ActuatorProfile, *, product: BodeCurve, **_: object) -> None:
        path.touch()
        drawn.append((profile, product))

    monkeypatch.setattr("blastline.run.bode_plots.write_bode", write)
    for command in readme_commands(tmp_path):
        assert blastline(*command).code == 0, command
    [(profile, measured)] = drawn
    frequencies_hz, low_hz, high_hz = measured.frequencies_hz, profile.highpass.corner_hz, profile.lowpass.corner_hz
    driven = (frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)
    model_db = 20.0 * np.log10(np.abs(felt_response(profile).at(frequencies_hz[driven])))
    assert np.max(np.abs(model_db - measured.level_db[driven])) < 3.0  # 1.1; without the thresholds 38


def test_a_picture_is_the_same_twice_and_needs_no_measurement(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg"):
        assert blastline("actuator", "show", "crowson-t108sm", "--picture", tmp_path / name).code == 0
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    wrong = blastline("actuator", "show", "crowson-t108sm", "--picture", tmp_path / "one.gif").complaint
    assert wrong == f"{tmp_path / 'one.gif'}: expected a name that ends in .png, .svg, .pdf"
    for drawn in (("--perception", "iso-2631-wk"), ("--measured", tmp_path / "seat.csv")):
        alone = blastline("actuator", "show", "crowson-t108sm", *drawn).complaint
        assert "expected --picture FILE as well" in alone


def test_a_level_that_is_asked_for_is_that_of_the_table(run: Path, tmp_path: Path) -> None:
    """The rows by octave tell of the profile that was written, and no note asks for what was given."""
    levels = {}
    for peak_db in ("-7", "-30"):
        path = tmp_path / f"seat{peak_db}.toml"
        said = blastline("actuator", "fit", run / "seat.csv", "-o", path, "--peak-db", peak_db).out
        rows = [line.split() for line in said.splitlines() if re.match(r" +[0-9.]+ +-?\d", line)]
        levels[peak_db] = {float(row[0]): float(row[1]) for row in rows}
        assert "--peak-db sets it" not in said
        felt = felt_response(load_actuator(str(path))[0])
        assert levels[peak_db][63.0] == pytest.approx(20.0 * np.log10(np.abs(felt.at(np.array([63.0]))[0])), abs=1.0)
    assert levels["-7"][125.0] - levels["-30"][125.0] == pytest.approx(23.0, abs=0.02)


def test_damaged_recordings_are_told_or_refused(run: Path, tmp_path: Path) -> None:
    came, _ = soundfile.read(run / "came.wav")
    half = (run / "came.wav").read_bytes()
    (tmp_path / "cut.wav").write_bytes(half[: len(half) * 3 // 4])
    asked = ("actuator", "identify", "--excitation", run / "sent.wav", "-q")
    cut = blastline(*asked, "--response", tmp_path / "cut.wav", "-o", tmp_path / "cut.toml")
    assert cut.code == 0, cut
    assert re.search(r"^warning: \S*cut\.wav: the file declares .* could be read", cut.err, flags=re.MULTILINE)
    came[: came.size // 3] = np.nan
    soundfile.write(tmp_path / "nan.wav", came, RATE_HZ, subtype="FLOAT")
    broken = blastline(*asked, "--response", tmp_path / "nan.wav", "-o", tmp_path / "nan.toml")
    assert re.search(r"nan\.wav: .* samples are NaN", broken.complaint)
    assert not (tmp_path / "nan.toml").exists()


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24"])
@pytest.mark.parametrize("kind", ["linear", "logarithmic"])
def test_a_sweep_is_no_noise(tmp_path: Path, kind: str, subtype: str) -> None:
    seconds = np.arange(16 * RATE_HZ) / RATE_HZ
    method = "linear" if kind == "linear" else "logarithmic"
    sent = 0.5 * chirp(seconds, 10.0, 16.0, 1000.0, method=method)
    soundfile.write(tmp_path / "sent.wav", sent, RATE_HZ, subtype=subtype)
    soundfile.write(tmp_path / "came.wav", run_through(SEAT, sent, RATE_HZ), RATE_HZ, subtype=subtype)
    ended = identify(tmp_path, "came.wav", tmp_path / "seat.toml", "-q")
    assert re.search(r"sent\.wav: most frequencies are heard in about \d of \d+ segments", ended.complaint)


def test_what_is_wrong_with_the_place_is_told_before_anything_is_heard(run: Path, tmp_path: Path) -> None:
    (tmp_path / "seat.toml").write_text("mine")
    assert "exists already" in identify(run, "none.wav", tmp_path / "seat.toml", "-q").complaint
    assert "ends in .toml" in identify(run, "none.wav", tmp_path / "seat.txt", "-q").complaint


@pytest.mark.parametrize("name", ["Seat $A_$", "座席 A", "100 % \\alpha {"])
def test_a_seat_may_have_any_name_in_its_picture(run: Path, tmp_path: Path, name: str) -> None:
    asked = ("actuator", "fit", run / "seat.csv", "-o", tmp_path / "seat.toml", "--name", name, "-q")
    assert blastline(*asked).code == 0
    ended = blastline("actuator", "show", tmp_path / "seat.toml", "--picture", tmp_path / "seat.png")
    assert (ended.code, ended.err) == (0, "")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--name", "a seat\nin row 7"], "seat.toml: name = 'a seat\\nin row 7': expected printable characters alone"),
        (["--name", "Sitz \udcfc"], "seat.toml: name = 'Sitz \\udcfc': expected printable characters alone"),
        (["-o", "Sitz \udcfc.toml"], "name = 'Sitz \\udcfc': expected printable characters alone"),
        (["--perception", "Haut \udcfc.csv"], "the name is not valid UTF-8; rename the file"),
    ],
)
def test_a_name_that_no_profile_can_hold_is_refused_before_anything_is_heard(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    sent = ("--excitation", run / "sent.wav", "--response", run / "none.wav", "-o", tmp_path / "seat.toml")
    assert told in blastline_alone("actuator", "identify", *sent, "-q", *options).complaint
    assert list(tmp_path.iterdir()) == []


def test_a_table_whose_name_no_profile_can_hold_is_refused(run: Path, tmp_path: Path) -> None:
    table = tmp_path / "Sitz \udcfc.csv"
    table.write_bytes((run / "seat.csv").read_bytes())
    told = blastline_alone("actuator", "fit", table, "-o", tmp_path / "seat.toml", "-q").complaint
    assert "the name is not valid UTF-8; rename the file" in told


def test_a_band_that_the_table_does_not_hold_is_refused(run: Path, tmp_path: Path) -> None:
    lines = (run / "seat.csv").read_text().splitlines()
    wrong = [f"# band_hz: {5e5} {6e5}" if line.startswith("# band_hz") else line for line in lines]
    (tmp_path / "seat.csv").write_text("\n".join(wrong))
    told = blastline("actuator", "fit", tmp_path / "seat.csv", "-o", tmp_path / "seat.toml", "-q").complaint
    assert "expected a band of the table, which runs from" in told


def write_table(path: Path, rows: str, *columns: np.ndarray) -> Path:
    """Write a table with a row for each value of the columns."""
    lines = [",".join(f"{cell:.6g}" for cell in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([rows, *lines]), encoding="utf-8")
    return path


@pytest.mark.parametrize(("coherence", "known"), [(0.0, False), (0.05, False), (0.3, True), (1.0, True)])
def test_a_table_that_knows_nothing_by_its_own_coherence_is_refused(
    tmp_path: Path, coherence: float, known: bool
) -> None:
    frequencies_hz = np.geomspace(10.0, 1000.0, 60)
    columns = (frequencies_hz, SEAT.level_db(frequencies_hz), np.full(60, coherence))
    path = write_table(tmp_path / "seat.csv", "frequency_hz,gain_db,coherence", *columns)
    ended = blastline("actuator", "fit", path, "-o", tmp_path / "seat.toml", "-q")
    if known:
        assert ended.code == 0, ended
        return
    told = f"{path}: coherence = {coherence:g} at most, from 10 to 1000 Hz: nothing of the response is known to follow"
    assert ended.complaint.startswith(told)
    assert "expected 0.1 or more" in ended.complaint
    assert not (tmp_path / "seat.toml").exists()


@pytest.mark.parametrize(
    ("flat_db", "doubted"),
    [(None, True), ((0.0, 1.3), False), ((-0.7, 0.6), False), ((0.9, 2.2), False), ((0.5, 30.0), False)],
)
def test_ratios_in_place_of_levels_are_doubted_and_no_flat_seat_is(
    tmp_path: Path, flat_db: tuple[float, float] | None, doubted: bool
) -> None:
    frequencies_hz = np.geomspace(10.0, 1000.0, 60)
    ratios = np.abs(SEAT.at(frequencies_hz))
    if flat_db is not None:
        ratios = np.interp(ratios, [np.min(ratios), np.max(ratios)], flat_db)
    path = write_table(tmp_path / "seat.csv", "frequency_hz,gain_db", frequencies_hz, ratios)
    ended = blastline("actuator", "fit", path, "-o", tmp_path / "seat.toml", "-q")
    assert ended.code == 0, ended
    told = r"^warning: \S*seat\.csv: gain_db = 0\.0\d+ to 1\.\d+: looks like plain ratios; expected levels, 20 log10"
    assert bool(re.search(told, ended.err)) == doubted
    assert bool(ended.err) == doubted


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_table_with_phase_tells_of_a_seat_that_moves_against_the_drive_and_of_no_other(
    tmp_path: Path, sign: float
) -> None:
    frequencies_hz = np.geomspace(5.0, 2000.0, 80)
    degrees = np.degrees(np.angle(sign * SEAT.at(frequencies_hz)))
    rows = [f"{hz},{db},{d}" for hz, db, d in zip(frequencies_hz, SEAT.level_db(frequencies_hz), degrees, strict=True)]
    (tmp_path / "seat.csv").write_text("\n".join(["frequency_hz,gain_db,phase_deg", *rows]))
    said = blastline("actuator", "fit", tmp_path / "seat.csv", "-o", tmp_path / "seat.toml").out
    assert re.findall(r"^polarity +(.*)$", said, flags=re.MULTILINE) == (
        ["inverted: the seat moves against the drive"] if sign < 0.0 else []
    )


@pytest.mark.parametrize(
    ("peak_db", "asked", "noted"), [(0.0, (), False), (40.0, (), True), (-40.0, (), True), (40.0, ("-7",), False)]
)
def test_a_level_that_no_calibration_would_give_is_doubted_where_none_was_asked_for(
    tmp_path: Path, peak_db: float, asked: tuple[str, ...], noted: bool
) -> None:
    frequencies_hz = np.geomspace(5.0, 2000.0, 80)
    levels_db = SEAT.level_db(frequencies_hz)
    levels_db += peak_db - np.max(levels_db)
    rows = [f"{hz},{level}" for hz, level in zip(frequencies_hz, levels_db, strict=True)]
    (tmp_path / "seat.csv").write_text("\n".join(["frequency_hz,gain_db", *rows]))
    more = [word for level in asked for word in ("--peak-db", level)]
    said = blastline("actuator", "fit", tmp_path / "seat.csv", "-o", tmp_path / "seat.toml", *more).out
    assert ("this level is the recorder's unless it was calibrated" in said) == noted
    assert "the model is far from the measurement" not in said


def test_a_large_table_without_phase_is_drawn_in_little_room(tmp_path: Path) -> None:
    frequencies_hz = np.linspace(5.0, 2000.0, 20_000)
    rows = [f"{hz:.4f},{level:.3f}" for hz, level in zip(frequencies_hz, SEAT.level_db(frequencies_hz), strict=True)]
    (tmp_path / "big.csv").write_text("\n".join(["frequency_hz,gain_db", *rows]))
    tracemalloc.start()
    draw_bode("crowson-t108sm", tmp_path / "big.svg", measured=tmp_path / "big.csv")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 200e6


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("gain", "1e-300", "expected 1e-06 to 1e+06"),
        ("gain", "1e300", "expected 1e-06 to 1e+06"),
        ("poles_rad_s", "[[-1e7, 0.0], [-2e7, 0.0]]", "Hz: expected below 192000 Hz"),
    ],
)
def test_a_profile_that_no_drive_can_be_made_for_is_not_shown(
    tmp_path: Path, key: str, value: str, complaint: str
) -> None:
    text = rules_path("actuators/crowson-t108sm.toml", None).read_text("utf-8")
    changed = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    assert changed != text
    (tmp_path / "seat.toml").write_text(changed, "utf-8")
    assert complaint in blastline("actuator", "show", tmp_path / "seat.toml").complaint


def test_exchanged_recordings_are_doubted(run: Path, tmp_path: Path) -> None:
    exchanged = ("--excitation", run / "came.wav", "--response", run / "sent.wav", "-o", tmp_path / "seat.toml")
    ended = blastline("actuator", "identify", *exchanged)
    assert re.search(r"sent\.wav: comes 12\.\d+ ms before came\.wav: .*exchanged\?", ended.err)
    assert "exchanged" not in identify(run, "came.wav", tmp_path / "right.toml").err


@pytest.mark.parametrize("level_db", [200.0, -300.0])
def test_a_profile_that_no_film_could_be_rendered_with_is_not_written(tmp_path: Path, level_db: float) -> None:
    table, profile = tmp_path / "table.csv", tmp_path / "seat.toml"
    rows = "".join(f"{hz:g},{level_db:g}\n" for hz in np.geomspace(5.0, 2000.0, 60))
    table.write_text("frequency_hz,gain_db\n" + rows)
    assert "not written: --peak-db" in blastline("actuator", "fit", table, "-o", profile, "-q").complaint
    assert not profile.exists()
    assert blastline("actuator", "fit", table, "-o", profile, "--peak-db", "0").code == 0
