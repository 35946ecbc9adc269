"""A grid of lines much thinner than a pixel, and how much its picture shimmers while the eye moves by parts of one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.render import rasterize
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera

Doubles = npt.NDArray[np.float64]

FINE = 16  # truth: so many times finer
LINE = 0.0015  # standard deviation across a line, world units


def grid() -> HybridScene[npt.NDArray[np.float32]]:
    """Return lines along x and y in the plane z = 0, white, at distances that fit no raster of pixels."""
    r = np.random.default_rng(7)
    places = np.cumsum(r.uniform(0.06, 0.13, 20)) - 0.9
    beads = np.linspace(-1, 1, 81)
    step = beads[1] - beads[0]
    upright = [(x, y, 0.0) for x in places for y in beads]
    level = [(x, y, 0.0) for y in places for x in beads]
    scales = [(LINE, step, LINE)] * len(upright) + [(step, LINE, LINE)] * len(level)
    count = len(scales)
    quats = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    arrays = (upright + level, np.log(scales), quats, np.full(count, 0.5), np.ones((count, 3)))
    statics = StaticSplats(*(np.array(array, np.float32) for array in arrays))
    return HybridScene(statics, (Segment(0.0, 0.0, DynamicSplats.empty()),), antialiased=True)


def drawn(scene: HybridScene[npt.NDArray[np.float32]], camera: Camera, *, antialiased: bool) -> Doubles:
    """Return the picture of the grid [H, W, 3], on black."""
    statics = scene.static.map(torch.from_numpy)
    render = rasterize(statics, None, camera, gradients="none", antialiased=antialiased)
    return render.rgb.permute(1, 2, 0).double().numpy()


def truth(scene: HybridScene[npt.NDArray[np.float32]], camera: Camera) -> Doubles:
    """Return the mean within each pixel of a picture FINE times finer."""
    fine = dataclasses.replace(
        camera,
        width=FINE * camera.width,
        height=FINE * camera.height,
        fx=FINE * camera.fx,
        fy=FINE * camera.fy,
        cx=FINE * camera.cx,
        cy=FINE * camera.cy,
    )
    picture = drawn(scene, fine, antialiased=True)
    return picture.reshape(camera.height, FINE, camera.width, FINE, 3).mean(axis=(1, 3))


def shimmer(pictures: Sequence[Doubles], truths: Sequence[Doubles]) -> float:
    """Return the deviation over time of the pictures' errors, over all pixels: an error that stays is no shimmer."""
    errors = np.stack(pictures) - np.stack(truths)
    return float(np.sqrt(errors.var(axis=0).mean()))
