"""The scene that tests of the store publish."""

from tests.studio_scene import chunks, manifest, scene_folder

__all__ = ["chunks", "manifest", "scene_folder"]
