from __future__ import annotations

from typing import Any

import pytest
import torch

from hgs_core.bench.raster import accuracy
from hgs_core.bench.raster.raster_settings import BenchSettings
from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.workload import Workload
from hgs_core.render.rasterize import rasterize

WORKLOAD = Workload.of(Size(200, 40, 24), 0, 0.25)


@pytest.mark.parametrize("backend", BenchSettings.of().backends)
def test_backends_are_close_to_float64(backend: str) -> None:
    errors = accuracy.errors(WORKLOAD, [backend])[backend]
    assert 0 < errors.image < 1e-5
    assert set(errors.gradients) == {
        *(f"static.{name}" for name, _ in WORKLOAD.static().items()),
        *(f"dynamic.{name}" for name, _ in WORKLOAD.scene.dynamic.items()),  # type: ignore[union-attr]
    }
    assert all(0 < error < 1e-3 for error in errors.gradients.values()), errors.gradients


def test_errors_are_relative_to_the_norm_of_the_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    def brighter(*arguments: Any, backend: str, **options: Any) -> Any:
        """The reference, its picture 1 % and its gradients 5 % too large in float32."""
        render = rasterize(*arguments, backend="reference", **options)
        if render.rgb.dtype == torch.float64:
            return render
        return render._replace(rgb=1.05 * render.rgb - 0.04 * render.rgb.detach())

    monkeypatch.setattr(accuracy, "rasterize", brighter)
    errors = accuracy.errors(WORKLOAD, ["reference"])["reference"]
    assert errors.image == pytest.approx(0.01, rel=1e-3)
    for name, error in errors.gradients.items():
        assert error == pytest.approx(0.05, rel=0.02), name
