"""The workload of one size: a scene, one view of it and a picture to compare with."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.bench.raster.raster_sizes import Size
from hgs_core.bench.raster.synthetic_scenes import BenchScene, bench_camera, bench_scene, bench_target
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["BACKGROUND", "Workload"]

BACKGROUND = (0.5, 0.5, 0.5)


@dataclass(frozen=True)
class Workload:
    """The inputs of drawing and its gradient; the tensors share the memory of the scene's arrays."""

    size: Size
    scene: BenchScene
    camera: Camera
    target: Tensor  # [3, H, W] float32 in [0, 1]

    @staticmethod
    def of(size: Size, seed: int, dynamic_share: float) -> Workload:
        """Make the workload of a size; scenes of as many splats are the same for any picture."""
        camera = bench_camera(size.width, size.height)
        scene = bench_scene(size.splats, seed, dynamic_share)
        return Workload(size, scene, camera, torch.from_numpy(bench_target(camera, seed)))

    def static(self, dtype: torch.dtype = torch.float32) -> StaticSplats[Tensor]:
        """Return the static splats as tensors."""
        return self.scene.static.map(lambda array: torch.from_numpy(array).to(dtype))

    def dynamic(self, dtype: torch.dtype = torch.float32) -> DynamicSplats[Tensor] | None:
        """Return the dynamic splats as tensors, or None if the scene has none."""
        dynamic = self.scene.dynamic
        return None if dynamic is None else dynamic.map(lambda array: torch.from_numpy(array).to(dtype))
