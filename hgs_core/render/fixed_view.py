"""One camera, many moments: what a player does while nobody moves the camera."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.render.backends import choose_backend
from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import Render
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["FixedView"]


class FixedView:
    """Draws the moments of a scene from one camera, without gradients.

    The static splats must not change between frames.
    """

    def __init__(
        self,
        static: StaticSplats[Tensor] | None,
        camera: Camera,
        *,
        background: Sequence[float] = (0.0, 0.0, 0.0),
        antialiased: bool = False,
        backend: str = "auto",
    ) -> None:
        """Remember what all frames share; the arguments are those of `rasterize`.

        Raises:
            InputError: an unknown backend.
        """
        self.static, self.camera = static, camera
        self.background, self.antialiased = background, antialiased
        self.backend = choose_backend(backend, static)

    def frame(self, dynamic: DynamicSplats[Tensor] | None, time: float = 0.0, depth: bool = False) -> Render:
        """Draw the scene at normalised `time`, as `rasterize` would.

        Raises:
            InputError: a parameter that is not finite.
            RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
        """
        return rasterize(
            self.static, dynamic, self.camera, time,
            background=self.background, backend=self.backend, gradients="none",
            antialiased=self.antialiased, depth=depth,
        )  # fmt: skip
