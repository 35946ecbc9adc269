"""The course of a job in its run folder."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

from hgs_core.base.progress import Progress
from jobs.runs.progress_log import COURSE, CourseWriter, Milestone, read_course, thinned


def reported(run: Path) -> list[tuple[int, str, int]]:
    return [(point.attempt, point.stage, point.done) for point in read_course(run)]


def test_reports_are_read_as_they_were_written(tmp_path: Path) -> None:
    writer = CourseWriter(tmp_path, 2)
    writer.add(Progress("masks", 1, 16))
    writer.add(Progress("train", 10, 400, {"psnr": 21.5, "loss": 0.25}))
    first, second = read_course(tmp_path)
    assert (first.attempt, first.stage, first.done, first.total, first.figures) == (2, "masks", 1, 16, {})
    assert second.figures == {"psnr": 21.5, "loss": 0.25}
    assert 0 < first.time <= second.time


def test_nothing_was_reported_where_there_is_no_file(tmp_path: Path) -> None:
    assert read_course(tmp_path) == []


def test_a_long_stage_is_written_some_five_hundred_times_with_its_end(tmp_path: Path) -> None:
    writer = CourseWriter(tmp_path, 1)
    for done in range(10, 40_001, 10):
        writer.add(Progress("train", done, 40_000))
    course = read_course(tmp_path)
    assert len(course) <= 501
    assert course[-1].done == 40_000


def test_equal_reports_are_written_once(tmp_path: Path) -> None:
    writer = CourseWriter(tmp_path, 1)
    for _ in range(3):
        writer.add(Progress("train", 400, 400))
    assert len(read_course(tmp_path)) == 1


def test_a_stage_that_goes_on_from_a_checkpoint_takes_back_what_it_reports_again(tmp_path: Path) -> None:
    first, second = CourseWriter(tmp_path, 1), CourseWriter(tmp_path, 2)
    first.add(Progress("points", 9, 9))
    for done in (100, 200, 300):
        first.add(Progress("train", done, 400))
    second.add(Progress("train", 200, 400))
    second.add(Progress("train", 400, 400))
    assert reported(tmp_path) == [(1, "points", 9), (1, "train", 100), (2, "train", 200), (2, "train", 400)]


def test_figures_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    CourseWriter(tmp_path, 1).add(Progress("train", 1, 4, {"loss": float("nan"), "psnr": 20.0}))
    json.loads((tmp_path / COURSE).read_text(), parse_constant=pytest.fail)
    assert read_course(tmp_path)[0].figures == {"psnr": 20.0}


@pytest.mark.parametrize(
    "line", ["", "{", "[]", '{"stage": "train"}', '{"figures": 3}', "\x00", '{"figures": {"a": []}}']
)
def test_a_damaged_line_is_left_out(tmp_path: Path, line: str) -> None:
    CourseWriter(tmp_path, 1).add(Progress("masks", 1, 4))
    with (tmp_path / COURSE).open("a") as file:
        file.write(line + "\n")
    CourseWriter(tmp_path, 1).add(Progress("masks", 2, 4))
    assert reported(tmp_path) == [(1, "masks", 1), (1, "masks", 2)]


def test_thinning_keeps_the_first_and_last_of_every_stage() -> None:
    course = [
        Milestone(1, stage, done, 600, 0.0, {}) for stage in ("masks", "points", "train") for done in range(1, 601)
    ]
    chosen = thinned(course, 100)
    assert 100 <= len(chosen) <= 110
    for stage in ("masks", "points", "train"):
        places = [point.done for point in chosen if point.stage == stage]
        assert (places[0], places[-1]) == (1, 600)
        assert max(b - a for a, b in itertools.pairwise(places)) <= 18
    assert thinned(course, 2000) == course
