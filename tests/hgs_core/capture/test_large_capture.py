"""The large capture that scripts/make_large_capture.py makes of a small one."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from scripts.make_large_capture import covering, main
from tests.hgs_core.capture.layouts import write_video

SOURCE = (64, 48)
FOCAL = 60.0


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """Two cameras that see a round spot of 10 pixels in a corner."""
    folder = tmp_path / "source"
    rows, columns = np.mgrid[: SOURCE[1], : SOURCE[0]] + 0.5
    picture = np.where((columns - 18) ** 2 + (rows - 20) ** 2 < 100, 220, 40).astype(np.uint8)
    for name in ("cam00", "cam01"):
        write_video(folder / f"{name}.mp4", [np.repeat(picture[..., None], 3, axis=2)] * 2)
    poses = np.zeros((2, 17))
    poses[:, :15] = np.hstack((np.eye(3), [[0.0], [0.0], [0.0]], [[SOURCE[1]], [SOURCE[0]], [FOCAL]])).reshape(-1)
    poses[:, 15:] = 1.0, 10.0
    np.save(folder / "poses_bounds.npy", poses)
    return folder


def made(source: Path, monkeypatch: pytest.MonkeyPatch, size: str) -> Capture:
    target = source.parent / "target"
    monkeypatch.setattr(sys, "argv", ["make", str(source), str(target), "--size", size, "--frames", "2"])
    main()
    return open_capture(target)


@pytest.mark.parametrize(
    ("size", "line"),
    [
        ("128x96", ""),
        ("192x96", "of 192x144 pixels the middle 192x96 are kept"),
        ("64x96", "of 128x96 pixels the middle 64x96 are kept"),
    ],
)
def test_pictures_keep_their_shapes_and_rays_at_every_aspect(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], size: str, line: str
) -> None:
    capture = made(source, monkeypatch, size)
    said = capsys.readouterr().out
    assert line in said
    assert bool(said) is bool(line)
    camera, (width, height) = capture.cameras[1], map(int, size.split("x"))
    assert (camera.width, camera.height) == (width, height)
    rows, columns = np.nonzero(capture.frame(1, 1)[..., 1] > 130)
    focal = camera.fx / FOCAL  # how much wider and higher everything is shown
    assert np.ptp(rows) + 1 == pytest.approx(20 * focal, abs=1.5)
    assert rows.mean() + 0.5 - camera.cy == pytest.approx((20 - SOURCE[1] / 2) * focal, abs=0.5)
    if width >= 128:  # else the spot is cut off
        assert np.ptp(columns) + 1 == pytest.approx(20 * focal, abs=1.5)
        assert columns.mean() + 0.5 - camera.cx == pytest.approx((18 - SOURCE[0] / 2) * focal, abs=0.5)


@pytest.mark.parametrize("size", ["128", "128x", "0x96", "129x96", "128x96x3", "-2x4"])
def test_sizes_that_a_video_cannot_have_are_refused(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], size: str
) -> None:
    with pytest.raises(SystemExit):
        made(source, monkeypatch, size)
    assert "two even numbers" in capsys.readouterr().err or size.startswith("-")
    assert not (source.parent / "target").exists()


def test_the_covering_size_of_an_odd_remainder_keeps_the_middle() -> None:
    width, height = covering((512, 384), (1280, 722))
    assert (width, (height - 722) % 2) == (1280, 0)
    assert height == pytest.approx(960, abs=1)
