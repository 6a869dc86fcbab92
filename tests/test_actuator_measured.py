"""Tables that users bring: what is written is read again, and what is no measurement is refused with one clear line."""

import math
from pathlib import Path

import numpy as np
import pytest

from blastline.actuator import MeasuredResponse, measured_csv, read_measured
from blastline.actuator.measured import unbiased
from blastline.errors import RuleError
from blastline.ruleset import load_perception

HEAD = "frequency_hz,gain_db\n"
GOOD = "".join(
    f"{frequency_hz},{-level_db}\n" for frequency_hz, level_db in zip(range(20, 120, 10), range(10), strict=True)
)


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "seat.csv"
    path.write_text(text, encoding="utf-8")
    return path


def rows(low_hz: float, high_hz: float) -> str:
    """Return nine rows of 0 dB from one frequency to another."""
    return "".join(f"{frequency_hz},0\n" for frequency_hz in np.linspace(low_hz, high_hz, 9).tolist())


@pytest.mark.parametrize("averages", [4, 10, 40])
def test_coherence_of_pure_chance_is_unbiased_to_nothing(averages: int) -> None:
    """Two noises that have nothing in common: |sum x y*|^2 over sum |x|^2 sum |y|^2 is 1 / averages in the mean."""
    random = np.random.default_rng(averages)
    x, y = random.standard_normal((2, 20_000, averages, 2)).view(np.complex128)[..., 0]
    coherence = np.abs((x * y.conj()).sum(axis=1)) ** 2 / ((np.abs(x) ** 2).sum(axis=1) * (np.abs(y) ** 2).sum(axis=1))
    assert np.mean(coherence) == pytest.approx(1.0 / averages, rel=0.03)
    assert unbiased(np.array([1.0 / averages, 1.0]), averages) == pytest.approx([0.0, 1.0], abs=1e-12)


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    measured = MeasuredResponse(
        np.arange(1.0, 51.0),
        random.uniform(0.1, 3.0, 50),
        random.uniform(-3.0, 3.0, 50),
        random.uniform(0.0, 1.0, 50),
        averages=37.9,
        delay_s=0.0123,
        band_hz=(5.0, 40.0),
    )
    again = read_measured(table(tmp_path, measured_csv(measured, "a test, with a comma")))
    np.testing.assert_allclose(again.frequencies_hz, measured.frequencies_hz)
    np.testing.assert_allclose(again.gain, measured.gain, rtol=1e-5)
    assert measured.phase_rad is not None
    assert measured.coherence is not None
    assert again.phase_rad is not None
    assert again.coherence is not None
    np.testing.assert_allclose(again.phase_rad, measured.phase_rad, atol=1e-5)
    np.testing.assert_allclose(again.coherence, measured.coherence, atol=1e-6)
    assert (again.averages, again.delay_s, again.band_hz) == (37.9, 0.0123, (5.0, 40.0))


