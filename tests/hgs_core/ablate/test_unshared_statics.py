from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.ablate.unshared_statics import with_statics_at_rest
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene.splats import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene
from tests.tolerances import assert_close


@pytest.mark.parametrize("time", [0.0, 0.9])
def test_statics_at_rest_look_like_statics_in_every_segment(time: float) -> None:
    static, dynamic = synthetic_scene()
    numpy = [splats.map(Tensor.numpy) for splats in (static, dynamic)]
    scene = with_statics_at_rest(HybridScene(numpy[0], (Segment(0.0, 1.0, numpy[1]), Segment(1.0, 2.0, numpy[1]))))
    assert len(scene.static) == 0
    view = View(ring_of_cameras(3, 24, 18)[0], time, gradients="none")
    truth = rasterize_reference(static, dynamic, view).rgb.numpy().astype(np.float64)
    for segment in scene.segments:
        assert len(segment.dynamic) == len(static) + len(dynamic)
        copies = HybridScene(scene.static, (segment,)).map(torch.from_numpy)
        drawn = rasterize_reference(copies.static, copies.segments[0].dynamic, view).rgb
        assert_close(drawn.numpy(), truth)
