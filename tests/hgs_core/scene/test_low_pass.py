from __future__ import annotations

import re
from pathlib import Path

from hgs_core.scene.low_pass import COMPENSATION_MIN, LOW_PASS

ROOT = Path(__file__).resolve().parents[3]


def test_every_language_defines_the_same_filter_once() -> None:
    kernels = (ROOT / "hgs_core/native/src/screen.hpp").read_text()
    viewer = "".join(file.read_text() for file in sorted((ROOT / "web_client/src").rglob("*.ts")))
    assert [float(found) for found in re.findall(r"kLowPass = ([\d.]+)", kernels)] == [LOW_PASS]
    assert [float(found) for found in re.findall(r"LOW_PASS = ([\d.]+)", viewer)] == [LOW_PASS]
    assert str(COMPENSATION_MIN) in kernels
