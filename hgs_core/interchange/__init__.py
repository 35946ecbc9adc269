"""Scenes in the formats of others: .ply of 3DGS and STGS, .splat, .splatv, SPZ, GLB, .4dgs (docs/interchange.md)."""

from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.export_scene import export_scene, export_sequence
from hgs_core.interchange.formats import IMPORTED
from hgs_core.interchange.import_scene import import_scene
from hgs_core.interchange.still_moment import scene_at

__all__ = ["IMPORTED", "Action", "Change", "export_scene", "export_sequence", "import_scene", "scene_at"]
