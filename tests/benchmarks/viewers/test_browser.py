"""Parts without a browser; tests/web_client/test_browser.py opens the viewer itself."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_floats, canvas_pixels, find_chromium, psnr


def program(folder: Path, name: str) -> str:
    path = folder / name
    path.write_text("#!/bin/sh\n")
    path.chmod(0o755)
    return str(path)


def test_the_browser_is_the_one_chosen_or_the_first_known_on_the_path(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("HGS_CHROMIUM", raising=False)
    assert find_chromium() is None
    chrome = program(tmp_path, "google-chrome")
    assert find_chromium() == chrome
    chromium = program(tmp_path, "chromium")
    assert find_chromium() == chromium
    monkeypatch.setenv("HGS_CHROMIUM", chrome)
    assert find_chromium() == chrome
    monkeypatch.setenv("HGS_CHROMIUM", str(tmp_path / "absent"))
    assert find_chromium() is None  # and no other in its place


def test_bytes_and_floats_are_compared_on_one_scale() -> None:
    """Off by 0.1 everywhere is 20 dB; values beyond [0, 1] are shown as their limit."""
    grey = np.full((2, 3, 3), 51, np.uint8)
    assert psnr(grey, np.full((2, 3, 3), 0.3, np.float32)) == pytest.approx(20.0, abs=1e-4)
    assert psnr(grey, np.full((2, 3, 3), 0.2)) == math.inf
    assert psnr(np.full((1, 1, 3), -5.0), np.zeros((1, 1, 3), np.uint8)) == math.inf


@pytest.mark.parametrize(("read", "dtype"), [(canvas_pixels, np.uint8), (canvas_floats, np.float32)])
def test_a_canvas_comes_row_by_row_without_its_alpha(read: object, dtype: type) -> None:
    rgba = np.arange(2 * 3 * 4).reshape(2, 3, 4).astype(dtype)
    asked: list[bool] = []

    def evaluate(script: str, floats: bool) -> dict[str, object]:
        asked.append(floats)
        return {"width": 3, "height": 2, "data": base64.b64encode(rgba.tobytes()).decode()}

    found = read(SimpleNamespace(evaluate=evaluate))  # type: ignore[operator]
    np.testing.assert_array_equal(found, rgba[..., :3])
    assert asked == [dtype is np.float32]
