"""Exported files say what the timeline says, to the sample and to the last bit."""

import csv
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import msgspec
import pandas
import pytest
from hypothesis import HealthCheck, given, settings

from blastline.errors import RuleError
from blastline.export import FORMATS, export_timeline, known_formats, read_timeline
from blastline.export.table import COLUMNS
from blastline.export.words import label, note
from blastline.model import Timeline
from blastline.run.export_rows import export_rows
from timelines import BURST_SHOT, RATE_HZ, SHOT, any_timeline, timeline

# pandas 2 rounds numbers unless it is asked not to; later ones never do
TO_THE_LAST_BIT: dict[str, Any] = {"float_precision": "round_trip"} if pandas.__version__ < "3" else {}

SHARED_FOLDER = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=40
)


@SHARED_FOLDER
@given(any_timeline())
def test_the_json_file_reads_back_equal(tmp_path: Path, original: Timeline) -> None:
    [file] = export_timeline(original, tmp_path, formats=["json"])
    assert read_timeline(file) == original


@SHARED_FOLDER
@given(any_timeline())
def test_the_table_reads_back_to_the_last_bit(tmp_path: Path, original: Timeline) -> None:
    [file] = export_timeline(original, tmp_path, formats=["csv"])
    table = pandas.read_csv(file, dtype=dict(COLUMNS), na_values=[""], keep_default_na=False, **TO_THE_LAST_BIT)
    assert list(table.columns) == list(COLUMNS)
    assert len(table) == len(original.events)
    for row, event in zip(table.to_dict("records"), original.events, strict=True):
        for key in ("id", "onset_sample", "onset_s", "timecode", "confidence", "peak_dbfs", "snr_db"):
            assert row[key] == getattr(event, key)
        assert (row["blast_start_sample"], row["blast_stop_sample"]) == (event.blast.start, event.blast.stop)
        assert (row["window_start_sample"], row["window_stop_sample"]) == (event.window.start, event.window.stop)
        assert (row["window_start_s"], row["window_stop_s"]) == (
            event.window.start / RATE_HZ,
            event.window.stop / RATE_HZ,
        )
        assert row["reflections"] == len(event.reflections)
        assert row["heard_in"] == event.heard_in
        for key in ("burst", "shot_in_burst", "azimuth_deg", "azimuth_focus"):
            value = getattr(event, key)
            assert pandas.isna(row[key]) if value is None else row[key] == value
        if event.drive is None:
            assert pandas.isna([row[key] for key in list(COLUMNS)[-5:]]).all()
        else:
            drive = (event.drive.model, event.drive.reason, event.drive.peak)
            assert (row["drive_model"], row["drive_reason"], row["drive_peak"]) == drive
            assert (row["perceived_gain_db"], row["fidelity"]) == (event.drive.perceived_gain_db, event.drive.fidelity)


def test_the_first_reflection_is_the_earliest(tmp_path: Path) -> None:
    [file] = export_timeline(timeline(SHOT, BURST_SHOT), tmp_path, formats=["csv"])
    delays_ms = pandas.read_csv(file, **TO_THE_LAST_BIT)["first_reflection_delay_ms"]
    assert delays_ms[0] == SHOT.reflections[0].delay_ms
    assert pandas.isna(delays_ms[1])


def test_whole_numbers_stay_whole_beside_empty_cells(tmp_path: Path) -> None:
    [file] = export_timeline(timeline(SHOT, BURST_SHOT), tmp_path, formats=["csv"])
    header, first, second, end = file.read_text(encoding="utf-8").split("\n")
    at = header.split(",").index("burst")
    assert (first.split(",")[at], second.split(",")[at], end) == ("", "1", "")


def test_text_that_is_missing_is_an_empty_cell_in_every_pandas(tmp_path: Path) -> None:
    [file] = export_timeline(timeline(BURST_SHOT), tmp_path, formats=["csv"])
    [row] = csv.DictReader(file.read_text(encoding="utf-8").splitlines())
    assert (row["drive_model"], row["drive_reason"], row["drive_made_of"]) == ("", "", "")
    assert "str" not in COLUMNS.values()  # with which pandas 2 writes None


