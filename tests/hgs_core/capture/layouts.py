"""A tiny capture with known cameras in every layout: any writer of cameras with any writer of pictures.

Four cameras on an arc, five frames of 48x32 pixels. Every picture is a grey that tells the camera and the frame.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.scene.camera import Camera, looking_at

WIDTH, HEIGHT, FRAMES, RATE = 48, 32, 5, 30
NAMES = ("cam01", "cam02", "cam03", "cam10")
"""Sorted by their numbers."""

MILLISECOND = Fraction(1, 1000)

Picture = npt.NDArray[np.uint8]
CameraWriter = Callable[[Path], None]
PictureWriter = Callable[[Path], None]


def truth() -> list[Camera]:
    """The cameras, with square pixels and the principal point in the middle, as poses_bounds.npy can tell them."""
    found = []
    for i, name in enumerate(NAMES):
        angle = 0.4 * (i - 1.5)
        pose = looking_at([3 * np.sin(angle), 0.2 * i, -3 * np.cos(angle)], [0.0, 0.1, 0.0])
        found.append(Camera(name, WIDTH, HEIGHT, 40.0, 40.0, WIDTH / 2, HEIGHT / 2, pose))
    return found


def level(camera: int, frame: int) -> int:
    """The grey of a picture."""
    return 20 + 50 * camera + 10 * frame


def picture(camera: int, frame: int) -> Picture:
    return np.full((HEIGHT, WIDTH, 3), level(camera, frame), np.uint8)


def write_video(
    path: Path, pictures: Sequence[Picture], *, rate: float = RATE, stamps: Sequence[int] | None = None, **metadata: str
) -> None:
    """Write a lossless video; `stamps` are the frames' times in ms, in place of the rate's."""
    path.parent.mkdir(parents=True, exist_ok=True)
    webm = path.suffix.lower() == ".webm"
    with av.open(str(path), "w", format="mp4" if path.suffix.isupper() else None) as container:
        for name, value in metadata.items():
            container.metadata[name] = value
        options = {"lossless": "1"} if webm else {"crf": "0", "bf": "2"}
        codec = "libvpx-vp9" if webm else "libx264"
        stream = container.add_stream(codec, rate=Fraction(rate).limit_denominator(1001), options=options)
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuv444p"
        if stamps is not None:
            stream.codec_context.time_base = MILLISECOND
        for i, shown in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(shown), format="rgb24")
            if stamps is not None:
                frame.pts, frame.time_base = stamps[i], MILLISECOND
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def videos(folder: str = ".", names: Sequence[str] = NAMES, ending: str = "mp4") -> PictureWriter:
    """Return a writer of one video for each camera."""

    def write(root: Path) -> None:
        for camera, name in enumerate(names):
            write_video(root / folder / f"{name}.{ending}", [picture(camera, frame) for frame in range(FRAMES)])

    return write


def folders(pattern: str, names: Sequence[str] = NAMES) -> PictureWriter:
    """Return a writer of image files, called by a pattern of {camera} and {frame}."""

    def write(root: Path) -> None:
        for camera, name in enumerate(names):
            for frame in range(FRAMES):
                path = root / pattern.format(camera=name, frame=frame)
                path.parent.mkdir(parents=True, exist_ok=True)
                Image.fromarray(picture(camera, frame)).save(path)

    return write


PICTURES: dict[str, PictureWriter] = {
    "videos": videos(),
    "videos in capitals": videos(ending="MP4"),
    "videos in a folder": videos("videos", ending="mkv"),
    "videos two folders deep": videos("recordings/recording_1", ending="mov"),
    "avi": videos(ending="avi"),
    "webm": videos(ending="webm"),
    "folders": folders("images/{camera}/{frame:04d}.png"),
    "folders of folders": folders("{camera}/images/frame_{frame}.png"),
    "moments": folders("colmap_{frame}/images/{camera}.png"),
    "videos of other names": videos(names=[f"GOPRO_{name[3:]}" for name in NAMES]),
}


def llff(root: Path) -> None:
    rows = []
    for camera in truth():
        right, down, forward = camera.world_to_camera[:3, :3]
        matrix = np.stack((down, right, -forward, camera.position, (HEIGHT, WIDTH, camera.fx)), axis=1)
        rows.append(np.concatenate((matrix.reshape(-1), (1.0, 10.0))))
    np.save(root / "poses_bounds.npy", np.stack(rows))


def colmap(
    binary: bool, folder: str = "sparse/0", model: str = "PINHOLE", bends: Sequence[float] = (), ending: str = "png"
) -> CameraWriter:
    """Return a writer of a COLMAP model, which pycolmap writes."""

    def write(root: Path) -> None:
        import pycolmap

        reconstruction = pycolmap.Reconstruction()
        for number, camera in enumerate(truth(), 1):
            parameters = [camera.fx, camera.fy, camera.cx, camera.cy, *bends]
            lens = pycolmap.Camera(model=model, width=WIDTH, height=HEIGHT, params=parameters, camera_id=number)
            reconstruction.add_camera_with_trivial_rig(lens)
            image = pycolmap.Image(name=f"{camera.name}.{ending}", camera_id=number, image_id=number)
            reconstruction.add_image_with_trivial_frame(image, pycolmap.Rigid3d(camera.world_to_camera[:3]))
        (root / folder).mkdir(parents=True, exist_ok=True)
        (reconstruction.write_binary if binary else reconstruction.write_text)(str(root / folder))

    return write


def colmap_of_every_frame(root: Path) -> None:
    for frame in range(FRAMES):
        colmap(True, f"colmap_{frame}/sparse/0")(root)


def opencv_matrix(values: npt.ArrayLike) -> str:
    """A matrix as OpenCV's FileStorage writes it."""
    rows = np.atleast_2d(np.asarray(values, np.float64))
    data = ", ".join(np.format_float_scientific(value) for value in rows.ravel())
    return f"!!opencv-matrix\n   rows: {rows.shape[0]}\n   cols: {rows.shape[1]}\n   dt: d\n   data: [ {data} ]"


