"""The layout of a folder, and the refusal of a folder without one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture


@pytest.mark.parametrize(("layout", "names"), [("panoptic", ["3", "17"]), ("n3dv", ["cam00", "cam01"])])
def test_a_folder_is_opened_by_what_lies_in_it(layout: str, names: list[str], request: pytest.FixtureRequest) -> None:
    capture = open_capture(request.getfixturevalue(layout))
    assert [camera.name for camera in capture.cameras] == names
    assert len(capture.times) == 6


def test_of_two_layouts_in_one_folder_the_first_known_is_taken(panoptic: Path, n3dv: Path) -> None:
    for path in n3dv.iterdir():
        path.rename(panoptic / path.name)
    assert open_capture(panoptic).cameras[0].name == "3"


def test_an_empty_folder_is_to_get_videos(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"the folder is empty; put a video of each camera into it, cam00\.mp4 and so on$"
    ):
        open_capture(tmp_path)


def test_unknown_layout(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(InputError, match=r"no known layout.*train_meta\.json.*poses_bounds\.npy"):
        open_capture(tmp_path)


def test_missing_folder_and_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        open_capture(tmp_path / "nowhere")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="a file, not a folder"):
        open_capture(tmp_path / "file")


def test_heavy_libraries_wait_until_they_are_needed() -> None:
    code = (
        "import sys, hgs_core.capture.open, hgs_core.points.initial_points;"
        "assert not {'av', 'pycolmap', 'torch'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).resolve().parents[3])
