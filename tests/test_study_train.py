"""A training run, from lessons to the file that is shipped. scikit-learn and PyTorch come with the extra `train`."""

import sys
from pathlib import Path

import msgspec
import pytest

from blastline.detect.verify import ModelFile, read_model
from blastline.ruleset import rules_path
from blastline.study.datasets import Dataset
from blastline.study.lesson_files import SeededDatasets
from blastline.study.lessons import plain_mix
from blastline.study.networks import named_size
from blastline.study.train import main
from blastline.study.verifier import train

SEED = 5
DATASETS = [SeededDatasets(SEED, [Dataset("plain", plain_mix(SEED), 6, 3)])]


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("work")


@pytest.fixture(scope="module")
def model(work: Path) -> ModelFile:
    """Return what six minutes of textbook sounds teach, of which two are held out."""
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    return train(DATASETS, work, networks=("small",), jobs=1, copies=1)


def test_what_is_learnt_of_some_minutes_is_worth_something_in_others(model: ModelFile) -> None:
    """One candidate in eighteen is a shot: who believes them all has an F1 of .1."""
    believing_all = 2.0 / (1.0 + model.training["candidates"] / model.training["shots"])
    assert believing_all < 0.12
    for f1 in model.training["held_out"]["plain"]["f1_by_networks"]:
        assert f1 > 3.5 * believing_all


def test_the_same_lessons_teach_the_same(model: ModelFile, work: Path) -> None:
    assert msgspec.json.encode(train(DATASETS, work, networks=("small",), jobs=1, copies=1)) == msgspec.json.encode(
        model
    )


def test_the_file_is_read_as_it_was_trained_and_its_networks_are_fine_tuned(model: ModelFile, work: Path) -> None:
    path = work / "model.json"
    path.write_bytes(msgspec.json.encode(model))
    before = read_model(path)
    assert msgspec.json.encode(before) == path.read_bytes()
    tuned = train(DATASETS, work, networks=("small", "small"), jobs=1, before=before)
    assert [named_size(network) for network in tuned.networks] == ["small", "small"]
    assert tuned.training["before"] == model.training
    assert tuned.networks[0].means == model.networks[0].means  # goes on; the second one began with other lessons
    assert tuned.networks[1].means != model.networks[0].means


@pytest.mark.parametrize("sizes", ["small", "large,small,large", "huge"])
def test_networks_other_than_those_that_are_fine_tuned_are_refused(
    sizes: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shipped, output = rules_path("verifier/shots.json"), tmp_path / "model.json"
    monkeypatch.setattr(sys, "argv", ["train", "--further", str(shipped), "--networks", sizes, "-o", str(output)])
    with pytest.raises(SystemExit) as refused:
        main()
    assert refused.value.code == 2
    assert sizes in capsys.readouterr().err
    assert not output.exists()
