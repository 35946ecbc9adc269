"""`hgs bench codec`, on a few splats."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hgs_core.interchange import export_scene
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from server.cli import main


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    rng = np.random.default_rng(0)
    static = StaticSplats(
        *(
            rng.normal(size=shape).astype(np.float32) * scale + offset
            for shape, scale, offset in (
                ((200, 3), 1, 0), ((200, 3), 0.3, -2.5), ((200, 4), 1, 0), ((200,), 1, 1), ((200, 3), 0.1, 0.5),
            )
        )
    )  # fmt: skip
    scene = HybridScene(static, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    export_scene(scene, tmp_path / "cloud.ply", cameras=[])
    return tmp_path / "cloud.ply"


def test_bytes_errors_and_rates_of_a_still_cloud(cloud: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = cloud.parent / "codec.json"
    assert main(["bench", "codec", str(cloud), "--sweep", "0.5,4", "--json", str(file)]) == 0
    report = json.loads(file.read_text())
    fine, coarse = report["sweep"]
    assert fine["bytes_static"] > coarse["bytes_static"]
    assert fine["loss"] < coarse["loss"]
    assert [point["name"] for point in report["budgets"]] == ["default", "low"]
    assert report["budgets"][0]["loss"] <= 0.1
    assert (report["splats_static"], report["splats_dynamic"], report["bytes_splatv"] > 64 * 1024) == (200, 0, True)
    assert set(report["errors"]) == {"spz 2", "spz 3", "default", "low"}
    assert report["errors"]["spz 3"]["rotation"] < report["errors"]["spz 2"]["rotation"]
    assert report["errors"]["spz 2"]["position"] == pytest.approx(1 / 4096 / 12**0.5, rel=0.1)
    assert report["decode_rates"]["static"] > 0
    assert report["prefix_loss"] > 0
    assert "decoding by one core" in capsys.readouterr().out


def test_a_source_that_is_none_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "codec", str(tmp_path / "nothing")]) == 2
    assert "is not a run" in capsys.readouterr().err
