"""Parameters that no picture can show are refused by name, and only those that are looked at."""

from __future__ import annotations

import dataclasses
import math
import re

import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.comparison import BACKENDS, every_backend
from tests.hgs_core.render.dead_splats import check_the_dead_are_not_looked_at
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

STATIC = [field.name for field in dataclasses.fields(StaticSplats)]
DYNAMIC = [field.name for field in dataclasses.fields(DynamicSplats)]


@every_backend
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", STATIC)
def test_a_static_parameter_is_named(backend: str, field: str, value: float) -> None:
    splats = static_splats(40, dtype=torch.float32)
    getattr(splats, field)[17].view(-1)[-1] = value
    with pytest.raises(InputError, match=rf"^static splats: {field}\[17\] is {value}; remove"):
        BACKENDS[backend](splats, dynamic_splats(5, dtype=torch.float32), View(camera()))


@every_backend
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", DYNAMIC)
def test_a_dynamic_parameter_is_named(backend: str, field: str, value: float) -> None:
    splats = dynamic_splats(40, dtype=torch.float32)
    splats.time_log_precisions[:] = -5
    splats.opacity_logits[:] = 1
    getattr(splats, field)[17].view(-1)[-1] = value
    with pytest.raises(InputError, match=rf"^dynamic splats: {field}\[17\] is {value}; remove"):
        BACKENDS[backend](static_splats(5, dtype=torch.float32), splats, View(camera(), 0.4))


@every_backend
def test_the_first_of_several_is_named(backend: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.rgb[2] = math.nan
    splats.log_scales[30] = math.inf
    splats.log_scales[20] = math.nan
    with pytest.raises(InputError, match=r"log_scales\[20\] is nan"):
        BACKENDS[backend](splats, None, View(camera()))


@every_backend
@pytest.mark.parametrize("field", STATIC)
def test_statics_out_of_sight_are_looked_at(backend: str, field: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.means[3, 2] = -5
    getattr(splats, field)[3].view(-1)[0] = math.nan
    with pytest.raises(InputError, match=rf"{field}\[3\] is nan"):
        BACKENDS[backend](splats, None, View(camera()))


@every_backend
@pytest.mark.parametrize("field", STATIC)
def test_statics_too_faint_to_be_seen_are_looked_at(backend: str, field: str) -> None:
    splats = static_splats(40, dtype=torch.float32)
    splats.opacity_logits[39] = -50
    getattr(splats, field)[39].view(-1)[-1] = math.inf
    with pytest.raises(InputError, match=rf"{field}\[39\] is inf"):
        BACKENDS[backend](splats, None, View(camera()))


@every_backend
@pytest.mark.parametrize("value", [1.01e18, -3e38])
def test_a_colour_beyond_the_limit_is_named(backend: str, value: float) -> None:
    splats, moving = static_splats(40, dtype=torch.float32), dynamic_splats(40, dtype=torch.float32)
    splats.opacity_logits[39] = -50
    splats.rgb[39, 1] = value
    with pytest.raises(InputError, match=re.escape(f"static splats: rgb[39] is {value:g}; give it")):
        BACKENDS[backend](splats, None, View(camera()))
    moving.time_log_precisions[:] = -5
    moving.opacity_logits[:] = 1
    moving.rgb[7, 2] = value
    with pytest.raises(InputError, match=r"^dynamic splats: rgb\[7\] is "):
        BACKENDS[backend](None, moving, View(camera(), 0.4))


@every_backend
def test_dead_splats_are_not_looked_at(backend: str) -> None:
    splats = dynamic_splats(40, dtype=torch.float32)
    splats.time_log_precisions[:] = 3
    check_the_dead_are_not_looked_at(splats, lambda splats: BACKENDS[backend](None, splats, View(camera(), 0.4)))
