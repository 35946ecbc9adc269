"""Scenes small enough for an interpreter."""

from __future__ import annotations

import dataclasses
from typing import Any

from hgs_core.render.types import View
from tests.hgs_core.render.hard_cases import CASES, HardCase
from tests.hgs_core.render.scenes import camera

__all__ = ["BACKGROUND", "cropped", "view"]

BACKGROUND = (0.2, 0.5, 0.9)


def view(width: int = 28, height: int = 20, **options: Any) -> View:
    return View(camera(width, height), 0.4, BACKGROUND, **options)


def cropped(name: str) -> HardCase:
    """The upper left of a hard case's picture, 32x32 at most."""
    case = CASES[name]()
    whole = case.view.camera
    part = dataclasses.replace(whole, width=min(32, whole.width), height=min(32, whole.height))
    return dataclasses.replace(case, view=dataclasses.replace(case.view, camera=part))
