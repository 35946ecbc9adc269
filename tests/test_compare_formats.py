"""scripts/compare_formats.py on a scene of letters."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.runs.source import Source
from scripts.compare_formats import compared, markdown
from tests.chirality import letters, views


def test_every_format_is_drawn_and_the_exact_ones_are_the_most_alike(tmp_path: Path) -> None:
    pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")
    source = Source(letters(moving=True), tuple(views(96, 72)), 30.0)
    found = {one.name: one for one in compared(source, tmp_path, 2.0, 96)}
    moving = {"moving.ply", "moving.4dgs", "frames"}
    assert set(found) == {"still.ply", "still.splat", "2.spz", "3.spz", "4.spz", "still.glb", "still.sog"} | moving
    assert min(found[name].worst for name in ("still.ply", "still.glb", "moving.ply", "frames")) > 90
    assert max(found[name].mean for name in ("still.splat", "2.spz", "3.spz", "4.spz", "moving.4dgs")) < 90
    assert all(one.worst <= one.mean for one in found.values())
    assert found["frames"].size == sum(file.stat().st_size for file in (tmp_path / "frames").iterdir())
    assert all((tmp_path / f"{name}.png").is_file() for name in found)
    assert "| 3.spz | " in markdown(list(found.values()))
