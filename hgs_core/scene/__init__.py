"""What a scene is: static splats, dynamic splats, and the equations of time."""

from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["DynamicSplats", "HybridScene", "Segment", "StaticSplats"]
