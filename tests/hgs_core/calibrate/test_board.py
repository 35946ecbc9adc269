from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.calibrate.board import Board, find_board, open_cv
from tests.hgs_core.calibrate.boards import BOARD, board_pose, photograph, rig


def test_corners_are_found_where_they_are_seen() -> None:
    pytest.importorskip("cv2")
    camera = rig()[2]
    (one,) = find_board(BOARD, 1, lambda _, frame: photograph(camera, frame + 1), 1, silent)
    assert len(one.corners) == (BOARD.columns - 1) * (BOARD.rows - 1)
    pose = board_pose(1)
    there = BOARD.corners[one.corners] @ pose[:3, :3].T + pose[:3, 3]
    np.testing.assert_allclose(one.xy, camera.project(there)[0], atol=0.6)
    assert np.abs(one.xy - camera.project(there)[0]).mean() < 0.25  # half a pixel would show


@pytest.mark.parametrize(
    ("values", "where"),
    [
        ({"columns": 2}, "--board"),
        ({"square": 0.0}, "--square"),
        ({"marker": 0.1}, "--marker"),
        ({"dictionary": "9X9_1"}, "--dictionary"),
    ],
)
def test_a_board_that_cannot_be_is_refused_by_the_option(values: dict[str, Any], where: str) -> None:
    described: dict[str, Any] = {"columns": 7, "rows": 5, "square": 0.08, "marker": 0.06} | values
    with pytest.raises(InputError) as refused:
        Board(**described)
    assert refused.value.where == where


def test_without_opencv_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(InputError, match=r"hgs\[board\]"):
        open_cv()
