"""A tiny benchmark that the tests of its parts share."""

from __future__ import annotations

import pytest

from hgs_core.base.progress import Progress
from hgs_core.bench.raster.raster_bench import RasterReport, bench_raster
from hgs_core.bench.raster.raster_settings import BenchSettings
from hgs_core.bench.raster.raster_sizes import Size

SMALL, LARGE = Size(300, 64, 48), Size(400, 75, 41)


@pytest.fixture(scope="session")
def heard() -> list[Progress]:
    """The progress of `report`."""
    return []


@pytest.fixture(scope="session")
def report(heard: list[Progress]) -> RasterReport:
    """Every backend that is installed, two sizes, errors at the first."""
    settings = BenchSettings.of(sizes=(SMALL, LARGE), threads=(1, 2), truth=(SMALL,), seconds=1e-3, dynamic_share=0.25)
    return bench_raster(settings, heard.append)
