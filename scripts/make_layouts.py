"""Writes one capture in many layouts, to compare their trainings.

    .venv/bin/python -m scripts.make_layouts samples/studio /tmp/layouts

`OUT/n3dv` has lossless videos of some cameras' first frames and poses_bounds.npy; the others have these videos, or
their pictures as PNG files, with the same cameras in other formats:

    colmap_videos, colmap_folders, colmap_moments, easymocap, caliscope, pose2sim, transforms, panoptic, opencv

`fisheye` has the pictures bent by a fisheye lens (models.json), and `fisheye_as_pinhole` what a pinhole sees of the
same field. `in_step`, `late` and `late_with_sync` have a quarter of all frames; in the last two every other camera
films half a period later, and in the last sync.json says so.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.lens import Polynomial
from hgs_core.capture.lenses.straighten import StraightView, ray_of
from hgs_core.capture.open import open_capture
from hgs_core.scene.camera import Camera

__all__ = ["LAYOUTS", "write_layouts"]

_BENDS = (-0.02, 0.001)  # fisheye coefficients, in powers of the angle
_FIELD = 0.78  # share of a picture's sides in the fisheye's pictures
_OPENCV_CENTRE = 0.5  # pixels that OpenCV's principal points are less than ours

Picture = npt.NDArray[np.uint8]
Pictures = Sequence[Sequence[Picture]]  # [camera][frame]


def write_video(path: Path, pictures: Sequence[Picture], rate: float) -> None:
    """Write a video without loss but for the rounding of its colours."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        fraction = Fraction(rate).limit_denominator(1001)
        stream = container.add_stream("libx264", rate=fraction, options={"crf": "0", "preset": "fast"})
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv444p"
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")))
        container.mux(stream.encode())


def write_llff(folder: Path, cameras: Sequence[Camera]) -> None:
    rows = []
    for camera in cameras:
        right, down, forward = camera.world_to_camera[:3, :3]
        sides = (camera.height, camera.width, camera.fx)
        matrix = np.stack((down, right, -forward, camera.position, sides), axis=1)
        rows.append(np.concatenate((matrix.reshape(-1), (0.1, 100.0))))
    np.save(folder / "poses_bounds.npy", np.stack(rows))


def write_colmap(folder: Path, cameras: Sequence[Camera]) -> None:
    import pycolmap

    model = pycolmap.Reconstruction()
    for number, camera in enumerate(cameras, 1):
        numbers = [camera.fx, camera.fy, camera.cx, camera.cy]
        lens = pycolmap.Camera(
            model="PINHOLE", width=camera.width, height=camera.height, params=numbers, camera_id=number
        )
        model.add_camera_with_trivial_rig(lens)
        image = pycolmap.Image(name=f"{camera.name}.png", camera_id=number, image_id=number)
        model.add_image_with_trivial_frame(image, pycolmap.Rigid3d(camera.world_to_camera[:3]))
    folder.mkdir(parents=True)
    model.write_binary(str(folder))


def _matrix(camera: Camera, shift: float = 0.0) -> list[list[float]]:
    fx, fy, cx, cy = (float(value) for value in (camera.fx, camera.fy, camera.cx - shift, camera.cy - shift))
    return [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]


def _opencv(values: npt.ArrayLike) -> str:
    rows = np.atleast_2d(np.asarray(values, np.float64))
    data = ", ".join(repr(float(value)) for value in rows.ravel())
    return f"!!opencv-matrix\n   rows: {rows.shape[0]}\n   cols: {rows.shape[1]}\n   dt: d\n   data: [ {data} ]"


def write_easymocap(folder: Path, cameras: Sequence[Camera]) -> None:
    names = [f'   - "{camera.name}"' for camera in cameras]
    intri, extri = ["%YAML:1.0", "---", "names:", *names], ["%YAML:1.0", "---", "names:", *names]
    for camera in cameras:
        intri += [f"K_{camera.name}: {_opencv(_matrix(camera))}", f"dist_{camera.name}: {_opencv(np.zeros(5))}"]
        extri.append(f"Rot_{camera.name}: {_opencv(camera.world_to_camera[:3, :3])}")
        extri.append(f"T_{camera.name}: {_opencv(camera.world_to_camera[:3, 3:])}")
    (folder / "intri.yml").write_text("\n".join(intri) + "\n")
    (folder / "extri.yml").write_text("\n".join(extri) + "\n")


def write_tables(file: Path, cameras: Sequence[Camera], prefix: str) -> None:
    """The TOML of caliscope and Pose2Sim."""
    file.parent.mkdir(exist_ok=True)
    file.write_text(
        "\n".join(
            f"[{prefix}{camera.name}]\nname = '{camera.name}'\nsize = [{camera.width}, {camera.height}]\n"
            f"matrix = {_matrix(camera, _OPENCV_CENTRE)}\ndistortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n"
            f"rotation = {camera.world_to_camera[:3, :3].tolist()}\n"
            f"translation = {camera.world_to_camera[:3, 3].tolist()}\n"
            for camera in cameras
        )
    )


