"""Given depth and meshes compared with points of features."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from hgs_core.capture.open import open_capture
from hgs_core.check.given_depth import DepthAgreement, judge_given_depth
from hgs_core.points.matching import LONGEST_SIDE
from hgs_core.points.sfm import SparsePoints, triangulate
from hgs_core.scene.camera import Camera

SAMPLE = Path(__file__).resolve().parents[3] / "samples" / "studio"
GIVEN = (1, 5)


@pytest.fixture(scope="module")
def found() -> tuple[list[Camera], SparsePoints]:
    capture = open_capture(SAMPLE)
    cameras = [camera.within(LONGEST_SIDE) for camera in capture.cameras]
    return cameras, triangulate(capture.cameras, [capture.frame(index, 0) for index in range(len(cameras))])


def write_depths(folder: Path, found: tuple[list[Camera], SparsePoints], factor: float, noise: float = 0.0) -> Path:
    """Maps that are known around the points of features alone."""
    cameras, points = found
    random = np.random.default_rng(0)
    folder.mkdir()
    for index in GIVEN:
        values = np.zeros((cameras[index].height, cameras[index].width), np.uint16)
        pixels, depths = cameras[index].project(points.xyz[points.seen[:, index]])
        for (column, row), depth in zip(pixels.astype(int), depths, strict=True):
            values[row - 1 : row + 2, column - 1 : column + 2] = 5000 * factor * depth * random.normal(1, noise)
        Image.fromarray(values).save(folder / f"{cameras[index].name}.png")
    (folder / "depth.json").write_text(json.dumps({"scale": 0.0002}))
    return folder


@pytest.mark.parametrize(
    ("factor", "noise", "problems"),
    [
        (1.0, 0.0, []),
        (1.6, 0.0, [(r"the depth maps lie 1.6 times as far away as points of features", "depth.json to 0.000125")]),
        (1.0, 0.4, [("half of the depths of the depth maps differ by more than", "along the axis or along rays?")]),
    ],
)
def test_depths_are_compared_with_points(
    found: tuple[list[Camera], SparsePoints],
    tmp_path: Path,
    factor: float,
    noise: float,
    problems: list[tuple[str, str]],
) -> None:
    said, findings = judge_given_depth(open_capture(SAMPLE, depth=write_depths(tmp_path / "d", found, factor, noise)))
    assert len(said) == 1
    assert said[0].startswith("depth maps in 2 of 16 pictures: ")
    assert [(one.stops, p in one.problem, c in one.cure) for one, (p, c) in zip(findings, problems, strict=True)] == [
        (False, True, True) for _ in problems
    ]


def write_mesh(file: Path, corners: npt.NDArray[np.float64]) -> Path:
    lines = [f"v {x} {y} {z}\n" for x, y, z in corners.reshape(-1, 3)]
    faces = [f"f {3 * row + 1} {3 * row + 2} {3 * row + 3}\n" for row in range(len(corners))]
    file.write_text("".join(lines + faces))
    return file


def triangles(places: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return a small triangle around each of some places [P, 3]."""
    return places[:, None] + np.array([[0.03, 0, 0], [-0.02, 0.02, 0.0], [-0.02, -0.02, 0.03]])


@pytest.mark.parametrize("scale", [2.0, 0.01])
def test_a_mesh_of_another_scale_is_found(
    found: tuple[list[Camera], SparsePoints], tmp_path: Path, scale: float
) -> None:
    """The places of points, nearer to the first camera or farther from it."""
    cameras, points = found
    eye = cameras[0].position
    mesh = write_mesh(tmp_path / "room.obj", eye + scale * (triangles(points.xyz) - eye))
    said, findings = judge_given_depth(open_capture(SAMPLE, mesh=mesh))
    assert said[0].startswith("the mesh room.obj in ")
    assert len(findings) == 1


def test_a_mesh_that_closes_the_hole_before_a_camera_agrees(
    found: tuple[list[Camera], SparsePoints], tmp_path: Path
) -> None:
    cameras, points = found
    corners = [triangles(points.xyz)]
    for camera in cameras:
        rim = np.array([[-2000.0, -2000], [4000, -2000], [0, 6000]])
        corners.append(camera.position + 0.02 * camera.rays(rim)[None])
    said, findings = judge_given_depth(
        open_capture(SAMPLE, mesh=write_mesh(tmp_path / "room.obj", np.concatenate(corners)))
    )
    assert "in 16 of 16 pictures: 1 times as far" in said[0]
    assert findings == []


def test_nothing_given_says_nothing() -> None:
    assert judge_given_depth(open_capture(SAMPLE)) == ([], [])


def test_too_few_points_are_no_evidence() -> None:
    assert DepthAgreement(2, 19, 3.0, 0.5).sentence("depth maps", 16) == (
        "depth maps in 2 of 16 pictures: too few points of features to compare with"
    )
