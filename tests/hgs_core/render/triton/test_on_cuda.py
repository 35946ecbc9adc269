"""At full size on a CUDA device: every hard case and a bench scene against the float64 reference."""

from __future__ import annotations

import dataclasses

import pytest

from hgs_core.bench.raster.accuracy import errors
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.workload import Workload
from tests.hgs_core.render.comparison import check_case, compare
from tests.hgs_core.render.hard_cases import CASES
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.hgs_core.render.triton.small import view
from tests.interpreted_triton import DEVICE

pytestmark = [
    pytest.mark.gpu,
    pytest.mark.skipif(DEVICE != "cuda", reason="torch sees no CUDA device"),
]


@pytest.mark.parametrize("name", CASES)
def test_hard_cases(name: str) -> None:
    check_case(CASES[name](), "triton")


@pytest.mark.parametrize(("antialiased", "coefficients"), [(False, 4), (True, 4), (False, 6)])
def test_both_sets(antialiased: bool, coefficients: int) -> None:
    shot = dataclasses.replace(view(antialiased=antialiased, depth=True), camera=camera(150, 101))
    compare(static_splats(600), dynamic_splats(500, coefficients=coefficients), shot, "triton")


def test_a_bench_scene_is_within_the_bounds() -> None:
    found = errors(Workload.of(Size(20_000, 676, 507), 0, 0.2), ["triton"])["triton"]
    assert found.image <= 1e-6
    assert max(found.gradients.values()) <= 1e-5