def lens_matrix(camera: Camera, shift: float = 0.0) -> list[list[float]]:
    return [[camera.fx, 0.0, camera.cx - shift], [0.0, camera.fy, camera.cy - shift], [0.0, 0.0, 1.0]]


def turn_vector(camera: Camera) -> list[float]:
    """The rotation as the axis times the angle, from the quaternion that pycolmap finds."""
    import pycolmap

    x, y, z, w = pycolmap.Rotation3d(camera.world_to_camera[:3, :3]).quat
    length = float(np.linalg.norm((x, y, z)))
    return [float(value) * 2 * float(np.arctan2(length, w)) / length for value in (x, y, z)]


def easymocap(root: Path) -> None:
    intri, extri = ["%YAML:1.0", "---", "names:"], ["%YAML:1.0", "---", "names:"]
    for lines in (intri, extri):
        lines += [f'   - "{camera.name}"' for camera in truth()]
    for camera in truth():
        intri.append(f"K_{camera.name}: {opencv_matrix(lens_matrix(camera))}")
        intri.append(f"dist_{camera.name}: {opencv_matrix(np.zeros((1, 5)))}")
        extri.append(f"R_{camera.name}: {opencv_matrix(np.reshape(turn_vector(camera), (3, 1)))}")
        extri.append(f"Rot_{camera.name}: {opencv_matrix(camera.world_to_camera[:3, :3])}")
        extri.append(f"T_{camera.name}: {opencv_matrix(camera.world_to_camera[:3, 3:])}")
    (root / "intri.yml").write_text("\n".join(intri) + "\n")
    (root / "extri.yml").write_text("\n".join(extri) + "\n")


def calibration_tables(prefix: str, distortions: Sequence[float] = (0.0,) * 5, fisheye: bool = False) -> str:
    """Tables of TOML; OpenCV has centres of pixels at whole numbers."""
    tables = []
    for camera in truth():
        tables.append(
            f"[{prefix}{camera.name}]\nname = '{camera.name}'\nsize = [{WIDTH}, {HEIGHT}]\n"
            f"matrix = {lens_matrix(camera, 0.5)}\ndistortions = {list(distortions)}\n"
            f"rotation = {turn_vector(camera)}\ntranslation = {camera.world_to_camera[:3, 3].tolist()}\n"
            f"fisheye = {str(fisheye).lower()}\n"
        )
    return "\n".join(tables)


