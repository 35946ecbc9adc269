from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.report.codec_section import codec_section


def point(coarseness: float, size: int, loss: float) -> dict[str, float]:
    return {"coarseness": coarseness, "bytes_static": size, "bytes_dynamic": 0, "loss": loss, "loss_held_out": loss / 2}


def test_the_curve_is_drawn_of_what_the_benchmark_wrote(tmp_path: Path) -> None:
    file = tmp_path / "codec.json"
    report = {"sweep": [point(0.5, 9000, 0.05), point(2, 4000, 0.6)], "budgets": [point(1, 6000, 0.1)]}
    file.write_text(json.dumps(report | {"bytes_splatv": 64000}))
    html = codec_section(file)
    assert "<svg" in html
    assert "cameras held out" in html
    assert "As .splatv: 64 kB" in html


def test_without_a_file_it_says_how_to_make_one(tmp_path: Path) -> None:
    assert "hgs bench codec RUN --json RUN/codec.json" in codec_section(tmp_path / "codec.json")


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "codec.json").write_text("{}")
    with pytest.raises(InputError, match=r"codec\.json: unreadable"):
        codec_section(tmp_path / "codec.json")
