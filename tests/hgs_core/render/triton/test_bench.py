"""`hgs bench raster --backends triton`, on a scene too small to say anything about speed."""

from __future__ import annotations

import json

import pytest

from server.cli import main


def test_the_point_is_within_the_bounds(capsys: pytest.CaptureFixture[str]) -> None:
    """With Triton itself; what is measured of it is tested in tests/hgs_core/bench/test_device_raster.py."""
    arguments = ["--backends", "triton", "--sizes", "8@16x16", "--seconds", "0.001", "--json"]
    assert main(["bench", "raster", *arguments]) == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert (point["size"], point["rasterizer"]) == ("8@16x16", "triton")
    assert point["image_error"] <= 1e-6
    assert point["gradient_error"] <= 1e-5