def caliscope(root: Path) -> None:
    (root / "camera_array.toml").write_text(calibration_tables("cameras."))


def pose2sim(root: Path) -> None:
    (root / "calibration").mkdir(exist_ok=True)
    (root / "calibration" / "Calib_scene.toml").write_text(calibration_tables("") + "\n[metadata]\nerror = 0.0\n")


def opencv_files(root: Path) -> None:
    (root / "cameras").mkdir(exist_ok=True)
    for camera in truth():
        lines = [
            "%YAML:1.0",
            "---",
            f"image_width: {WIDTH}",
            f"image_height: {HEIGHT}",
            f"camera_matrix: {opencv_matrix(lens_matrix(camera, 0.5))}",
            f"distortion_coefficients: {opencv_matrix(np.zeros((5, 1)))}",
            f"R: {opencv_matrix(camera.world_to_camera[:3, :3])}",
            f"T: {opencv_matrix(camera.world_to_camera[:3, 3:])}",
        ]
        (root / "cameras" / f"{camera.name}.yml").write_text("\n".join(lines) + "\n")


def opengl(camera: Camera) -> list[list[float]]:
    """Camera-to-world, y up and z backwards."""
    pose = np.linalg.inv(camera.world_to_camera)
    pose[:, 1:3] *= -1
    return pose.tolist()


def transforms(frames: Sequence[dict[str, Any]], name: str = "transforms.json") -> CameraWriter:
    def write(root: Path) -> None:
        meta = {"fl_x": 40.0, "fl_y": 40.0, "cx": WIDTH / 2, "cy": HEIGHT / 2, "w": WIDTH, "h": HEIGHT}
        (root / name).write_text(json.dumps(meta | {"frames": list(frames)}))

    return write


def frames_of_videos(folder: str = "") -> list[dict[str, Any]]:
    return [{"file_path": f"{folder}{c.name}.mp4", "transform_matrix": opengl(c)} for c in truth()]


def frames_of_pictures(pattern: str, time: Callable[[int], float] | None = None) -> list[dict[str, Any]]:
    entries = []
    for camera in truth():
        for frame in range(FRAMES):
            entry = {"file_path": pattern.format(camera=camera.name, frame=frame), "transform_matrix": opengl(camera)}
            entries.append(entry | ({"time": time(frame)} if time else {}))
    return entries


def immersive(root: Path) -> None:
    models = [
        {
            "name": camera.name,
            "width": float(WIDTH),
            "height": float(HEIGHT),
            "focal_length": camera.fx,
            "principal_point": [camera.cx, camera.cy],
            "pixel_aspect_ratio": 1.0,
            "projection_type": "fisheye",
            "orientation": turn_vector(camera),
            "position": camera.position.tolist(),
            "radial_distortion": [0.01, -0.002, 0.0],
        }
        for camera in truth()
    ]
    (root / "models.json").write_text(json.dumps(models))


def panoptic(root: Path) -> None:
    cameras = truth()
    meta = {
        "w": WIDTH,
        "h": HEIGHT,
        "k": [[lens_matrix(camera) for camera in cameras]] * FRAMES,
        "w2c": [[camera.world_to_camera.tolist() for camera in cameras]] * FRAMES,
        "fn": [[f"{camera.name}/{frame:06d}.png" for camera in cameras] for frame in range(FRAMES)],
        "cam_id": [[camera.name for camera in cameras]] * FRAMES,
    }
    (root / "train_meta.json").write_text(json.dumps(meta))


CAMERAS: dict[str, CameraWriter] = {
    "poses_bounds.npy": llff,
    "COLMAP binary": colmap(True),
    "COLMAP text": colmap(False),
    "COLMAP beside": colmap(True, "colmap/sparse/0"),
    "COLMAP of every frame": colmap_of_every_frame,
    "easymocap": easymocap,
    "caliscope": caliscope,
    "Pose2Sim": pose2sim,
    "OpenCV": opencv_files,
    "transforms.json": transforms(frames_of_videos("gone/")),
    "train_meta.json": panoptic,
}
"""Writers of pinhole cameras, none of which name pictures that are there."""
