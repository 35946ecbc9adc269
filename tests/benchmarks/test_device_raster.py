"""Measurements of a device's rasterizers, with stand-ins for them on the CPU."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
import torch

from benchmarks import device_raster
from benchmarks.device_raster import DevicePoint, DeviceReport, bench_device_raster, device_report_text
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, silent
from hgs_core.bench.raster.raster_sizes import Size

SIZES = (Size(20, 16, 12), Size(30, 20, 12))


@pytest.fixture
def stand_ins(monkeypatch: pytest.MonkeyPatch) -> None:
    """The reference draws one grey, Triton 1 % too bright, gsplat 3 %; Triton's worst gradient is off by 0.25."""

    def brighter(factor: float) -> Any:
        def draw(static: Any, workload: Any) -> torch.Tensor:
            return factor * static.rgb.mean() * torch.ones(workload.target.shape, dtype=static.rgb.dtype)

        return draw

    monkeypatch.setattr(device_raster, "require_device", lambda: torch.device("cpu"))
    monkeypatch.setattr(device_raster, "_draw", lambda static, workload, backend: brighter(1.0)(static, workload))
    monkeypatch.setattr(device_raster, "_draw_triton", brighter(1.01))
    monkeypatch.setattr(device_raster, "_comparator", lambda name: brighter(1.03))
    off = {"triton": SimpleNamespace(gradients={"static.means": 0.125, "static.rgb": 0.25})}
    monkeypatch.setattr(device_raster, "errors", lambda workload, names: off)


@pytest.mark.usefixtures("stand_ins")
def test_every_rasterizer_is_measured_at_every_size_against_the_reference() -> None:
    heard: list[Progress] = []
    report = bench_device_raster(SIZES, 1e-4, 0, "gsplat", heard.append)
    assert [(p.size, p.rasterizer) for p in report.points] == [
        (str(size), name) for size in SIZES for name in ("triton", "gsplat")
    ]
    for point in report.points:
        triton = point.rasterizer == "triton"
        assert point.image_error == pytest.approx(0.01 if triton else 0.03, rel=1e-3)
        assert point.gradient_error == (0.25 if triton else None)
        assert point.repeats >= 3
        assert (point.forward > 0, point.forward_backward > 0, point.peak_bytes) == (True, True, None)
    assert [(one.done, one.total, one.figures["splats"]) for one in heard] == [
        (1, 4, 20),
        (2, 4, 20),
        (3, 4, 30),
        (4, 4, 30),
    ]


@pytest.mark.usefixtures("stand_ins")
def test_without_a_comparator_triton_is_measured_alone() -> None:
    report = bench_device_raster(SIZES[:1], 1e-4, 0, None, silent)
    assert [p.rasterizer for p in report.points] == ["triton"]
    assert report.to_json()["machine"]["device"] == "Triton's interpreter"


def test_an_unknown_comparator_is_refused_and_a_missing_one_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_raster, "require_device", lambda: torch.device("cpu"))
    with pytest.raises(InputError, match="--against: unknown rasterizer 'opengl'; use gsplat"):
        bench_device_raster(SIZES, 1e-4, 0, "opengl", silent)
    monkeypatch.setattr(device_raster.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"gsplat is not installed; pip install gsplat==1\.5\.3"):
        bench_device_raster(SIZES, 1e-4, 0, "gsplat", silent)


def test_the_text_has_milliseconds_and_mebibytes_and_dashes_for_what_was_not_measured() -> None:
    points = (
        DevicePoint("50k@8x9", "triton", 9, 0.0015, 0.0045, 300 << 20, 1.2e-7, 3.4e-6),
        DevicePoint("50k@8x9", "gsplat", 9, 0.0025, 0.0075, None, 1e-6, None),
    )
    head, _, _, first, second = device_report_text(
        DeviceReport({"device": "Big GPU", "torch": "2.13"}, points)
    ).splitlines()
    assert head == "Big GPU, torch 2.13"
    assert first.split() == ["50k@8x9", "triton", "1.50", "4.50", "300", "1.2e-07", "3.4e-06"]
    assert second.split() == ["50k@8x9", "gsplat", "2.50", "7.50", "-", "1.0e-06", "-"]
