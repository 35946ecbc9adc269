"""`benchmarks.device_raster` with Triton itself, on a scene too small for figures of speed."""

from __future__ import annotations

import json

import pytest

from benchmarks.device_raster import main


def test_the_point_is_within_the_bounds(capsys: pytest.CaptureFixture[str]) -> None:
    """With Triton itself; tests/benchmarks/test_device_raster.py tests the measurements."""
    arguments = ["--sizes", "8@16x16", "--seconds", "0.001", "--json"]
    assert main(arguments) == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert (point["size"], point["rasterizer"]) == ("8@16x16", "triton")
    assert point["image_error"] <= 1e-6
    assert point["gradient_error"] <= 1e-5
