"""`hgs masks` on the command line: its files are read as given masks, and bad input leaves nothing behind."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.capture.open import open_capture
from server.cli import BAD_INPUT, main
from tests.synthetic import write_capture


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path, cameras=2, frames=4)
    return path


def test_exported_masks_are_taken_as_given_ones(
    capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "masks"
    assert main(["masks", str(capture), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert sorted(path.name for path in (out / "1").iterdir()) == [f"{frame:04d}.png" for frame in range(4)]
    with Image.open(out / "1" / "0002.png") as image:
        values = np.array(image)
    assert set(np.unique(values)) <= {0, 255}
    np.testing.assert_array_equal(open_capture(capture, masks=out).mask(1, 2), values > 0)


def test_masks_are_called_by_the_frames_of_their_camera(tmp_path: Path) -> None:
    """Camera 1 begins two frames later: the first moment that both see is frame 2 of camera 0."""
    write_capture(tmp_path / "capture", cameras=2, frames=6, late={"1": 2})
    out = tmp_path / "masks"
    assert main(["masks", str(tmp_path / "capture"), "--out", str(out)]) == 0
    assert sorted(path.name for path in (out / "0").iterdir()) == [f"{frame:04d}.png" for frame in range(2, 6)]
    assert sorted(path.name for path in (out / "1").iterdir()) == [f"{frame:04d}.png" for frame in range(4)]
    assert open_capture(tmp_path / "capture", masks=out).mask(0, 0) is not None


def test_a_folder_that_is_not_empty_is_left_alone(
    capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    assert main(["masks", str(capture), "--out", str(tmp_path)]) == BAD_INPUT
    assert "is not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_one_moment_has_no_masks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_capture(tmp_path / "capture", cameras=2, frames=1)
    assert main(["masks", str(tmp_path / "capture"), "--out", str(tmp_path / "masks")]) == BAD_INPUT
    assert "one moment" in capsys.readouterr().err
    assert not (tmp_path / "masks").exists()


def test_sam_without_its_library_or_weights_says_what_to_do(
    capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["masks", str(capture), "--out", str(tmp_path / "masks"), "--sam", str(tmp_path / "nowhere")]
    assert main(arguments) == BAD_INPUT
    told = capsys.readouterr().err
    assert ("does not exist" if importlib.util.find_spec("transformers") else "pip install 'hgs[sam]'") in told
    assert not (tmp_path / "masks").exists()
