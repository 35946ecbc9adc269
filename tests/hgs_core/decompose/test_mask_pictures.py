from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.decompose.mask_pictures import export_masks


def masks(camera: int) -> Iterator[np.ndarray]:
    """Two frames of 3x4 pixels: one pixel of each moves, and it tells camera and frame."""
    for frame in range(2):
        mask = np.zeros((3, 4), bool)
        mask[frame, camera] = True
        yield mask


def test_a_folder_a_camera_holds_a_numbered_picture_a_frame(tmp_path: Path) -> None:
    export_masks(tmp_path / "deep" / "masks", ["left", "right"], masks, progress=silent)
    files = sorted(path.relative_to(tmp_path / "deep" / "masks") for path in tmp_path.rglob("*.png"))
    assert list(map(str, files)) == ["left/0000.png", "left/0001.png", "right/0000.png", "right/0001.png"]
    with Image.open(tmp_path / "deep" / "masks" / "right" / "0001.png") as picture:
        assert np.array(picture).tolist() == [[0, 0, 0, 0], [0, 255, 0, 0], [0, 0, 0, 0]]


def test_masks_are_called_by_the_numbers_given(tmp_path: Path) -> None:
    export_masks(tmp_path / "masks", ["left"], masks, numbers=lambda camera: [3, 5], progress=silent)
    assert sorted(path.name for path in (tmp_path / "masks" / "left").iterdir()) == ["0003.png", "0005.png"]


def test_progress_counts_the_cameras(tmp_path: Path) -> None:
    heard: list[Progress] = []
    export_masks(tmp_path / "masks", ["left", "right"], masks, progress=heard.append)
    assert [(one.stage, one.done, one.total) for one in heard] == [("export", n, 2) for n in (0, 1, 2)]


def test_an_empty_folder_is_taken_and_a_full_one_refused(tmp_path: Path) -> None:
    out = tmp_path / "masks"
    out.mkdir()
    export_masks(out, ["left"], masks, progress=silent)
    before = (out / "left" / "0000.png").read_bytes()
    with pytest.raises(InputError, match="masks: exists and is not empty; choose a new folder for --out"):
        export_masks(out, ["right"], masks, progress=silent)
    assert [path.name for path in out.iterdir()] == ["left"]
    assert (out / "left" / "0000.png").read_bytes() == before


def test_a_file_is_no_folder_for_masks(tmp_path: Path) -> None:
    (tmp_path / "masks").write_text("mine")
    with pytest.raises(InputError, match="exists"):
        export_masks(tmp_path / "masks", ["left"], masks, progress=silent)
    assert (tmp_path / "masks").read_text() == "mine"


def test_what_is_stopped_leaves_nothing_behind(tmp_path: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done == 1:
            raise StageStopped

    with pytest.raises(StageStopped):
        export_masks(tmp_path / "masks", ["left", "right"], masks, progress=stop)
    assert list(tmp_path.iterdir()) == []
