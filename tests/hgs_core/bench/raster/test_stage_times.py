from __future__ import annotations

import os

import numpy as np
import pytest
import torch

from hgs_core.base.cores import core_count
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.stage_times import kernel_times, training_times, using_threads
from hgs_core.bench.raster.workload import Workload
from hgs_core.native import library
from hgs_core.render.rasterize import rasterize


@pytest.fixture(scope="module")
def workload() -> Workload:
    return Workload.of(Size(200, 40, 24), 0, 0.25)


def test_parts_of_an_iteration_are_no_longer_than_the_whole(workload: Workload) -> None:
    timing = training_times(workload, "reference", 1e-3)
    assert timing.repeats >= 3
    assert min(timing.least) > 0
    for times in (timing.least, timing.median):
        assert times.iteration > max(times[1:])
    assert timing.least.iteration <= timing.median.iteration


@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_every_iteration_sees_the_same_scene(workload: Workload, backend: str) -> None:
    if backend == "cpu" and not library.available():
        pytest.skip("hgs was built without its C++ kernels")
    before = {name: array.copy() for name, array in workload.scene.static.items()}
    training_times(workload, backend, 1e-3)
    for name, array in workload.scene.static.items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


@pytest.mark.skipif(not library.available(), reason="hgs was built without its C++ kernels")
def test_kernels_are_timed_on_the_picture_that_training_draws(workload: Workload) -> None:
    times = kernel_times(workload, 1e-3).median
    assert min(times.project, times.bin, times.composite, times.composite_backward, times.project_backward) > 0
    static, dynamic = workload.static().map(lambda array: array.requires_grad_(True)), workload.dynamic()
    rasterize(static, dynamic, workload.camera, workload.scene.time, backend="reference").rgb.sum().backward()
    assert static.rgb.grad is not None
    drawn = int(static.rgb.grad.any(1).sum())
    assert drawn <= times.visible_static <= len(static)
    assert times.evaluations >= times.tile_entries >= times.visible_static + times.visible_dynamic


def test_threads_are_the_callers_again_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HGS_THREADS", raising=False)
    torch_threads = torch.get_num_threads()
    with using_threads(3, "reference"):
        assert core_count() == torch.get_num_threads() == 3
    assert "HGS_THREADS" not in os.environ
    assert torch.get_num_threads() == torch_threads
    monkeypatch.setenv("HGS_THREADS", "2")
    with using_threads(3, "cpu"):
        assert (core_count(), torch.get_num_threads()) == (3, 1)
    assert os.environ["HGS_THREADS"] == "2"
