"""Splats on the screen against the projection of the float64 reference."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.render.moment import moment_of_dynamic, moment_of_static
from hgs_core.render.projection import project as project_reference
from hgs_core.render.triton.screen import project
from tests.hgs_core.render.scenes import dynamic_splats, static_splats
from tests.hgs_core.render.triton.small import view
from tests.interpreted_triton import DEVICE
from tests.tolerances import assert_close


@pytest.mark.parametrize("antialiased", [False, True])
def test_the_same_splats_are_drawn_at_the_same_places(antialiased: bool) -> None:
    seen = view(antialiased=antialiased)
    static, dynamic = (
        splats.map(lambda array: array.float().to(DEVICE)) for splats in (static_splats(40), dynamic_splats(40))
    )
    if antialiased:
        static.log_scales.sub_(3)  # thin enough to fade
    screen = project(static, dynamic, seen, torch.device(DEVICE))
    moments = (moment_of_static(static), moment_of_dynamic(dynamic, seen.time))
    for first, moment in zip((0, 40), moments, strict=True):
        truth = project_reference(moment, seen.camera, antialiased)
        rows = first + truth.index
        drawn = torch.isfinite(screen.depths[first : first + 40])
        assert torch.nonzero(drawn)[:, 0].tolist() == truth.index.tolist()
        assert_close(screen.depths[rows].cpu(), truth.depths.cpu(), "depth")
        assert_close(screen.places[rows, :2].cpu(), truth.means.cpu(), "mean")
        assert_close(torch.exp2(screen.splats[rows, 3]).cpu(), truth.opacities.cpu(), "opacity")
        assert_close(screen.splats[rows, 4:7].cpu(), truth.rgb.cpu(), "colour")
        low = np.floor((truth.means - truth.half_sizes).cpu().numpy()).clip(0)
        columns = screen.boxes[rows].cpu().numpy()
        # A box may be smaller by a pixel whose centre the ellipse does not reach, and never larger by more than one.
        assert (np.abs(columns[:, [0, 2]] - low) <= 1).all()


def test_statics_come_first_and_no_set_is_needed() -> None:
    empty = project(None, None, view(), torch.device(DEVICE))
    assert (len(empty.depths), empty.statics) == (0, 0)
    dynamic = dynamic_splats(5).map(lambda array: array.float().to(DEVICE))
    assert project(None, dynamic, view(), torch.device(DEVICE)).statics == 0
