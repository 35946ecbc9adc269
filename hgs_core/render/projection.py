"""From splats in the world to ellipses on the screen, in torch (docs/numerics.md, "Projection")."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.render.constants import (
    ALPHA_MIN,
    COMPENSATION_MIN,
    COVARIANCE_MAX,
    DEPTH_MAX,
    FRUSTUM_MARGIN,
    LOW_PASS,
    QUATERNION_MIN,
)
from hgs_core.render.magnification import magnification
from hgs_core.render.moment import Moment
from hgs_core.scene.camera import Camera

__all__ = ["Ellipses", "project", "rotation_matrices"]


@dataclass(frozen=True)
class Ellipses:
    """The V splats that can be visible, in the order of `index`; float64."""

    index: Tensor  # [V] int64 rows of the moment they came from
    means: Tensor  # [V, 2] pixels
    factors: Tensor  # [V, 3] xx, xy, yy of the upper triangular U, 1 / pixels, with U^T U = C^-1
    half_sizes: Tensor  # [V, 2] pixels; half-sides of the box outside which alpha < 1/255 (no gradient)
    depths: Tensor  # [V] camera-space z, world units
    opacities: Tensor  # [V] the compensation of antialiasing included
    rgb: Tensor  # [V, 3]

    def take(self, rows: Tensor) -> Ellipses:
        """Return some of them."""
        return Ellipses(*(getattr(self, field.name)[rows] for field in dataclasses.fields(self)))


def rotation_matrices(quats: Tensor) -> Tensor:
    """Rotation matrices [K, 3, 3] of quaternions [K, 4] of any length; near-zero ones give the identity.

    A matrix does not depend on its quaternion's length, so dividing by the largest entry first changes neither value
    nor gradient; it keeps the squares from overflowing and vanishing.
    """
    largest = quats.detach().abs().amax(1, keepdim=True)
    scaled = quats / torch.where(largest > 0, largest, 1.0)
    square = (scaled * scaled).sum(1, keepdim=True)
    usable = largest * square.detach().sqrt() >= QUATERNION_MIN
    identity = torch.tensor([1.0, 0.0, 0.0, 0.0], dtype=quats.dtype, device=quats.device)
    unit = torch.where(usable, scaled, identity) / torch.where(usable, square, 1.0).sqrt()
    w, x, y, z = unit.unbind(1)
    rows = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )
    return torch.stack(rows, 1).view(-1, 3, 3)


def project(moment: Moment, camera: Camera, antialiased: bool = False, rig: Sequence[Camera] = ()) -> Ellipses:
    """Project the splats in front of the near plane that are opaque enough and touch the image."""
    with torch.no_grad():
        pose = torch.as_tensor(camera.world_to_camera, device=moment.means.device)
        z = moment.means @ pose[2, :3] + pose[2, 3]
        in_depth = (z >= camera.near) & (z <= DEPTH_MAX)
        candidates = torch.nonzero(in_depth & (moment.opacities >= ALPHA_MIN))[:, 0]
        ellipses, drawn = _projected(moment, candidates, camera, antialiased, rig)
        kept = torch.nonzero(drawn)[:, 0]
    if not (torch.is_grad_enabled() and any(getattr(moment, f.name).requires_grad for f in dataclasses.fields(moment))):
        return ellipses.take(kept)
    # Once more for gradients, without the splats that are not drawn: what overflows in one of those would turn its
    # zero gradient into a NaN.
    return _projected(moment, candidates[kept], camera, antialiased, rig)[0]


def _projected(
    moment: Moment, index: Tensor, camera: Camera, antialiased: bool, rig: Sequence[Camera]
) -> tuple[Ellipses, Tensor]:
    """Return the ellipses of the rows `index`, and which of them are to be drawn."""
    pose = torch.as_tensor(camera.world_to_camera, device=index.device)
    R, shift = pose[:3, :3], pose[:3, 3]
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
    across, down = (J @ R @ axes).unbind(1)  # [V, 3] each; rows of M, the covariance is M M^T + low_pass I
    xx, xy, yy = (across * across).sum(1), (across * down).sum(1), (down * down).sum(1)
    # |across x down|^2 = xx yy - xy^2, without the difference in which a needle loses all its digits.
    sharp_det = torch.linalg.cross(across, down).square().sum(1)
    low_pass = _low_pass(torch.stack([u, v, torch.ones_like(u), 1 / z], 1).detach(), camera, rig)
    det = sharp_det + low_pass * (xx + yy) + low_pass**2
    xx, yy = xx + low_pass, yy + low_pass
    opacities = moment.opacities[index]
    if antialiased:
        opacities = opacities * (sharp_det / det).clamp_min(COMPENSATION_MIN**2).sqrt()
    means = torch.stack([camera.fx * u + camera.cx, camera.fy * v + camera.cy], 1)
    factors = torch.stack([(yy / det).sqrt(), -xy / (yy * det).sqrt(), yy.rsqrt()], 1)
    with torch.no_grad():
        reach = 2 * torch.log(opacities / ALPHA_MIN).clamp_min(0)
        half_sizes = (torch.stack([xx, yy], 1) * reach[:, None]).sqrt()
        size = torch.tensor([camera.width, camera.height], device=index.device)
        # Written so that a NaN, which only a splat that overflows float64 can have here, is not drawn either.
        drawn = (xx <= COVARIANCE_MAX) & (yy <= COVARIANCE_MAX) & (opacities >= ALPHA_MIN)
        drawn &= (means + half_sizes > 0).all(1) & (means - half_sizes < size).all(1)
    return Ellipses(index, means, factors, half_sizes, z, opacities, moment.rgb[index]), drawn


def _low_pass(places: Tensor, camera: Camera, rig: Sequence[Camera]) -> Tensor:
    """Return the variances [K] that are added to splats at `places` [K, 4], (x, y, z, 1) / z; without a gradient."""
    larger = (places @ torch.as_tensor(magnification(camera, rig), device=places.device)).clamp_min(0)
    return LOW_PASS * larger.square().clamp_min(1)