def write_opencv(folder: Path, cameras: Sequence[Camera]) -> None:
    folder.mkdir()
    for camera in cameras:
        lines = (
            "%YAML:1.0",
            "---",
            f"camera_matrix: {_opencv(_matrix(camera, _OPENCV_CENTRE))}",
            f"R: {_opencv(camera.world_to_camera[:3, :3])}",
            f"T: {_opencv(camera.world_to_camera[:3, 3:])}",
        )
        (folder / f"{camera.name}.yml").write_text("\n".join(lines) + "\n")


def write_transforms(folder: Path, cameras: Sequence[Camera], frames: int) -> None:
    entries = []
    for camera in cameras:
        pose = np.linalg.inv(camera.world_to_camera)
        pose[:, 1:3] *= -1
        for frame in range(frames):
            name = f"images/{camera.name}/{frame:04d}.png"
            entries.append({"file_path": name, "transform_matrix": pose.tolist(), "time": frame / frames})
    first = cameras[0]
    lens = {"fl_x": first.fx, "fl_y": first.fy, "cx": first.cx, "cy": first.cy, "w": first.width, "h": first.height}
    (folder / "transforms.json").write_text(json.dumps(lens | {"frames": entries}))


def write_panoptic(folder: Path, cameras: Sequence[Camera], frames: int) -> None:
    meta = {
        "w": cameras[0].width,
        "h": cameras[0].height,
        "k": [[_matrix(camera) for camera in cameras]] * frames,
        "w2c": [[camera.world_to_camera.tolist() for camera in cameras]] * frames,
        "fn": [[f"{camera.name}/{frame:04d}.png" for camera in cameras] for frame in range(frames)],
        "cam_id": [[camera.name for camera in cameras]] * frames,
    }
    (folder / "train_meta.json").write_text(json.dumps(meta))


def _write_pictures(folder: Path, pattern: str, cameras: Sequence[Camera], pictures: Pictures) -> None:
    for camera, frames in zip(cameras, pictures, strict=True):
        for frame, picture in enumerate(frames):
            path = folder / pattern.format(camera=camera.name, frame=frame)
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(picture).save(path, compress_level=1)


def _moments(folder: Path, cameras: Sequence[Camera], pictures: Pictures) -> None:
    for frame in range(len(pictures[0])):
        write_colmap(folder / f"colmap_{frame}/sparse/0", cameras)
    _write_pictures(folder, "colmap_{frame}/images/{camera}.png", cameras, pictures)


