"""The contribution of every splat to a picture, which decides pruning and the order of streaming."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.render.backends import Backend, choose_backend
from hgs_core.render.cpu import contributions_cpu
from hgs_core.render.reference import contributions_reference
from hgs_core.render.types import Contributions, View
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["contributions", "weigher"]


def contributions(
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    camera: Camera,
    time: float = 0.0,
    *,
    backend: str = "auto",
    tile_mask: npt.NDArray[np.bool_] | None = None,
    antialiased: bool = False,
) -> Contributions:
    """Weigh the splats by their part in the picture of `rasterize` with the same arguments.

    Returns:
        Sum and maximum, over the pixels of the tiles that are drawn, of every splat's weight T alpha.

    Raises:
        InputError: an unknown backend or one that cannot run here, or a parameter that is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    view = View(camera, time, tile_mask=tile_mask, antialiased=antialiased, gradients="none")
    return weigher(choose_backend(backend, static, dynamic))(static, dynamic, view)


def weigher(
    backend: Backend,
) -> Callable[[StaticSplats[Tensor] | None, DynamicSplats[Tensor] | None, View], Contributions]:
    """Return the function by which a backend weighs."""
    if backend == "triton":
        from hgs_core.render.triton.contribution import contributions_triton

        return contributions_triton
    return contributions_cpu if backend == "cpu" else contributions_reference
