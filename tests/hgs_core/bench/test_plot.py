"""The figure of scripts/plot_raster.py."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import ModuleType

import pytest

from hgs_core.bench.raster.raster_bench import RasterReport

SCRIPT = Path(__file__).resolve().parents[3] / "scripts" / "plot_raster.py"


@pytest.fixture(scope="module")
def plot() -> ModuleType:
    spec = importlib.util.spec_from_file_location("plot_raster", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def words(figure: str) -> list[str]:
    return [element.text or "" for element in ElementTree.fromstring(figure).iter("{http://www.w3.org/2000/svg}text")]


def test_figure_names_what_was_measured(plot: ModuleType, report: RasterReport) -> None:
    shown = words(plot.figure(json.loads(json.dumps(report.to_json()))))
    for point in report.points:
        if point.threads == 1:
            assert point.size in shown
    assert "batched torch" in shown


def test_figure_of_one_backend_without_errors(plot: ModuleType, report: RasterReport) -> None:
    points = tuple(dataclasses.replace(p, errors=None) for p in report.points if p.backend == "reference")
    alone = dataclasses.replace(report, points=points, speedups=())
    shown = words(plot.figure(json.loads(json.dumps(alone.to_json()))))
    assert "no errors were measured" in shown
    assert "the cpu backend was not measured" in shown


def test_figure_needs_no_other_file(plot: ModuleType, report: RasterReport) -> None:
    figure = plot.figure(json.loads(json.dumps(report.to_json())))
    for link in ("href", "url(", "@import", "<script"):
        assert link not in figure
