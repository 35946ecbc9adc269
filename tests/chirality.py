"""A scene that no mirror leaves as it is: the letters L and R and an arrow, of splats; and how alike pictures are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFilter

from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera, looking_at

Doubles = npt.NDArray[np.float64]
Point = tuple[float, float, float]
Stroke = tuple[Point, Point, tuple[float, float, float]]  # start, end, colour

RED, GREEN, BLUE = (0.9, 0.1, 0.1), (0.1, 0.8, 0.1), (0.2, 0.3, 1.0)

# Of a capture's world: x right, y down, z away from the front camera. The letters stand at different depths.
STROKES: tuple[Stroke, ...] = (
    ((-1.2, -0.6, 0.0), (-1.2, 0.6, 0.0), RED),  # L
    ((-1.2, 0.6, 0.0), (-0.6, 0.6, 0.0), RED),
    ((-0.35, 0.2, -0.5), (0.25, -0.3, -0.5), GREEN),  # an arrow to the upper right
    ((0.25, -0.3, -0.5), (-0.05, -0.3, -0.5), GREEN),
    ((0.25, -0.3, -0.5), (0.25, 0.0, -0.5), GREEN),
    ((0.5, -0.6, 0.5), (0.5, 0.6, 0.5), BLUE),  # R
    ((0.5, -0.6, 0.5), (1.0, -0.6, 0.5), BLUE),
    ((1.0, -0.6, 0.5), (1.0, 0.0, 0.5), BLUE),
    ((1.0, 0.0, 0.5), (0.5, 0.0, 0.5), BLUE),
    ((0.6, 0.0, 0.5), (1.0, 0.6, 0.5), BLUE),
)
STEP = 0.05  # world units from splat to splat
THICKNESS = 0.04  # standard deviation

RIGHT = 0.85  # a picture of the scene correlates at least so with the drawing of it
MIRRORED = 0.6  # and at most so with its mirror images


def letters(*, moving: bool = False) -> HybridScene[npt.NDArray[np.float32]]:
    """Return the scene: a still one, or one in which the blue letter is of dynamic splats that do not move."""
    kept = [stroke for stroke in STROKES if not (moving and stroke[2] == BLUE)]
    still = _needles(kept)
    segment = Segment(0.0, 0.0, DynamicSplats.empty())
    if moving:
        blue = _needles([stroke for stroke in STROKES if stroke[2] == BLUE])
        count = len(blue)
        motion = np.zeros((count, 4, 3), np.float32)
        motion[:, 0] = blue.means
        rotation = np.zeros((count, 2, 4), np.float32)
        rotation[:, 0] = blue.quats
        middle, steady = np.full(count, 0.5, np.float32), np.full(count, -3.0, np.float32)
        segment = Segment(
            0.0, 1.0, DynamicSplats(motion, rotation, blue.log_scales, blue.opacity_logits, middle, steady, blue.rgb)
        )
    return HybridScene(still, (segment,))


def _needles(strokes: list[Stroke]) -> StaticSplats[npt.NDArray[np.float32]]:
    """Splats along strokes, each twice as long as thick, turned about z to lie along its stroke."""
    means, quats, rgb = [], [], []
    for start, end, colour in strokes:
        a, b = np.asarray(start), np.asarray(end)
        count = int(np.linalg.norm(b - a) / STEP) + 1
        angle = float(np.arctan2(b[1] - a[1], b[0] - a[0]))
        for share in np.linspace(0, 1, count):
            means.append(a + share * (b - a))
            quats.append((np.cos(angle / 2), 0, 0, np.sin(angle / 2)))
            rgb.append(colour)
    scales = np.tile(np.log([2 * THICKNESS, THICKNESS, THICKNESS]), (len(means), 1))
    opacities = np.full(len(means), 1.0)
    arrays = (np.array(array, np.float32) for array in (means, scales, quats, opacities, rgb))
    return StaticSplats(*arrays)


def views(width: int, height: int) -> list[Camera]:
    """Return cameras in front of the letters, and above and to their left, where depth shows as well."""
    f = 0.9 * width
    poses = {
        "front": looking_at((0.0, 0.0, -4.0), (0.0, 0.0, 0.0)),
        "above": looking_at((-1.8, -1.5, -3.3), (0.0, 0.0, 0.0)),
    }
    return [Camera(name, width, height, f, f, width / 2, height / 2, pose) for name, pose in poses.items()]


def drawing(camera: Camera, *, strokes: tuple[Stroke, ...] = STROKES) -> Doubles:
    """Return the strokes as a camera sees them, [H, W, 3], drawn with lines by another hand than the renderer's."""
    fine = 4
    picture = Image.new("RGB", (fine * camera.width, fine * camera.height))
    pen = ImageDraw.Draw(picture)
    for start, end, colour in sorted(strokes, key=lambda stroke: -stroke[0][2]):
        ends = [_seen(camera, point) for point in (start, end)]
        width = fine * 4 * THICKNESS * camera.fx / np.mean([depth for _, _, depth in ends])
        paint = tuple(round(255 * channel) for channel in colour)
        pen.line([(fine * x, fine * y) for x, y, _ in ends], fill=paint, width=max(1, round(width)))
    small = picture.filter(ImageFilter.GaussianBlur(fine)).resize((camera.width, camera.height), Image.Resampling.BOX)
    return np.asarray(small) / 255.0


def _seen(camera: Camera, point: Point) -> tuple[float, float, float]:
    x, y, z = camera.world_to_camera[:3, :3] @ point + camera.world_to_camera[:3, 3]
    return camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy, float(z)


def correlation(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Return how alike two pictures are: 1 if they are the same but for brightness and contrast."""
    x, y = (np.asarray(picture, np.float64) - np.mean(picture) for picture in (a, b))
    return float((x * y).sum() / np.sqrt((x * x).sum() * (y * y).sum()))


def assert_not_mirrored(picture: npt.ArrayLike, camera: Camera) -> None:
    """Check that a picture [H, W, 3] on black is of the letters, and of none of their mirror images."""
    truth = drawing(camera)
    assert correlation(picture, truth) >= RIGHT
    for image in (truth[:, ::-1], truth[::-1], truth[::-1, ::-1]):
        assert correlation(picture, image) <= MIRRORED
    behind = tuple(((*a[:2], -a[2]), (*b[:2], -b[2]), colour) for a, b, colour in STROKES)
    assert correlation(picture, drawing(camera, strokes=behind)) < correlation(picture, truth) - 0.05
