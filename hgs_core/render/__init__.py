"""Pictures of splats: one function, `rasterize`, and interchangeable backends that compute docs/numerics.md."""

from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import Render, ScreenStatistics, View

__all__ = ["Render", "ScreenStatistics", "View", "rasterize"]
