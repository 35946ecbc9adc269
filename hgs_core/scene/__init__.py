"""Scenes: static splats, dynamic splats, the equations of time, and scene files."""

from hgs_core.scene.files import load_scene, save_scene
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.temporal import evaluate, lifetime

__all__ = [
    "DynamicSplats",
    "HybridScene",
    "Segment",
    "StaticSplats",
    "evaluate",
    "lifetime",
    "load_scene",
    "save_scene",
]
