from __future__ import annotations

import numpy as np
import torch

from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.workload import Workload


def test_scenes_of_as_many_splats_are_the_same_whatever_the_picture() -> None:
    small, large = (Workload.of(Size(50, *side), 3, 0.2) for side in ((16, 12), (40, 24)))
    for (_, a), (_, b) in zip(small.scene.static.items(), large.scene.static.items(), strict=True):
        np.testing.assert_array_equal(a, b)
    assert (large.camera.width, large.camera.height, tuple(large.target.shape)) == (40, 24, (3, 24, 40))
    assert not np.array_equal(Workload.of(Size(50, 16, 12), 4, 0.2).scene.static.means, small.scene.static.means)


def test_tensors_share_the_scenes_memory_unless_they_are_of_another_type() -> None:
    workload = Workload.of(Size(50, 16, 12), 0, 0.2)
    workload.scene.static.means[0] = 7
    assert workload.static().means[0].tolist() == [7, 7, 7]
    doubles = workload.static(torch.float64)
    workload.scene.static.means[0] = 8
    assert doubles.means.dtype == torch.float64
    assert doubles.means[0].tolist() == [7, 7, 7]


def test_a_scene_has_dynamic_splats_only_where_a_share_is_asked_for() -> None:
    assert Workload.of(Size(50, 16, 12), 0, 0.0).dynamic() is None
    dynamic = Workload.of(Size(50, 16, 12), 0, 0.2).dynamic(torch.float64)
    assert dynamic is not None
    assert (len(dynamic), dynamic.motion.dtype) == (10, torch.float64)
