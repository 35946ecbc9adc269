"""`hgs bench raster --backends triton`, on a scene too small to say anything about speed."""

from __future__ import annotations

import importlib.util
import json

import pytest

from server.cli import main

TINY = ["bench", "raster", "--backends", "triton", "--sizes", "8@16x16", "--seconds", "0.001"]


def test_the_point_is_within_the_bounds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TINY, "--json"]) == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert (point["size"], point["rasterizer"]) == ("8@16x16", "triton")
    assert point["image_error"] <= 1e-6
    assert point["gradient_error"] <= 1e-5


@pytest.mark.skipif(importlib.util.find_spec("gsplat") is not None, reason="gsplat is installed")
def test_a_missing_comparator_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TINY, "--against", "gsplat"]) == 2
    assert "pip install gsplat==1.5.3" in capsys.readouterr().err


def test_a_comparator_needs_triton(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "raster", "--backends", "cpu", "--against", "gsplat"]) == 2
    assert "--backends triton" in capsys.readouterr().err
