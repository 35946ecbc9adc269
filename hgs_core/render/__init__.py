"""Pictures of splats: one function, `rasterize`, and interchangeable backends that compute docs/numerics.md."""

from hgs_core.render.contributions import contributions
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import Contributions, Render, ScreenStatistics, View

__all__ = ["Contributions", "FixedView", "Render", "ScreenStatistics", "View", "contributions", "rasterize"]
