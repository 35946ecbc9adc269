"""A run that was imported, so that it stands without the minutes of training."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.interchange import export_scene
from hgs_core.scene import HybridScene, Segment
from server.cli import main
from tests.synthetic import synthetic_scene, write_capture


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


@pytest.fixture(scope="session")
def splats(capture: Path) -> Path:
    """An STGS file of the capture's scene, whose times 0 to 1 are five frames."""
    static, dynamic = synthetic_scene()
    scene = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    export_scene(scene, capture / "x.ply", cameras=[])
    return capture / "x.ply"


@pytest.fixture(scope="module")
def run(capture: Path, splats: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "run"
    more = ["--capture", str(capture), "--hold-out", "2", "--duration", str(5 / 30)]
    assert main(["import", str(splats), "--out", str(out), *more]) == 0
    return out
