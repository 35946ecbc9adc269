"""Films of a scene: a camera along a path, its pictures and the scene's sound in a file of video."""

from hgs_core.film.camera_path import CameraPath, KeyFrame, load_camera_path
from hgs_core.film.make_film import FilmFormat, make_film
from hgs_core.film.ready_paths import orbit_path, rig_path

__all__ = ["CameraPath", "FilmFormat", "KeyFrame", "load_camera_path", "make_film", "orbit_path", "rig_path"]
