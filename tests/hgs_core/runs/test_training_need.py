"""The need of a training as it is stated and kept."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from hgs_core.runs.training_need import TrainingNeed, disk_words

NEED = TrainingNeed(
    {"initialise": 1 << 30, "train": 2254857830}, 4_900_000_000, 100_000_000, {"train": 4100.0, "encode": 100.0}, (1.0,)
)


def test_it_is_one_sentence_of_memory_disk_and_time() -> None:
    assert NEED.sentence(cores=1) == "needs 2.1 GiB of memory, 5.0 GB of disk and about 70 minutes here"


def test_hours_are_stated_as_such() -> None:
    long = dataclasses.replace(NEED, processor={"train": 36_000.0})
    assert long.sentence(cores=1).endswith("about 10 hours here")


def test_more_cores_shorten_it() -> None:
    assert NEED.seconds(4)["train"] < NEED.seconds(2)["train"] < NEED.seconds(1)["train"] == 4100


@pytest.mark.parametrize(("size", "words"), [(10, "1 MB"), (35e6, "35 MB"), (4.4e8, "0.4 GB"), (25.3e9, "25 GB")])
def test_disk_in_words(size: float, words: str) -> None:
    assert disk_words(size) == words


def test_it_is_kept_in_a_file(tmp_path: Path) -> None:
    NEED.save(tmp_path / "need.json")
    assert TrainingNeed.load(tmp_path / "need.json") == NEED


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"course": [1], "other": 1}'])
def test_a_file_of_another_form_is_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "need.json").write_text(text)
    assert TrainingNeed.load(tmp_path / "need.json") is None