@pytest.mark.parametrize("segment", [90_000, 180_000, 11_520])
def test_all_rows_of_the_usable_band_are_in_it_when_they_are_read_again(tmp_path: Path, segment: int) -> None:
    """The band's ends are rows; the bins of a segment at 44.1 kHz are no round numbers."""
    frequencies_hz = np.arange(2.0, segment // 11, segment // 2000) * 44_100.0 / segment
    for first in range(3):
        for last in range(len(frequencies_hz) - 12, len(frequencies_hz)):
            band_hz = float(frequencies_hz[first]), float(frequencies_hz[last])
            measured = MeasuredResponse(frequencies_hz, np.ones_like(frequencies_hz), band_hz=band_hz)
            again = read_measured(table(tmp_path, measured_csv(measured, "a test")))
            assert len(again.within(0.0, math.inf).gain) == last - first + 1


def test_a_source_of_several_lines_leaves_the_table_readable(tmp_path: Path) -> None:
    measured = MeasuredResponse(np.arange(1.0, 51.0), np.ones(50), band_hz=(1.0, 50.0))
    again = read_measured(table(tmp_path, measured_csv(measured, "measured from seat\nin row 7.wav")))
    np.testing.assert_allclose(again.gain, measured.gain)


def test_the_columns_come_in_any_order(tmp_path: Path) -> None:
    lines = [f"{-hz / 100:g},{hz:g}" for hz in range(20, 420, 20)]
    read = read_measured(table(tmp_path, "\n".join(["gain_db,frequency_hz", *lines])))
    assert (read.frequencies_hz[0], read.gain_db[-1]) == (20.0, pytest.approx(-4.0))


def test_levels_alone_are_enough_and_spreadsheets_may_have_written_them(tmp_path: Path) -> None:
    rows = GOOD.replace("\n", "\r\n")
    measured = read_measured(
        table(tmp_path, f"\ufeff# a seat\r\n\r\nFrequency_Hz , note, Gain_dB\r\n{rows.replace(',', ',x,')}")
    )
    assert (measured.phase_rad, measured.coherence, measured.averages) == (None, None, None)
    assert measured.band_hz == (20.0, 110.0)
    assert np.all(measured.error_db == 0.0)
    np.testing.assert_allclose(measured.gain_db, -np.arange(10.0), atol=1e-12)


def test_an_octave_is_enough(tmp_path: Path) -> None:
    assert read_measured(table(tmp_path, HEAD + rows(100.0, 200.0))).band_hz == (100.0, 200.0)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "the first line names nothing; expected the columns frequency_hz, gain_db, [phase_deg], [coherence]"),
        ("20,0\n30,1\n", "the first line names 20, 0; expected the columns frequency_hz, gain_db"),
        (HEAD, "holds no measurement below its line of names; expected rows of frequency_hz, gain_db"),
        (HEAD + "20,0\n", "holds 1 row; expected at least 8"),
        (HEAD + "20,0\n30,1\n", "holds 2 rows; expected at least 8"),
        (HEAD + GOOD + "100,3\n", "line 12: frequency_hz = 100: expected more than 110 Hz, the row before"),
        (HEAD + GOOD + "110,3\n", "line 12: frequency_hz = 110: expected more than 110 Hz, the row before"),
        (HEAD + "0,0\n" + GOOD, "line 2: frequency_hz = 0: expected more than 0"),
        (HEAD + "10,nan\n" + GOOD, "line 2: gain_db = 'nan': expected a finite number"),
        (HEAD + "10,-inf\n" + GOOD, "line 2: gain_db = '-inf': expected a finite number"),
        (HEAD + "10,\n" + GOOD, "line 2: gain_db = '': expected a finite number"),
        (HEAD + "10,1;5\n" + GOOD, "line 2: gain_db = '1;5': expected a finite number"),
        (HEAD + "10\n" + GOOD, "line 2: 1 cell; expected 2, as the first line names"),
        (HEAD + "10,401\n" + GOOD, "gain_db = 401 at 10 Hz: expected -400 to 400"),
        (HEAD + rows(100.0, 108.0), "frequency_hz runs from 100 to 108 Hz; expected"),
        (HEAD + rows(100.0, 199.9), "frequency_hz runs from 100 to 199.9 Hz; expected at least an octave"),
        (
            "frequency_hz,gain_db,gain_db\n20,1,2\n",
            "the first line names a column twice: frequency_hz,",
        ),
        (
            "frequency_hz,gain_db,coherence\n" + GOOD.replace("\n", ",1.5\n"),
            "coherence = 1.5 at 20 Hz: expected 0",
        ),
        ("# band_hz: 90 20\n" + HEAD + GOOD, "# band_hz: '90 20': expected two ascending frequencies"),
        ("# averages: many\n" + HEAD + GOOD, "# averages: 'many': expected a number >= 2"),
        ("# delay_s: soon\n" + HEAD + GOOD, "# delay_s: 'soon': expected a number"),
    ],
)
def test_what_is_no_measurement_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    path = table(tmp_path, text)
    with pytest.raises(RuleError) as told:
        read_measured(path)
    assert str(told.value).startswith(f"{path}: {complaint}")
    assert "\n" not in str(told.value)


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RuleError, match=r"none\.csv: cannot be read: No such file"):
        read_measured(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("encoding", "place"),
    [
        ("utf-16", "line 1: begins as UTF-16 does"),
        ("utf-16-le", "line 1: begins as UTF-16 does"),
        ("utf-16-be", "line 1: begins as UTF-16 does"),
        ("latin-1", "line 2: the byte 0xfc is not UTF-8"),
        ("cp1252", "line 2: the byte 0xfc is not UTF-8"),
    ],
)
def test_another_encoding_is_told_with_the_one_that_is_expected(tmp_path: Path, encoding: str, place: str) -> None:
    table_text = "# averages: 9\n# Sitz: für einen\nfrequency_hz,{}\n" + GOOD
    (tmp_path / "own.csv").write_bytes(table_text.format("gain_db").encode(encoding))
    with pytest.raises(RuleError) as told:
        read_measured(tmp_path / "own.csv")
    assert str(told.value) == f"{tmp_path / 'own.csv'}: {place}; expected a CSV file in UTF-8"
    (tmp_path / "own.csv").write_bytes(table_text.format("threshold_db").encode(encoding))
    with pytest.raises(RuleError, match=rf"own\.csv: {place}; expected a CSV file in UTF-8"):
        load_perception(str(tmp_path / "own.csv"))
    (tmp_path / "own.toml").write_bytes("schema = 1\n# Sitz: für einen\n".encode(encoding))
    with pytest.raises(RuleError, match=rf"own\.toml: {place}; expected a TOML file in UTF-8"):
        load_perception(str(tmp_path / "own.toml"))