def test_a_film_without_shots_is_a_table_without_rows(tmp_path: Path) -> None:
    empty = msgspec.structs.replace(timeline(), events=())
    files = export_timeline(empty, tmp_path, formats=list(FORMATS))
    assert list(pandas.read_csv(tmp_path / "timeline.csv").columns) == list(COLUMNS)
    assert (tmp_path / "timeline.audacity.txt").read_bytes() == b""
    assert read_timeline(files[0]) == empty


@SHARED_FOLDER
@given(any_timeline())
def test_labels_start_at_the_onset_to_the_sample(tmp_path: Path, original: Timeline) -> None:
    [file] = export_timeline(original, tmp_path, formats=["audacity"])
    lines = file.read_text(encoding="utf-8").splitlines()
    for line, event in zip(lines, original.events, strict=True):
        start_s, end_s, label = line.split("\t")
        assert round(float(start_s) * RATE_HZ) == event.onset_sample
        assert round(float(end_s) * RATE_HZ) == event.window.stop
        assert label.startswith(event.id)


def test_files_are_the_same_bytes_each_time(tmp_path: Path) -> None:
    for name in FORMATS:
        for folder in ("a", "b"):
            (tmp_path / folder).mkdir(exist_ok=True)
        [first] = export_timeline(timeline(), tmp_path / "a", formats=[name])
        [second] = export_timeline(timeline(), tmp_path / "b", formats=[name])
        assert first.read_bytes() == second.read_bytes()
        assert b"\r" not in first.read_bytes()


def test_every_format_has_a_file_of_its_own_and_names_its_tool() -> None:
    assert list(FORMATS) == [each.name for each in FORMATS.values()]
    assert len({each.file_name for each in FORMATS.values()}) == len(FORMATS) >= 3
    assert all(each.tool for each in FORMATS.values())


def test_formats_come_in_the_order_asked_for_and_once() -> None:
    assert [each.name for each in known_formats(["csv", "json", "csv"])] == ["csv", "json"]


def test_an_unknown_format_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(RuleError, match=r"--format 'xls': no such format; expected some of: json, schema, csv"):
        export_timeline(timeline(), tmp_path, formats=["json", "xls"])
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("has_picture", [True, False])
def test_final_cut_is_told_of_a_picture_where_there_is_one_and_of_no_other(tmp_path: Path, has_picture: bool) -> None:
    film = timeline()
    film = msgspec.structs.replace(film, source=msgspec.structs.replace(film.source, has_picture=has_picture))
    [file] = export_timeline(film, tmp_path, formats=["fcpxml"])
    asset = ElementTree.parse(file).find("resources/asset")
    assert asset is not None
    assert (asset.get("hasAudio"), asset.get("hasVideo")) == ("1", "1" if has_picture else None)
    assert (asset.get("format") is not None) == has_picture


def test_a_note_tells_a_burst_of_shots_in_one_and_of_no_others() -> None:
    assert "burst" not in note(SHOT, Fraction(0))
    assert f"burst {BURST_SHOT.burst} shot {BURST_SHOT.shot_in_burst}" in note(BURST_SHOT, Fraction(0)).split(", ")


@pytest.mark.parametrize("gain_db", [-60.0, 2.25, 0.0])
def test_a_note_tells_in_full_what_a_label_does_of_a_gain(gain_db: float) -> None:
    event = msgspec.structs.replace(SHOT, gain_db=gain_db)
    told = [f"gain {gain_db:+g} dB"] if gain_db else []
    assert [words for words in note(event, Fraction(0)).split(", ") if words.startswith("gain")] == told
    assert ("gain" in label(event)) == bool(told)
    assert label(event).endswith("".join(told))


def test_what_was_written_is_listed_by_its_own_names_and_what_was_not_by_those_it_would_have() -> None:
    plain = {row.name: row for row in export_rows()}
    assert not any(row.written for row in plain.values())
    [csv_name] = plain["csv"].files
    several = next(row for row in plain.values() if any("*" in name for name in row.files))
    made = [name.replace("*", "1") for name in several.files]
    rows = {row.name: row for row in export_rows(written=[csv_name, *made])}
    assert (rows["csv"].files, rows["csv"].written) == ((csv_name,), True)
    assert (rows[several.name].files, rows[several.name].written) == (tuple(made), True)
    assert rows["otio"] == plain["otio"]
