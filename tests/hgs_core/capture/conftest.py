"""Small captures that the tests make and then break."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

SAMPLE = Path(__file__).resolve().parents[3] / "samples" / "studio"
WIDTH, HEIGHT, FRAMES = 64, 48, 6


def grey_level(camera: int, frame: int) -> int:
    """The grey of a synthetic picture: it tells which picture it is."""
    return 20 + 60 * camera + 10 * frame


def encode_video(
    path: Path, levels: list[int], *, rate: int = 30, gop: int = 4, size: tuple[int, int] = (64, 48)
) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=rate, options={"crf": "0", "bf": "2", "g": str(gop)})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv444p"
        for level in levels:
            picture = np.full((size[1], size[0], 3), level, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())


def llff_row(
    position: tuple[float, float, float], *, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> npt.NDArray[np.float64]:
    """A camera that looks along the world's +z with +y down: columns down, right, back, position, (h, w, focal)."""
    down, right, back = (0, 1, 0), (1, 0, 0), (0, 0, -1)
    matrix = np.stack([down, right, back, position, (size[1], size[0], 50.0 * size[0] / WIDTH)], axis=1)
    return np.concatenate((matrix.reshape(-1).astype(float), [1.0, 10.0]))


def write_masks(folder: Path, *, frames: Sequence[int] = range(6), size: tuple[int, int] = (64, 48)) -> Path:
    """Masks of one camera: the columns from 8 on, as many as the frame's number, belong to object 3."""
    folder.mkdir(parents=True)
    for frame in frames:
        mask = np.zeros((size[1], size[0]), np.uint8)
        mask[:, 8 : 8 + frame] = 3
        Image.fromarray(mask).save(folder / f"{frame:05d}.png")
    return folder.parent


@pytest.fixture
def write_video() -> Callable[..., None]:
    """Return `encode_video`."""
    return encode_video


@pytest.fixture
def sample() -> Path:
    """The bundled capture."""
    return SAMPLE


@pytest.fixture
def n3dv(tmp_path: Path) -> Path:
    """Two cameras, six grey frames."""
    root = tmp_path / "n3dv"
    root.mkdir()
    for camera in (0, 1):
        encode_video(root / f"cam{camera:02d}.mp4", [grey_level(camera, frame) for frame in range(FRAMES)])
    np.save(root / "poses_bounds.npy", np.stack([llff_row((0, 0, 0)), llff_row((1, 0, 0))]))
    return root


@pytest.fixture
def panoptic(tmp_path: Path) -> Path:
    """Two cameras, called 3 and 17, six grey frames and masks."""
    root = tmp_path / "panoptic"
    names = ("3", "17")
    meta: dict[str, Any] = {"w": WIDTH, "h": HEIGHT, "k": [], "w2c": [], "fn": [], "cam_id": []}
    for column, name in enumerate(names):
        for kind in ("ims", "seg"):
            (root / kind / name).mkdir(parents=True)
        for frame in range(FRAMES):
            level = grey_level(column, frame)
            Image.new("RGB", (WIDTH, HEIGHT), (level,) * 3).save(root / "ims" / name / f"{frame:06d}.jpg")
            mask = np.zeros((HEIGHT, WIDTH), np.uint8)
            mask[10:20, 5 * column + frame] = 255
            Image.fromarray(mask).save(root / "seg" / name / f"{frame:06d}.png")
    for frame in range(FRAMES):
        poses = [np.eye(4), np.eye(4)]
        poses[1][0, 3] = -1.0
        meta["k"].append([[[50.0, 0, 32.5], [0, 51.0, 23.5], [0, 0, 1]]] * 2)
        meta["w2c"].append([pose.tolist() for pose in poses])
        meta["fn"].append([f"{name}/{frame:06d}.jpg" for name in names])
        meta["cam_id"].append([int(name) for name in names])
    (root / "train_meta.json").write_text(json.dumps(meta))
    return root


@pytest.fixture
def edit_meta(panoptic: Path) -> Callable[[Callable[[dict[str, Any]], None]], None]:
    """Change train_meta.json in place."""

    def edit(change: Callable[[dict[str, Any]], None]) -> None:
        path = panoptic / "train_meta.json"
        meta = json.loads(path.read_text())
        change(meta)
        path.write_text(json.dumps(meta))

    return edit
