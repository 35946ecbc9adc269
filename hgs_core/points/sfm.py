"""Structure from motion with known poses: the points of one moment, triangulated from SIFT features with pycolmap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.points.features import Features, extract_features, fundamental_matrix, match_features
from hgs_core.points.visibility import nearest_cameras
from hgs_core.scene.camera import Camera

__all__ = ["SparsePoints", "camera_pairs", "triangulate"]

_ALL_PAIRS = 20  # cameras up to which every pair is matched
_NEIGHBOURS = 8  # pairs per camera beyond that
_MAX_ERROR = 2.0  # pixels of reprojection
_MIN_ANGLE = 1.5  # degrees between the rays
_MIN_VIEWS = 3  # the epipolar line admits the match of two views; only a third view proves the point


@dataclass(frozen=True)
class SparsePoints:
    """P triangulated points."""

    xyz: npt.NDArray[np.float32]  # [P, 3]
    rgb: npt.NDArray[np.float32]  # [P, 3] in [0, 1], median over the views
    seen: npt.NDArray[np.bool_]  # [P, C] views whose feature the point explains
    errors: npt.NDArray[np.float32]  # [P] mean reprojection error, pixels


def camera_pairs(cameras: Sequence[Camera]) -> list[tuple[int, int]]:
    """Return the pairs worth matching: all of up to 20 cameras, else each camera and the 8 most like it."""
    count = len(cameras)
    if count <= _ALL_PAIRS:
        return list(combinations(range(count), 2))
    nearest = nearest_cameras(cameras, _NEIGHBOURS)
    return sorted({(min(a, b), max(a, b)) for a in range(count) for b in nearest[a]})


def triangulate(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] each, of one moment
    masks: Sequence[npt.NDArray[np.bool_]] | None = None,  # [H, W] each, where points are wanted; None: everywhere
) -> SparsePoints:
    """Return the points that at least three views agree on; the same bits for the same input and any thread count."""
    wanted = masks if masks is not None else [None] * len(pictures)
    pairs = camera_pairs(cameras)
    with core_pool() as pool:
        features = list(pool.map(extract_features, pictures, wanted))
        matches = list(pool.map(lambda pair: _match(cameras, features, *pair), pairs))
    return _reconstruct(cameras, pictures, features, dict(zip(pairs, matches, strict=True)))


def _match(cameras: Sequence[Camera], features: Sequence[Features], a: int, b: int) -> npt.NDArray[np.uint32]:
    return match_features(features[a], features[b], fundamental_matrix(cameras[a], cameras[b]))


def _reconstruct(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],
    features: Sequence[Features],
    matches: dict[tuple[int, int], npt.NDArray[np.uint32]],
) -> SparsePoints:
    """Let COLMAP's triangulator join the matches into tracks and points; ids are 1 + the index of the camera."""
    from hgs_core.points.colmap_points import pycolmap

    model = pycolmap.Reconstruction()
    graph = pycolmap.CorrespondenceGraph()
    for index, (camera, found) in enumerate(zip(cameras, features, strict=True), 1):
        parameters = [camera.fx, camera.fy, camera.cx, camera.cy]
        model.add_camera_with_trivial_rig(
            pycolmap.Camera(
                model="PINHOLE", width=camera.width, height=camera.height, params=parameters, camera_id=index
            )
        )
        image = pycolmap.Image(name=str(index), keypoints=found.xy, camera_id=index, image_id=index)
        pose = camera.world_to_camera
        model.add_image_with_trivial_frame(image, pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:3, :3]), pose[:3, 3]))
        graph.add_image(index, len(found.xy))
    for (a, b), rows in matches.items():
        if len(rows):
            geometry = pycolmap.TwoViewGeometry()
            geometry.config = pycolmap.TwoViewGeometryConfiguration.CALIBRATED
            geometry.inlier_matches = rows
            graph.add_two_view_geometry(a + 1, b + 1, geometry)
    graph.finalize()
    observations = pycolmap.ObservationManager(model, graph)
    triangulator = pycolmap.IncrementalTriangulator(graph, model, observations)
    options = pycolmap.IncrementalTriangulatorOptions(random_seed=0)
    for index in range(1, len(cameras) + 1):
        triangulator.triangulate_image(options, index)
    triangulator.complete_all_tracks(options)
    triangulator.merge_all_tracks(options)
    observations.filter_all_points3D(_MAX_ERROR, _MIN_ANGLE)

    xyz, rgb, seen, errors = [], [], [], []
    for identity in sorted(model.points3D):
        point = model.points3D[identity]
        colours = {}
        for element in point.track.elements:
            view = element.image_id - 1
            column, row = features[view].xy[element.point2D_idx].astype(int)
            colours[view] = pictures[view][row, column]
        if len(colours) < _MIN_VIEWS:
            continue
        xyz.append(point.xyz)
        rgb.append(np.median(list(colours.values()), axis=0))
        seen.append([view in colours for view in range(len(cameras))])
        errors.append(point.error)
    return SparsePoints(
        np.array(xyz, np.float32).reshape(-1, 3),
        np.array(rgb, np.float32).reshape(-1, 3) / np.float32(255),
        np.array(seen, bool).reshape(-1, len(cameras)),
        np.array(errors, np.float32),
    )
