"""Films of a scene folder: a picture for each moment of a path, as the browser shows it, and the sound."""

from __future__ import annotations

import dataclasses
import enum
import math
from contextlib import AbstractContextManager
from fractions import Fraction
from pathlib import Path

import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.format.scene_folder import read_audio
from hgs_core.film.camera_path import CameraPath
from hgs_core.film.film_file import FilmFile, film_file, png_folder
from hgs_core.film.film_sound import film_sound
from hgs_core.film.ready_paths import start_camera
from hgs_core.render.scene_picture import pixels_of, scene_picture
from hgs_core.render.threads import one_torch_thread
from hgs_core.render.types import Render

__all__ = ["FilmFormat", "make_film"]

_LARGEST = 16_384  # pixels of a side
_ROUNDED = 1e-3  # share of a picture by which the last may miss the end
_BLACK = (0.0, 0.0, 0.0)


class FilmFormat(enum.Enum):
    """The format that a film's name stands for."""

    MP4 = ".mp4"
    WEBM = ".webm"
    PNG_FOLDER = ""

    @classmethod
    def of(cls, path: Path) -> FilmFormat:
        """Return the format of a path.

        Raises:
            InputError: another suffix.
        """
        try:
            return cls(path.suffix.lower())
        except ValueError:
            cure = "name a .mp4, a .webm, or a folder of PNG pictures"
            raise InputError(path, f"{path.suffix} is no format of films", cure) from None


def make_film(
    scene: Path,
    path: CameraPath,
    out: Path,
    *,
    size: tuple[int, int] = (1920, 1080),
    rate: Fraction | None = None,
    alpha: bool = False,
    sound: bool = True,
    progress: ProgressCallback = silent,
) -> int:
    """Draw an encoded scene along a path into a film, and return the number of its pictures.

    A path of several key frames begins and ends the film; a single one shows the whole scene. Beyond the scene's time
    its first or last moment stands still. The scene is drawn as viewers draw it, with its magnification.

    Args:
        scene: folder of an encoded scene.
        path: of the camera.
        out: .mp4, .webm, or a folder of PNG pictures that is new or empty.
        size: width and height, pixels; even for videos.
        rate: pictures per second; default: the capture's.
        alpha: keep transparent what no splat covers, instead of the background: for .webm and PNG.
        sound: keep the scene's sound, which PNG pictures have none of.
        progress: called after each picture.

    Raises:
        InputError: the scene is damaged, or an option is not for that format.
    """
    kind = FilmFormat.of(out)
    manifest = load_manifest(scene)
    _require(kind, size, alpha)
    rate = Fraction(manifest.frame_rate).limit_denominator(1001) if rate is None else rate
    start, end = (path.start, path.end) if len(path.keys) > 1 else (manifest.start, manifest.end)
    count = math.floor((end - start) * float(rate) + _ROUNDED) + 1
    audio = read_audio(scene, manifest) if sound and kind is not FilmFormat.PNG_FOLDER else None
    samples = None if audio is None else film_sound(audio, start, start + float(count / rate))
    opened: AbstractContextManager[FilmFile]
    opened = png_folder(out) if kind is FilmFormat.PNG_FOLDER else film_file(out, size, rate, samples, alpha=alpha)
    splats = decode_scene(scene).map(torch.from_numpy)
    if alpha:
        splats = dataclasses.replace(splats, background=_BLACK)
    near = start_camera(manifest).near
    with opened as film, one_torch_thread():
        for number in range(count):
            seconds = start + float(number / rate)
            camera = path.camera(seconds, size, manifest.up, near)
            moment = min(max(seconds, manifest.start), manifest.end)
            drawn = scene_picture(splats, camera, moment, rig=manifest.rig)
            film.add(pixels_of(_with_alpha(drawn) if alpha else drawn.rgb))
            progress(Progress("render", number + 1, count))
    return count


def _require(kind: FilmFormat, size: tuple[int, int], alpha: bool) -> None:
    width, height = size
    if not (1 <= width <= _LARGEST and 1 <= height <= _LARGEST):
        raise InputError("--size", f"{width}x{height} is no size of a picture", f"give sides of 1 to {_LARGEST}")
    if kind is not FilmFormat.PNG_FOLDER and (width % 2 or height % 2):
        raise InputError("--size", f"{width}x{height} has an odd side, and videos need even ones", "make it even")
    if alpha and kind is FilmFormat.MP4:
        raise InputError("--alpha", "is not kept by .mp4", "name a .webm or a folder of PNG pictures")


def _with_alpha(drawn: Render) -> Tensor:
    """Return the picture [4, H, W] with alpha, by which its colours are not multiplied."""
    return torch.cat((drawn.rgb / drawn.alpha.clamp_min(1 / 255), drawn.alpha[None]))
