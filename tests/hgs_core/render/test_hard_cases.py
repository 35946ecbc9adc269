"""Every backend in float32 against the float64 reference where rasterizers break; the scenes are in hard_cases.py."""

from __future__ import annotations

import functools

import pytest
import torch

from hgs_core.render.types import View
from hgs_core.scene import StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.comparison import BACKENDS, Result, check_case, differentiate, every_backend
from tests.hgs_core.render.hard_cases import CASES, front


@functools.cache
def truth(name: str) -> Result:
    case = CASES[name]()
    return differentiate("reference", torch.float64, case.static, case.dynamic, case.view)


@pytest.mark.parametrize("name", CASES)
def test_the_case_is_what_it_says(name: str) -> None:
    result = truth(name)
    assert CASES[name]().drawn(result.render)
    for value in (*result.pictures().values(), *result.gradients().values()):
        assert torch.isfinite(value).all()


@every_backend
@pytest.mark.parametrize("name", CASES)
def test_float32_agrees_with_float64(name: str, backend: str) -> None:
    check_case(CASES[name](), backend, truth(name))


def screen_filling(count: int) -> StaticSplats[torch.Tensor]:
    return StaticSplats(
        torch.tensor([[0.0, 0.0, 1.0]]).repeat(count, 1),
        torch.full((count, 3), 12.0),
        torch.zeros(count, 4),
        torch.zeros(count),
        torch.zeros(count, 3),
    )


@every_backend
def test_more_tile_entries_than_can_be_counted_are_refused_before_memory_is_taken(backend: str) -> None:
    picture: Camera = front(65_535, 256)  # 2^16 tiles; the lists alone would take 16 GiB
    with pytest.raises(RuntimeError, match="more than 2\\^31 - 1"):
        BACKENDS[backend](screen_filling((1 << 15) + 1), None, View(picture))
