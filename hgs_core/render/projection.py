"""From splats in the world to ellipses on the screen, in torch (docs/numerics.md, "Projection")."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.render.constants import ALPHA_MIN, FRUSTUM_MARGIN, LOW_PASS
from hgs_core.render.temporal import Moment

__all__ = ["Ellipses", "project", "rotation_matrices"]


@dataclass(frozen=True)
class Ellipses:
    """The V splats that can be visible, in the order of `index`."""

    index: Tensor  # [V] int64 rows of the moment they came from
    means: Tensor  # [V, 2] pixels
    conics: Tensor  # [V, 3] xx, xy, yy of the inverse screen covariance, 1 / pixels^2
    half_sizes: Tensor  # [V, 2] pixels; half-sides of the box outside which alpha < 1/255 (no gradient)
    depths: Tensor  # [V] camera-space z (no gradient)
    opacities: Tensor  # [V]
    rgb: Tensor  # [V, 3]


def rotation_matrices(quats: Tensor) -> Tensor:
    """Rotation matrices [K, 3, 3] of quaternions [K, 4] of any length; near-zero ones give the identity."""
    square = (quats * quats).sum(1, keepdim=True)
    usable = square >= 1e-24
    identity = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=quats.dtype, device=quats.device)
    unit = torch.where(usable, quats, identity) / torch.where(usable, square, torch.ones_like(square)).sqrt()
    w, x, y, z = unit.unbind(1)
    rows = (
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    )  # fmt: skip
    return torch.stack(rows, 1).view(-1, 3, 3)


def project(moment: Moment, camera: Camera) -> Ellipses:
    """Project what lies in front of the near plane, is opaque enough to be seen and touches the image."""
    dtype, device = moment.means.dtype, moment.means.device
    pose = torch.as_tensor(camera.world_to_camera, dtype=dtype, device=device)
    R, shift = pose[:3, :3], pose[:3, 3]
    with torch.no_grad():
        z_all = moment.means @ R[2] + shift[2]
        index = torch.nonzero((z_all >= camera.near) & (moment.opacities >= ALPHA_MIN))[:, 0]
    x, y, z = (moment.means[index] @ R.T + shift).unbind(1)
    u, v = x / z, y / z
    margin_x = FRUSTUM_MARGIN * 0.5 * camera.width / camera.fx
    margin_y = FRUSTUM_MARGIN * 0.5 * camera.height / camera.fy
    u_clamped = u.clamp(-camera.cx / camera.fx - margin_x, (camera.width - camera.cx) / camera.fx + margin_x)
    v_clamped = v.clamp(-camera.cy / camera.fy - margin_y, (camera.height - camera.cy) / camera.fy + margin_y)
    zero = torch.zeros_like(z)
    J = torch.stack(
        [camera.fx / z, zero, -camera.fx * u_clamped / z, zero, camera.fy / z, -camera.fy * v_clamped / z], 1
    ).view(-1, 2, 3)
    axes = rotation_matrices(moment.quats[index]) * torch.exp(moment.log_scales[index])[:, None, :]
    M = J @ R @ axes  # [V, 2, 3]; the screen covariance is M M^T + LOW_PASS I
    a = (M[:, 0] * M[:, 0]).sum(1) + LOW_PASS
    b = (M[:, 0] * M[:, 1]).sum(1)
    c = (M[:, 1] * M[:, 1]).sum(1) + LOW_PASS
    det = a * c - b * b
    means = torch.stack([camera.fx * u + camera.cx, camera.fy * v + camera.cy], 1)
    opacities = moment.opacities[index]
    with torch.no_grad():
        reach = 2 * torch.log(opacities / ALPHA_MIN)
        half = torch.stack([a, c], 1).mul(reach.clamp_min(0)[:, None]).sqrt()
        size = torch.tensor([camera.width, camera.height], dtype=dtype, device=device)
        seen = (det > 0) & (means + half > 0).all(1) & (means - half < size).all(1)
        keep = torch.nonzero(seen)[:, 0]
    conics = torch.stack([c, -b, a], 1)[keep] / det[keep, None]
    return Ellipses(
        index[keep],
        means[keep],
        conics,
        half[keep],
        z.detach()[keep],
        opacities[keep],
        moment.rgb[index[keep]],
    )