def test_a_threshold_of_ones_own_is_read(tmp_path: Path) -> None:
    path = table(tmp_path, "# source: my thesis\nfrequency_hz,threshold_db\n20,-5\n50,-17\n200,-44\n")
    curve = load_perception(str(path))
    assert (curve.name, curve.source) == ("seat", "my thesis")
    assert curve.frequencies_hz == (20.0, 50.0, 200.0)
    assert curve.threshold_db == (-5.0, -17.0, -44.0)


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        (
            "own.csv",
            "frequency_hz,threshold\n20,1\n30,2\n",
            "the first line names frequency_hz, threshold; expected",
        ),
        ("own.csv", "frequency_hz,threshold_db\n20,1\n", "holds 1 row; expected at least 2"),
        ("own.csv", "frequency_hz,threshold_db\n20,1\n20,2\n", "line 3: frequency_hz = 20: expected more than 20 Hz"),
        (
            "own.toml",
            "schema = 1\nsource = 'mine'\nname = 'x'\n",
            "frequencies_hz: is missing; expected a list",
        ),
        (
            "own.toml",
            "schema = 1\nsource = 'mine'\nname = 'x'\nfrequencies_hz = [30.0, 20.0]\nthreshold_db = [1.0, 2.0]\n",
            "top level: frequencies_hz has 20 after 30: expected ascending frequencies",
        ),
        (
            "own.toml",
            "schema = 1\nsource = 'mine'\nname = 'x'\nfrequencies_hz = [20.0, 30.0]\nthreshold_db = [1.0, 2.0, 3.0]\n",
            "top level: frequencies_hz, threshold_db have 2 and 3 values: expected as many of both",
        ),
    ],
)
def test_a_threshold_that_does_not_fit_is_refused(tmp_path: Path, name: str, text: str, complaint: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(RuleError) as told:
        load_perception(str(path))
    assert str(told.value).startswith(f"{path}: {complaint}")
    with pytest.raises(RuleError, match=r"^none.toml: no such perception curve; .* one of: iso-2631-wk, mpeg-psycho"):
        load_perception("none.toml")
