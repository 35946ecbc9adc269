"""Given depth maps and meshes compared with points that features of several cameras agree on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.base.wording import counted
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.check.findings import Finding
from hgs_core.points.given_surfaces import mesh_corners
from hgs_core.points.matching import LONGEST_SIDE
from hgs_core.points.mesh_depth import mesh_depth
from hgs_core.points.sfm import SparsePoints, triangulate
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["DepthAgreement", "judge_given_depth"]

_FEWEST = 20  # points that a comparison needs
_OFF = 0.05  # share by which a scale may be off; the first points tell less than that
_NEARER = 0.5  # share of the nearest point's depth; a mesh there hides what the camera films
_SPREAD = 0.1  # share by which half of the depths may differ apart from the scale

Depths = npt.NDArray[np.float32]


@dataclass(frozen=True)
class DepthAgreement:
    """Given depths in shares of the points' own, in the pictures of some cameras."""

    cameras: int  # cameras with given depths
    points: int  # compared, a point once for each of these cameras that sees it
    ratio: float  # median
    spread: float  # median distance from `ratio`, share of it

    def sentence(self, what: str, of: int) -> str:
        """Return it as one line for people."""
        seen = f"{what} in {self.cameras} of {counted(of, 'picture')}"
        if self.points < _FEWEST:
            return f"{seen}: too few points of features to compare with"
        compared = f"{self.ratio:.3g} times as far as {counted(self.points, 'point')} of features"
        return f"{seen}: {compared}, half of them within {self.spread:.1%} of that"


def judge_given_depth(capture: Capture) -> tuple[list[str], list[Finding]]:
    """Return sentences about the given depth maps and the given mesh, and the findings.

    Raises:
        InputError: a map, the mesh or a picture is unreadable.
    """
    given = capture.depth
    if given is None and capture.mesh is None:
        return [], []
    moments = [] if given is None else [frame for camera in given.cameras for frame in given.frames(camera)[:1]]
    frame = min(moments, default=0)
    cameras = [camera.within(LONGEST_SIDE) for camera in capture.cameras]
    pictures = [reduced_picture(capture.frame(index, frame), size) for index, size in enumerate(cameras)]
    points = triangulate(cameras, pictures)
    said: list[str] = []
    findings: list[Finding] = []
    if given is not None:
        maps: dict[int, Depths] = {}
        for index in given.cameras:
            depth = given.depth(index, frame, cameras[index])
            depth = given.still_depth(index, cameras[index]) if depth is None else depth
            if depth is not None:
                maps[index] = depth
        found = _agreement(cameras, points, maps)
        said.append(found.sentence("depth maps", len(cameras)))
        cure = f"set scale in {given.scale.file} to {given.scale.scale / max(found.ratio, 1e-9):.4g}"
        findings += _findings("the depth maps", found, cure)
    corners = mesh_corners(capture)
    if capture.mesh is not None and corners is not None:
        found = _agreement(cameras, points, _drawn(corners, cameras, points))
        if found.points < _FEWEST:  # a mesh at a small scale lies before all points
            found = _agreement(cameras, points, _drawn(corners, cameras, None))
        said.append(found.sentence(f"the mesh {capture.mesh.name}", len(cameras)))
        findings += _findings("the mesh", found, "give it in the world of the cameras, at their scale")
    return said, findings


def _drawn(corners: Doubles, cameras: list[Camera], points: SparsePoints | None) -> dict[int, Depths]:
    """Return the depths of triangles [T, 3, 3] in the pictures that show some, beyond half of the points' nearest."""
    maps = {}
    for index, camera in enumerate(cameras):
        nearest = 0.0
        if points is not None and points.seen[:, index].any():
            _, depths = camera.project(points.xyz[points.seen[:, index]])
            nearest = _NEARER * float(depths.min())
        drawn = mesh_depth(corners, camera, nearest)
        if drawn.any():
            maps[index] = drawn
    return maps


def _agreement(cameras: list[Camera], points: SparsePoints, maps: Mapping[int, Depths]) -> DepthAgreement:
    """Compare given depths with those of the points that their cameras see."""
    parts = [np.zeros(0)]
    for index, depths in maps.items():
        xyz = points.xyz[points.seen[:, index]]
        rows, pixels = pixels_inside(cameras[index], xyz)
        there = depths[pixels[:, 1], pixels[:, 0]]
        _, own = cameras[index].project(xyz[rows])
        parts.append(there[there > 0] / own[there > 0])
    ratios = np.concatenate(parts)
    if not len(ratios):
        return DepthAgreement(len(maps), 0, 1.0, 0.0)
    ratio = float(np.median(ratios))
    return DepthAgreement(len(maps), len(ratios), ratio, float(np.median(np.abs(ratios / ratio - 1))))


def _findings(what: str, found: DepthAgreement, scaled: str) -> list[Finding]:
    if found.points < _FEWEST:
        return []
    if found.spread > _SPREAD:
        problem = f"half of the depths of {what} differ by more than {found.spread:.0%} from points of features"
        return [Finding(False, (), problem, "are they of this scene, in this world, along the axis or along rays?")]
    if abs(found.ratio - 1) > _OFF:
        problem = f"{what} lie {found.ratio:.3g} times as far away as points of features"
        return [Finding(False, (), problem.replace("mesh lie", "mesh lies"), scaled)]
    return []
