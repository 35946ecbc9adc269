from __future__ import annotations

import fcntl
import json
import threading
from pathlib import Path

import pytest
import segment_pipeline

from hgs_core.base.progress import Progress, StageStopped, silent
from jobs.runs import shared_segments as segments
from jobs.runs.shared_segments import help_with_segment, make_segments


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run of three segments."""
    (tmp_path / "run.json").write_text(json.dumps({"segments": 3, "pace": 0, "iterations": 4}))
    return tmp_path


def made(run: Path) -> list[str]:
    return [line.split()[0] for line in (run / "made.log").read_text().splitlines()]


def test_all_are_made_in_order_and_the_scene_is_published_after_each(run: Path) -> None:
    published: list[int | None] = []
    reports: list[Progress] = []
    publish = lambda: published.append(json.loads((run / "scene" / "manifest.json").read_text()).get("live"))  # noqa: E731
    make_segments(segment_pipeline, run, reports.append, publish)
    assert made(run) == ["0", "1", "2"]
    assert published == [1, 2, 3]
    assert "live" not in json.loads((run / "scene" / "manifest.json").read_text())
    assert [report.done for report in reports] == sorted(report.done for report in reports)
    assert (reports[-1].done, reports[-1].total) == (12, 12)
    assert (reports[-1].figures["segments"], reports[-1].figures["made"]) == (3.0, 3.0)


def test_help_waits_for_the_first_and_makes_one_segment_that_nobody_else_makes(run: Path) -> None:
    help_with_segment(segment_pipeline, run, silent, lambda: None)
    assert not (run / "made.log").exists()
    (run / "segments").mkdir()
    segment_pipeline.make_segment(run, 0, silent)
    with (run / "segments" / "1.lock").open("w") as claimed:
        fcntl.flock(claimed, fcntl.LOCK_EX)
        help_with_segment(segment_pipeline, run, silent, lambda: None)
    assert made(run) == ["0", "2"]


def test_help_does_not_take_back_what_is_complete(run: Path) -> None:
    make_segments(segment_pipeline, run, silent, lambda: None)
    complete = (run / "scene" / "manifest.json").read_bytes()
    (run / "segments" / "2").unlink()
    help_with_segment(segment_pipeline, run, silent, lambda: None)
    assert (run / "scene" / "manifest.json").read_bytes() == complete


def test_whoever_has_the_job_waits_for_segments_of_others(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(segments, "LOOK", 0.01)
    (run / "segments").mkdir()
    waiting = threading.Event()

    def report(progress: Progress) -> None:
        if progress.figures["made"] == 2.0 and progress.done == 8:
            waiting.set()

    with (run / "segments" / "1.lock").open("w") as claimed:
        fcntl.flock(claimed, fcntl.LOCK_EX)
        main = threading.Thread(target=make_segments, args=(segment_pipeline, run, report, lambda: None))
        main.start()
        assert waiting.wait(30)
        segment_pipeline.make_segment(run, 1, silent)
    main.join(30)
    assert made(run) == ["0", "2", "1"]


def test_what_is_stopped_goes_on_from_its_checkpoint(run: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done >= 6:
            raise StageStopped

    with pytest.raises(StageStopped):
        make_segments(segment_pipeline, run, stop, lambda: None)
    make_segments(segment_pipeline, run, silent, lambda: None)
    steps = (run / "iterations.log").read_text().splitlines()
    assert len(steps) == len(set(steps)) == 12
