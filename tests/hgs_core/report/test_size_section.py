"""Bytes of the section against the manifest's and the files' own."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.codec.format.attributes import Kind
from hgs_core.report.scene_sizes import CONTAINER, ChunkSize
from hgs_core.report.size_section import size_section
from hgs_core.report.sources import FinishedRun, read_run

CHUNKS = [
    ChunkSize(Kind.STATIC, -1, 10, {"position": 600, "rgb": 300, CONTAINER: 50}),
    ChunkSize(Kind.STATIC, -1, 40, {"position": 1400, CONTAINER: 50}),
    ChunkSize(Kind.DYNAMIC, 2, 5, {"position": 100, "velocity": 200, "jerk": 30, CONTAINER: 20}),
]


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


def rows(html: str) -> dict[str, list[str]]:
    found = re.findall(r'<tr><th scope="row">([^<]*)</th>(.*?)</tr>', html)
    return {name: re.findall("<td>([^<]*)</td>", cells) for name, cells in found}


def test_the_table_adds_up_the_streams_of_all_chunks(finished: FinishedRun) -> None:
    table = rows(size_section(finished, CHUNKS))
    assert table["position"] == ["2,000", "40.00", "100", "20.00"]
    assert table["rgb"] == ["300", "6.00", "-", "-"]
    assert table["velocity"] == ["-", "-", "200", "40.00"]
    assert table["container"] == ["100", "2.00", "20", "4.00"]
    assert table["all"] == ["2,400", "48.00", "350", "70.00"]
    assert list(table)[-2:] == ["container", "all"]


def test_bars_are_by_attribute_the_largest_first_and_the_manifest_last(finished: FinishedRun) -> None:
    manifest = finished.folder.manifest.stat().st_size
    tips = re.findall(r"<title>(\w+), (\w+): ([\d,]+) bytes</title>", size_section(finished, CHUNKS))
    assert tips[:2] == [("position", "static", "2,000"), ("position", "dynamic", "100")]
    assert ("manifest", "manifest", f"{manifest:,}") in tips


def test_columns_are_layers_with_related_attributes_together(finished: FinishedRun) -> None:
    html = size_section(finished, CHUNKS)
    assert "static layer 2 (40 splats), position: 1,400 bytes" in html
    assert "dynamic layer 1 (5 splats, slice 3), motion: 230 bytes" in html
    assert "static layer 1 (10 splats), colour: 300 bytes" in html


def test_the_total_is_that_of_eval_json(finished: FinishedRun) -> None:
    assert f"{finished.scores['bytes_total']:,} bytes: chunks and a manifest of" in size_section(finished, CHUNKS)


def test_a_scene_without_splats_has_a_manifest_alone(finished: FinishedRun) -> None:
    html = size_section(finished, [])
    assert "By layer" not in html
    assert rows(html)["all"] == ["-", "-", "-", "-"]
