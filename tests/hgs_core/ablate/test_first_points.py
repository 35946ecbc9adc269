"""Masks and first points that runs share or have changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.ablate.first_points import initialise_run, moving_share
from hgs_core.ablate.mask_changes import grown_to_share
from hgs_core.ablate.plan import RowRun
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.decompose.masks import MotionMasks, mask_file
from hgs_core.runs.creation import create_run
from hgs_core.runs.stages import initialise
from hgs_core.runs.training_inputs import masks_of_run
from tests.hgs_core.ablate.conftest import MakeAblation


@pytest.fixture
def runs(make_ablation: MakeAblation, tmp_path: Path) -> list[RowRun]:
    """The full method and two kinds of masks with two seeds, of which the first run has its points."""
    ablation = make_ablation(tmp_path, ["masks-60", "masks-blobs"], seeds=(0, 1))
    runs = ablation.runs()
    for run in runs:
        create_run(run.path, ablation.capture, run.config)
    initialise(runs[0].path, silent)
    return runs


def load(run: RowRun) -> MotionMasks:
    spec = run.folder.read_spec()
    return masks_of_run(run.folder, spec.open_capture(), spec.config)


def test_masks_of_a_row_are_changed_before_points_are_found(runs: list[RowRun]) -> None:
    full, grown, *_ = runs
    stages: list[str] = []
    initialise_run(grown, runs, lambda progress: stages.append(progress.stage))
    assert list(dict.fromkeys(stages)) == ["masks", "frames", "points"]
    before, after = load(full), load(grown)
    assert after.cameras == before.cameras == (0, 2, 3)
    for camera in after.cameras:
        for frame in range(4):
            np.testing.assert_array_equal(after.mask(camera, frame), grown_to_share(before.mask(camera, frame), 0.6))
    assert moving_share(grown) == after.share()
    assert grown.folder.near_planes.read_bytes() != full.folder.near_planes.read_bytes()


def test_masks_are_shared_between_seeds_unless_they_vary(runs: list[RowRun]) -> None:
    for run in runs[1:]:
        initialise_run(run, runs, silent)
    masks = {(run.row.name, run.seed): mask_file(run.folder.masks, 0) for run in runs}
    assert masks["full", 0].samefile(masks["full", 1])
    assert masks["masks-60", 0].samefile(masks["masks-60", 1])
    assert masks["masks-blobs", 0].read_bytes() != masks["masks-blobs", 1].read_bytes()
    assert len({run.folder.near_planes.read_bytes() for run in runs}) == 6


def test_masks_that_are_there_are_used_by_a_resumed_stage(runs: list[RowRun]) -> None:
    run = runs[3]  # the full method with another seed

    def stop_at_points(progress: Progress) -> None:
        if progress.stage == "points":
            raise StageStopped

    with pytest.raises(StageStopped):
        initialise(run.path, stop_at_points)
    written = mask_file(run.folder.masks, 0).stat().st_mtime_ns
    stages: list[str] = []
    initialise(run.path, lambda progress: stages.append(progress.stage))
    assert set(stages) == {"frames", "points"}
    assert mask_file(run.folder.masks, 0).stat().st_mtime_ns == written


def test_where_there_are_no_hard_links_files_are_copied(runs: list[RowRun], monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(target: Path, source: Path) -> None:
        raise OSError

    monkeypatch.setattr(Path, "hardlink_to", no_links)
    initialise_run(runs[3], runs, silent)
    full, other = runs[0].folder, runs[3].folder
    ours, theirs = mask_file(other.masks, 0), mask_file(full.masks, 0)
    assert not ours.samefile(theirs)
    assert ours.read_bytes() == theirs.read_bytes()
