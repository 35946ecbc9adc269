"""One camera, many moments: what a player does while nobody moves the camera."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from torch import Tensor

from hgs_core.render.backends import Backend, choose_backend
from hgs_core.render.contribution import weigher
from hgs_core.render.cpu import FixedViewCpu
from hgs_core.render.rasterize import rasterizer
from hgs_core.render.types import Contributions, Render, View
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["FixedView"]


class FixedView:
    """Draws the moments of a scene from one camera, without gradients.

    The compiled backend projects and sorts the static splats for the first frame only; they must not change afterwards.
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
            InputError: an unknown backend, or one that cannot run here.
        """
        red, green, blue = background
        view = View(camera, background=(red, green, blue), antialiased=antialiased, gradients="none")
        chosen = choose_backend(backend, static)
        self._frames = FixedViewCpu(static, view) if chosen == "cpu" else _DrawnAnew(static, view, chosen)

    def frame(self, dynamic: DynamicSplats[Tensor] | None, time: float = 0.0, depth: bool = False) -> Render:
        """Draw the scene at normalised `time`, as `rasterize` would.

        Raises:
            InputError: a time or a parameter that is not finite.
            RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
        """
        return self._frames.frame(dynamic, time, depth)

    def contributions(self, dynamic: DynamicSplats[Tensor] | None, time: float = 0.0) -> Contributions:
        """Weigh the splats at normalised `time`, as the function `contributions` would; raises what `frame` raises."""
        return self._frames.contributions(dynamic, time)


@dataclasses.dataclass(frozen=True)
class _DrawnAnew:
    """The other backends keep nothing from one frame to the next."""

    static: StaticSplats[Tensor] | None
    view: View
    backend: Backend

    def frame(self, dynamic: DynamicSplats[Tensor] | None, time: float, depth: bool) -> Render:
        view = dataclasses.replace(self.view, time=time, depth=depth)
        return rasterizer(self.backend)(self.static, dynamic, view)

    def contributions(self, dynamic: DynamicSplats[Tensor] | None, time: float) -> Contributions:
        return weigher(self.backend)(self.static, dynamic, dataclasses.replace(self.view, time=time))
