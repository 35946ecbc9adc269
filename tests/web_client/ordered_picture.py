"""The picture of docs/numerics.md in plain numpy, but for the order: by distance from a point, as eyes share it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.scene import HybridScene
from hgs_core.scene.camera import Camera

Doubles = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Moment:
    """The splats that are alive at a time."""

    means: Doubles  # [N, 3] world units
    quats: Doubles  # [N, 4]
    scales: Doubles  # [N, 3] world units
    opacities: Doubles  # [N]
    rgb: Doubles  # [N, 3]


def moment(scene: HybridScene[np.ndarray], seconds: float) -> Moment:
    """Return a scene's splats at a time."""
    s, segment = scene.static, scene.segment_at(seconds)
    d = segment.dynamic
    t = segment.normalised(seconds) - d.time_centers.astype(np.float64)
    powers = t[:, None] ** np.arange(d.motion.shape[1])
    fade = np.exp(-np.exp(d.time_log_precisions.astype(np.float64)) * t**2)

    def logistic(logits: np.ndarray) -> Doubles:
        return 1 / (1 + np.exp(-logits.astype(np.float64)))

    return Moment(
        np.concatenate([s.means, np.einsum("nk,nkc->nc", powers, d.motion)]).astype(np.float64),
        np.concatenate([s.quats, d.rotation[:, 0] + t[:, None] * d.rotation[:, 1]]).astype(np.float64),
        np.exp(np.concatenate([s.log_scales, d.log_scales]).astype(np.float64)),
        np.concatenate([logistic(s.opacity_logits), logistic(d.opacity_logits) * fade]),
        np.concatenate([s.rgb, d.rgb]).astype(np.float64),
    )


def _rotations(quats: Doubles) -> Doubles:
    w, x, y, z = (quats / np.linalg.norm(quats, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def ordered_picture(
    splats: Moment, camera: Camera, centre: npt.ArrayLike, background: npt.ArrayLike, *, clear: float = 0.0
) -> Doubles:
    """Return the antialiased picture [H, W, 3], the splats nearest to `centre` [3] in front.

    The background is a colour [3] or a picture [H, W, 3]. Splats fade from the depth `clear`, world units, to the
    camera's near plane.
    """
    turn, shift = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    points = splats.means @ turn.T + shift
    x, y, z = points.T
    opacity = splats.opacities.copy()
    if clear > camera.near:
        opacity *= np.clip((z - camera.near) / (clear - camera.near), 0, 1)
    axes = turn @ (_rotations(splats.quats) * splats.scales[:, None, :])
    columns, rows = np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5
    light = np.zeros((camera.height, camera.width, 3))
    through = np.ones((camera.height, camera.width))
    for i in np.argsort(np.linalg.norm(splats.means - centre, axis=1), kind="stable"):
        if z[i] < camera.near or opacity[i] < 1 / 255:
            continue
        u, v = x[i] / z[i], y[i] / z[i]
        margins = 0.15 * camera.width / camera.fx, 0.15 * camera.height / camera.fy
        u_near = np.clip(u, -camera.cx / camera.fx - margins[0], (camera.width - camera.cx) / camera.fx + margins[0])
        v_near = np.clip(v, -camera.cy / camera.fy - margins[1], (camera.height - camera.cy) / camera.fy + margins[1])
        jacobian = np.array([[camera.fx, 0, -camera.fx * u_near], [0, camera.fy, -camera.fy * v_near]]) / z[i]
        sharp = (jacobian @ axes[i]) @ (jacobian @ axes[i]).T
        covariance = sharp + 0.3 * np.eye(2)
        area = np.linalg.det(covariance)
        o = opacity[i] * np.sqrt(max(0.005**2, np.linalg.det(sharp) / area))
        if o < 1 / 255:
            continue
        dx = columns - (camera.fx * u + camera.cx)
        dy = rows - (camera.fy * v + camera.cy)
        reach = 2 * np.log(255 * o)
        seen_x = np.flatnonzero(dx**2 <= reach * covariance[0, 0])
        seen_y = np.flatnonzero(dy**2 <= reach * covariance[1, 1])
        if not len(seen_x) or not len(seen_y):
            continue
        box = np.s_[seen_y[0] : seen_y[-1] + 1, seen_x[0] : seen_x[-1] + 1]
        a, b, c = covariance[0, 0], covariance[0, 1], covariance[1, 1]
        dx, dy = dx[None, box[1]], dy[box[0], None]
        alpha = np.minimum(0.99, o * np.exp(-0.5 * (c * dx**2 - 2 * b * dx * dy + a * dy**2) / area))
        alpha[alpha < 1 / 255] = 0
        light[box] += (through[box] * alpha)[..., None] * splats.rgb[i]
        through[box] *= 1 - alpha
    return light + through[..., None] * np.asarray(background)
