"""One camera at many moments, as in a player with a camera at rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.render.backends import Backend, choose_backend
from hgs_core.render.contributions import weigher
from hgs_core.render.cpu import FixedViewCpu
from hgs_core.render.rasterize import rasterizer
from hgs_core.render.types import Contributions, Render, ScreenStatistics, View
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["FixedView"]


class FixedView:
    """Draws the moments of a scene from one camera.

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
        rig: Sequence[Camera] = (),
    ) -> None:
        """Keep the state common to all frames; the arguments are those of `rasterize`.

        Raises:
            InputError: an unknown backend, or one that cannot run here.
        """
        red, green, blue = background
        view = View(camera, background=(red, green, blue), antialiased=antialiased, gradients="none", rig=tuple(rig))
        chosen = choose_backend(backend, static)
        self._frames = FixedViewCpu(static, view) if chosen == "cpu" else _DrawnAnew(static, view, chosen)

    def frame(self, dynamic: DynamicSplats[Tensor] | None, time: float = 0.0, depth: bool = False) -> Render:
        """Draw the scene at normalised `time`, as `rasterize` would.

        Raises:
            InputError: a time or a parameter that is not finite.
            RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
        """
        return self._frames.frame(dynamic, time, depth)

    def differentiable_frame(
        self,
        dynamic: DynamicSplats[Tensor],
        time: float,
        *,
        tile_mask: npt.NDArray[np.bool_] | None = None,
        statistics: ScreenStatistics | None = None,
    ) -> Render:
        """Draw the scene at normalised `time` with gradients towards the dynamics, before the next frame is drawn.

        Args:
            dynamic: the dynamics; parameters that require gradients get them.
            time: normalised time.
            tile_mask: [ceil(H/16), ceil(W/16)]; tiles that are False show the background.
            statistics: is added to when the backward pass runs; rows are the fixed statics, then the dynamics.

        Raises:
            InputError: a time or a parameter that is not finite.
            RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
        """
        return self._frames.differentiable_frame(dynamic, time, tile_mask, statistics)

    def contributions(self, dynamic: DynamicSplats[Tensor] | None, time: float = 0.0) -> Contributions:
        """Weigh the splats at normalised `time`, as the function `contributions` does; raises the errors of `frame`."""
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

    def differentiable_frame(
        self,
        dynamic: DynamicSplats[Tensor],
        time: float,
        tile_mask: npt.NDArray[np.bool_] | None,
        statistics: ScreenStatistics | None,
    ) -> Render:
        view = dataclasses.replace(
            self.view, time=time, tile_mask=tile_mask, statistics=statistics, gradients="dynamic"
        )
        return rasterizer(self.backend)(self.static, dynamic, view)

    def contributions(self, dynamic: DynamicSplats[Tensor] | None, time: float) -> Contributions:
        return weigher(self.backend)(self.static, dynamic, dataclasses.replace(self.view, time=time))
