from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.run_folder import RunFolder
from jobs.home.home import Home
from jobs.runs.run_trash import empty_trash, throw_away, trash


def test_a_run_folder_is_moved_away_whole_then_removed(home: Home) -> None:
    (home.run("a") / "scene").mkdir(parents=True)
    throw_away(home, "a")
    assert (home.run("a").exists(), trash(home)) == (False, ["a"])
    empty_trash(home, "a")
    assert trash(home) == []


def test_where_there_is_no_run_folder_nothing_happens(home: Home) -> None:
    throw_away(home, "a")
    assert trash(home) == []


def test_what_an_interrupted_removal_left_does_not_stand_in_the_way(home: Home) -> None:
    for _ in range(2):
        home.run("a").mkdir(parents=True)
        throw_away(home, "a")
    assert trash(home) == ["a"]


def test_a_run_that_a_process_works_on_stays(home: Home) -> None:
    home.run("a").mkdir(parents=True)
    with RunFolder(home.run("a")).exclusive(), pytest.raises(InputError, match="another process works on this run"):
        throw_away(home, "a")
    assert home.run("a").is_dir()