def write_fisheye(folder: Path, straight: Path, cameras: Sequence[Camera], pictures: Pictures, rate: float) -> None:
    """Write the middle of the pictures through a fisheye, and the field that it covers as it is."""
    lens = Polynomial(radial=_BENDS, fisheye=True)
    models = []
    seen: list[Camera] = []
    for camera, frames in zip(cameras, pictures, strict=True):
        width, height = (2 * int(side * _FIELD / 2) for side in (camera.width, camera.height))
        bent = Camera(camera.name, width, height, camera.fx, camera.fy, width / 2, height / 2, camera.world_to_camera)
        column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        u, v = ((column - bent.cx) / bent.fx).ravel(), ((row - bent.cy) / bent.fy).ravel()
        x, y, _ = ray_of(lens, u, v)
        at = x * camera.fx + camera.cx, y * camera.fy + camera.cy
        shown = [_sampled(frame, *at).reshape(height, width, 3) for frame in frames]
        write_video(folder / f"{camera.name}.mp4", shown, rate)
        models.append(
            {
                "name": camera.name,
                "width": width,
                "height": height,
                "focal_length": camera.fx,
                "principal_point": [bent.cx, bent.cy],
                "orientation": camera.world_to_camera[:3, :3].tolist(),
                "position": camera.position.tolist(),
                "radial_distortion": list(_BENDS),
            }
        )
        field = StraightView.of(bent, lens).camera
        across, down = (2 * (side // 2) for side in (field.width, field.height))
        left, top = (camera.width - across) // 2, (camera.height - down) // 2
        write_video(straight / f"{camera.name}.mp4", [f[top : top + down, left : left + across] for f in frames], rate)
        seen.append(
            Camera(camera.name, across, down, camera.fx, camera.fy, across / 2, down / 2, camera.world_to_camera)
        )
    (folder / "models.json").write_text(json.dumps(models))
    write_llff(straight, seen)


def _sampled(picture: Picture, u: npt.NDArray[np.float64], v: npt.NDArray[np.float64]) -> Picture:
    """Return the picture's colours [N, 3] at the places (u, v), bicubic."""
    height, width = picture.shape[:2]
    result = np.zeros((len(u), 3))
    left, top = np.floor(u - 0.5).astype(int), np.floor(v - 0.5).astype(int)
    for dy in range(-1, 3):
        for dx in range(-1, 3):
            weight = _cubic(u - 0.5 - left - dx) * _cubic(v - 0.5 - top - dy)
            rows, columns = np.clip(top + dy, 0, height - 1), np.clip(left + dx, 0, width - 1)
            result += weight[:, None] * picture[rows, columns]
    return result.clip(0, 255).round().astype(np.uint8)


def _cubic(away: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Catmull and Rom's kernel."""
    d = np.abs(away)
    return np.where(d < 1, 1 - 2.5 * d**2 + 1.5 * d**3, np.where(d < 2, 2 - 4 * d + 2.5 * d**2 - 0.5 * d**3, 0.0))


def _write_late(out: Path, cameras: Sequence[Camera], pictures: Pictures, rate: float) -> None:
    for name in ("in_step", "late", "late_with_sync"):
        late = [name != "in_step" and place % 2 == 1 for place in range(len(cameras))]
        for camera, frames, is_late in zip(cameras, pictures, late, strict=True):
            write_video(out / name / f"{camera.name}.mp4", frames[2 if is_late else 0 :: 4], rate / 4)
        write_llff(out / name, cameras)
    offsets = {camera.name: 0.5 for camera in cameras[1::2]}
    (out / "late_with_sync" / "sync.json").write_text(json.dumps({"frames": offsets}))


LAYOUTS: dict[str, Callable[[Path, Sequence[Camera], Pictures], None]] = {
    "colmap_videos": lambda folder, cameras, _: write_colmap(folder / "sparse/0", cameras),
    "colmap_folders": lambda folder, cameras, pictures: (
        write_colmap(folder / "sparse/0", cameras),
        _write_pictures(folder, "images/{camera}/{frame:04d}.png", cameras, pictures),
    )[0],
    "colmap_moments": _moments,
    "easymocap": lambda folder, cameras, _: write_easymocap(folder, cameras),
    "caliscope": lambda folder, cameras, _: write_tables(folder / "camera_array.toml", cameras, "cameras."),
    "pose2sim": lambda folder, cameras, _: write_tables(folder / "calibration/Calib.toml", cameras, ""),
    "opencv": lambda folder, cameras, _: write_opencv(folder / "cameras", cameras),
    "transforms": lambda folder, cameras, pictures: (
        write_transforms(folder, cameras, len(pictures[0])),
        _write_pictures(folder, "images/{camera}/{frame:04d}.png", cameras, pictures),
    )[0],
    "panoptic": lambda folder, cameras, pictures: (
        write_panoptic(folder, cameras, len(pictures[0])),
        _write_pictures(folder, "ims/{camera}/{frame:04d}.png", cameras, pictures),
    )[0],
}
"""Writers of a layout; one that writes no picture gets the videos."""


def write_layouts(source: Path, out: Path, cameras: int, frames: int) -> list[Path]:
    """Write every layout of the first frames of some cameras, evenly chosen, and return their folders.

    Raises:
        InputError: the source is no capture, or `out` is not empty.
    """
    if out.exists() and any(out.iterdir()):
        raise InputError(out, "exists and is not empty", "choose a new folder")
    capture = open_capture(source)
    places = [place * len(capture.cameras) // cameras for place in range(cameras)]
    chosen = [capture.cameras[place] for place in places]
    rate = (len(capture.times) - 1) / capture.seconds
    for camera, place in zip(chosen, places, strict=True):
        shown = [capture.frame(place, frame) for frame in range(min(frames, len(capture.times)))]
        write_video(out / "n3dv" / f"{camera.name}.mp4", shown, rate)
    write_llff(out / "n3dv", chosen)
    base = open_capture(out / "n3dv")
    pictures = [[base.frame(c, frame) for frame in range(len(base.times))] for c in range(cameras)]
    for name, write in LAYOUTS.items():
        folder = out / name
        folder.mkdir()
        write(folder, chosen, pictures)
        if not any(folder.rglob("*.png")):
            for video in (out / "n3dv").glob("*.mp4"):
                shutil.copy(video, folder)
    write_fisheye(out / "fisheye", out / "fisheye_as_pinhole", chosen, pictures, rate)
    every = [[capture.frame(place, frame) for frame in range(len(capture.times))] for place in places]
    _write_late(out, chosen, every, rate)
    return sorted(out.iterdir())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=Path, help="folder of a capture of pinhole cameras")
    parser.add_argument("out", type=Path, help="new folder")
    parser.add_argument("--cameras", type=int, default=8)
    parser.add_argument("--frames", type=int, default=20)
    options = parser.parse_args()
    try:
        for folder in write_layouts(options.capture, options.out, options.cameras, options.frames):
            print(folder)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
