"""Scenes that break rasterizers: the required pictures, and the tolerance of float32.

`CASES` is read by test_hard_cases.py and by scripts/hard_cases.py, which prints the errors. The bounds are a few
times the measured errors; none is wider than float32 requires. A case says so where a decision at a threshold (alpha
1/255, transmittance 1e-4) may fall differently.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hgs_core.render.types import Render, View
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

Static = StaticSplats[Tensor]
Dynamic = DynamicSplats[Tensor]

# Relative L2 errors that a case has to stay below unless it says another bound (docs/numerics.md says why).
IMAGE, GRADIENT = 5e-6, 1e-5


@dataclass(frozen=True)
class HardCase:
    static: Static | None
    dynamic: Dynamic | None
    view: View
    drawn: Callable[[Render], bool] = lambda render: bool(render.alpha.any())  # true of the float64 picture
    image: float = IMAGE  # bounds, relative L2
    gradient: float = GRADIENT


CASES: dict[str, Callable[[], HardCase]] = {}


def case(build: Callable[[], HardCase]) -> Callable[[], HardCase]:
    CASES[build.__name__] = build
    return build


def nothing_drawn(render: Render) -> bool:
    return not render.alpha.any()


def view(over: Camera | None = None, time: float = 0.4, antialiased: bool = False) -> View:
    return View(over or camera(48, 32), time, antialiased=antialiased, depth=True)


def magnified(seen: View, times: int) -> View:
    """Return a view of splats that were trained on pictures so many times smaller."""
    return dataclasses.replace(seen, rig=(seen.camera.scaled(1 / times),))


def front(width: int = 48, height: int = 32, focal: float = 40.0, near: float = 0.01) -> Camera:
    """A camera at the origin that looks along z."""
    return Camera("front", width, height, focal, focal, width / 2, height / 2, np.eye(4), near)


def stills(count: int = 60, seed: int = 0, **fields: Tensor) -> Static:
    return dataclasses.replace(static_splats(count, seed), **fields)


def movers(count: int = 60, seed: int = 1, **fields: Tensor) -> Dynamic:
    return dataclasses.replace(dynamic_splats(count, seed), **fields)


def uniform(low: float, high: float, *shape: int, seed: int = 7) -> Tensor:
    return torch.tensor(np.random.default_rng(seed).uniform(low, high, shape))


def sized(count: int, *scales: float) -> Tensor:
    """Log-scales of `count` splats, within a factor of two of `scales` so that none is round."""
    return torch.tensor(scales, dtype=torch.float64).log() + uniform(-0.35, 0.35, count, 3, seed=8)


def joined(*sets: Static) -> Static:
    return StaticSplats(*(torch.cat([getattr(s, f.name) for s in sets]) for f in dataclasses.fields(StaticSplats)))


# Shapes


def needle_splats() -> Static:
    return stills(log_scales=sized(60, 1.0, 1e-4, 1e-4))


@case
def needles() -> HardCase:
    return HardCase(needle_splats(), None, view())


@case
def needles_antialiased() -> HardCase:
    # Most needles are far thinner than a pixel and fade to a few 1/255: opaque ones are left.
    splats = dataclasses.replace(needle_splats(), opacity_logits=uniform(2, 6, 60))
    return HardCase(splats, None, view(antialiased=True), image=1e-5)


@case
def needles_magnified() -> HardCase:
    return HardCase(needle_splats(), None, magnified(view(), 8))


@case
def needles_magnified_antialiased() -> HardCase:
    splats = dataclasses.replace(needle_splats(), opacity_logits=uniform(2, 6, 60))
    return HardCase(splats, None, magnified(view(antialiased=True), 4))


@case
def movers_magnified() -> HardCase:
    return HardCase(stills(), movers(log_scales=sized(60, 0.3, 1e-3, 1e-3)), magnified(view(), 4))


@case
def needles_across_the_picture() -> HardCase:
    return HardCase(stills(log_scales=sized(60, 100.0, 1e-2, 1e-2)), None, view())


@case
def needles_across_a_wide_picture() -> HardCase:
    # A needle turns an error along it into one across it: far from its centre float32 has few digits left.
    splats = stills(log_scales=sized(60, 100.0, 1e-4, 1e-4))
    return HardCase(splats, None, view(front(2000, 32, 1500.0)))


@case
def moving_needles_across_a_tall_picture() -> HardCase:
    splats = movers(log_scales=sized(60, 100.0, 1e-4, 1e-4))
    return HardCase(None, splats, view(front(32, 2000, 1500.0)))


@case
def pancakes() -> HardCase:
    return HardCase(stills(log_scales=sized(60, 0.5, 0.5, 5e-5)), None, view())


@case
def pancakes_seen_from_the_edge() -> HardCase:
    flat = stills(
        quats=torch.tensor([[1.0, 0, 0, 0]], dtype=torch.float64).expand(60, 4) + uniform(-1e-4, 1e-4, 60, 4),
        log_scales=sized(60, 1e-5, 0.5, 0.5),
    )
    return HardCase(flat, None, view(front()))


@case
def sub_pixel() -> HardCase:
    return HardCase(stills(log_scales=sized(60, 1e-5, 2e-5, 4e-5)), None, view())


@case
def sub_pixel_antialiased() -> HardCase:
    # From a thousandth of a pixel, where the compensation stops at 0.005, to a pixel.
    splats = stills(log_scales=uniform(-10, -3, 60, 3), opacity_logits=uniform(2, 8, 60))
    return HardCase(splats, None, view(antialiased=True))


@case
def screen_filling() -> HardCase:
    return HardCase(
        stills(20, log_scales=sized(20, 50.0, 100.0, 200.0), opacity_logits=uniform(-4, 1, 20)),
        None,
        view(),
        gradient=1e-4,
    )


@case
def two_scales_vanish() -> HardCase:
    splats = stills()
    splats.log_scales[:, 1:] = -40 + uniform(-1, 1, 60, 2)
    return HardCase(splats, None, view())


@case
def all_scales_vanish() -> HardCase:
    return HardCase(stills(log_scales=-40 + uniform(-1, 1, 60, 3)), None, view())


@case
def all_scales_vanish_antialiased() -> HardCase:
    splats = stills(log_scales=-40 + uniform(-1, 1, 60, 3), opacity_logits=uniform(2, 8, 60))
    return HardCase(splats, None, view(antialiased=True), image=1e-5)


@case
def scales_beyond_the_limit_are_not_drawn() -> HardCase:
    return HardCase(stills(log_scales=40 + uniform(-1, 1, 60, 3)), None, view(), nothing_drawn)


@case
def scales_that_overflow_harm_no_other() -> HardCase:
    splats = stills(90)
    splats.log_scales[::3] = torch.tensor([40.0, 1e3, 1e30]).repeat(10)[:, None]
    return HardCase(splats, None, view())


@case
def scales_just_below_the_limit() -> HardCase:
    # A standard deviation of 4e8 pixels: one constant colour.
    z = torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64)
    means = torch.stack([torch.zeros(3), torch.zeros(3), z], 1)
    splats = stills(3, means=means, log_scales=(1e7 * z)[:, None].log() + uniform(-0.3, 0, 3, 3), opacity_logits=-z)
    return HardCase(splats, None, view(front()))


# Places


@case
def centres_at_the_near_plane() -> HardCase:
    # Exactly there is drawn; one float32 nearer is not.
    near = np.float32(0.5)
    z = torch.tensor([near, np.nextafter(near, np.float32(0)), np.nextafter(near, np.float32(1))], dtype=torch.float64)
    means = torch.stack([torch.tensor([-0.3, 0.0, 0.3], dtype=torch.float64), torch.zeros(3), z], 1)
    splats = stills(3, means=means, log_scales=sized(3, 0.02, 0.03, 0.04), opacity_logits=torch.full((3,), 2.0))
    shot = view(front(near=0.5))
    return HardCase(splats, None, shot, lambda r: bool(r.alpha[16, :8].any()) and not r.alpha[16, 22:27].any())


@case
def centres_behind_the_camera() -> HardCase:
    splats = stills()
    splats.means[::2, 2] *= -1
    splats.means[1::4, 2] = 0
    return HardCase(splats, None, view(front()))


@case
def everything_behind_the_camera() -> HardCase:
    splats = stills()
    return HardCase(dataclasses.replace(splats, means=-splats.means), None, view(front()), nothing_drawn)


@case
def camera_inside_splats() -> HardCase:
    splats = stills(20, means=uniform(0.011, 0.1, 20, 3), log_scales=sized(20, 1.0, 2.0, 0.5))
    return HardCase(dataclasses.replace(splats, opacity_logits=uniform(-4, 0, 20)), None, view(front()))


@case
def directions_beyond_the_clamp() -> HardCase:
    # Centres far outside the field of view whose clamped Jacobian still reaches into the picture.
    splats = stills(means=torch.cat([uniform(-6, 6, 60, 2), uniform(0.3, 2, 60, 1)], 1), log_scales=sized(60, 1, 2, 3))
    return HardCase(splats, None, view(front()))


@case
def a_million_units_from_the_origin() -> HardCase:
    origin = np.array([1e6, -1e6, 1e6])
    pose = camera().world_to_camera.copy()
    pose[:3, 3] -= pose[:3, :3] @ origin
    still, moving = stills(), movers()
    scale = 30.0  # float32 places are 1/16 apart there
    means = still.means * scale + torch.from_numpy(origin)
    motion = moving.motion * scale
    motion[:, 0] += torch.from_numpy(origin)
    return HardCase(
        dataclasses.replace(still, means=means, log_scales=still.log_scales + math.log(scale)),
        dataclasses.replace(moving, motion=motion, log_scales=moving.log_scales + math.log(scale)),
        view(dataclasses.replace(camera(48, 32), world_to_camera=pose)),
    )


@case
def far_away() -> HardCase:
    # Dots of a third of a pixel, as deep as a light year in metres.
    z = 10 ** uniform(10, 16, 60, 1)
    return HardCase(stills(means=torch.cat([uniform(-0.4, 0.4, 60, 2) * z, z], 1)), None, view(front()))


@case
def means_that_overflow_harm_no_other() -> HardCase:
    splats = stills(90)
    splats.means[::3] = torch.tensor([[1e38, 0, 1], [0, -3e38, 1], [0, 0, -3e38]]).repeat(10, 1).double()
    return HardCase(splats, None, view())


@case
def further_than_the_limit_is_not_drawn() -> HardCase:
    return HardCase(stills(means=stills().means * 1e20), None, view(front()), nothing_drawn)


@case
def at_the_limit_of_depth() -> HardCase:
    z = 10 ** uniform(17, 17.99, 60, 1)
    return HardCase(stills(means=torch.cat([uniform(-0.4, 0.4, 60, 2) * z, z], 1)), None, view(front()))


@case
def equal_depths() -> HardCase:
    still, moving = stills(), movers()
    still.means[:, 2] = 3
    moving.motion[:, 0, 2] = 3
    moving.motion[:, 1:, 2] = 0
    return HardCase(still, moving, view(front()))


@case
def coincident_splats() -> HardCase:
    return HardCase(stills(4).take(torch.arange(4).repeat(50)), None, view())


@case
def ten_thousand_layers() -> HardCase:
    count = 10_000
    means = torch.cat([uniform(-0.3, 0.3, count, 2), torch.linspace(1, 4, count, dtype=torch.float64)[:, None]], 1)
    splats = stills(
        count, means=means, log_scales=sized(count, 1.0, 2.0, 0.7), opacity_logits=uniform(-8.0, -5.5, count)
    )
    return HardCase(splats, None, view(front(4, 4, 3.0)))


# Opacity and colour


@case
def opacity_towards_zero() -> HardCase:
    return HardCase(stills(200, opacity_logits=uniform(-8, -3, 200)), None, view())


@case
def opacity_zero() -> HardCase:
    return HardCase(stills(opacity_logits=uniform(-1e30, -90, 60)), None, view(), nothing_drawn)


@case
def opacity_towards_one() -> HardCase:
    return HardCase(stills(200, opacity_logits=uniform(4, 30, 200)), None, view(), gradient=3e-5)


@case
def opacity_one() -> HardCase:
    return HardCase(stills(opacity_logits=uniform(90, 1e30, 60)), None, view())


@case
def colours_far_outside_the_range() -> HardCase:
    return HardCase(stills(rgb=uniform(-1e4, 1e4, 60, 3)), None, view())


@case
def colours_at_the_limit() -> HardCase:
    return HardCase(stills(rgb=uniform(-1e18, 1e18, 60, 3)), movers(rgb=uniform(-1e18, 1e18, 60, 3)), view())


# Rotations


@case
def zero_quaternions() -> HardCase:
    splats = stills()
    splats.quats[::2] = 0
    return HardCase(splats, None, view())


@case
def huge_quaternions() -> HardCase:
    splats = stills()
    return HardCase(dataclasses.replace(splats, quats=splats.quats * 10 ** uniform(15, 18, 60, 1)), None, view())


@case
def largest_quaternions() -> HardCase:
    splats = stills()
    return HardCase(dataclasses.replace(splats, quats=splats.quats * 5e37), None, view())


@case
def tiny_quaternions() -> HardCase:
    # Below a length of 1e-12 they are the identity.
    splats = stills()
    return HardCase(dataclasses.replace(splats, quats=splats.quats * 1e-15), None, view())


@case
def small_quaternions() -> HardCase:
    splats = stills()
    return HardCase(dataclasses.replace(splats, quats=splats.quats * 1e-10), None, view())


# Time


@case
def time_precision_zero() -> HardCase:
    return HardCase(None, movers(time_log_precisions=uniform(-1e4, -50, 60)), view())


@case
def time_precision_infinite() -> HardCase:
    # Alive at their centre alone.
    splats = movers(90, time_log_precisions=torch.tensor([60.0, 200.0, 1e30]).repeat(30).double())
    splats.time_centers[::2] = 0.5
    return HardCase(None, splats, view(time=0.5))


@case
def time_far_outside_the_segment() -> HardCase:
    splats = movers(time_log_precisions=uniform(-20, -14, 60))
    splats.motion[:, 1:] *= torch.tensor([1e-3, 1e-6, 1e-9], dtype=torch.float64)[:, None]
    return HardCase(None, splats, view(time=1e3))


@case
def everything_dead() -> HardCase:
    return HardCase(None, movers(time_log_precisions=uniform(3, 5, 60)), view(time=-40.0), nothing_drawn)


def cancelling_motion(centre: float, time: float) -> Dynamic:
    """Coefficients of hundreds of units that nearly cancel at `time`."""
    splats = movers(time_centers=torch.full((60,), centre), time_log_precisions=uniform(-3, 0, 60))
    wild = uniform(-500, 500, 60, 3, 3)
    d = time - centre
    splats.motion[:, 0] -= d * (wild[:, 0] + d * (wild[:, 1] + d * wild[:, 2]))
    splats.motion[:, 1:] = wild
    return splats


@case
def cubic_motion_at_the_start_of_the_segment() -> HardCase:
    return HardCase(None, cancelling_motion(1.0, 0.0), view(time=0.0))


@case
def cubic_motion_at_the_end_of_the_segment() -> HardCase:
    return HardCase(None, cancelling_motion(0.0, 1.0), view(time=1.0))


# Cameras and pictures


@case
def one_pixel() -> HardCase:
    return HardCase(stills(), movers(), view(front(1, 1, 1.0)), gradient=3e-5)


@case
def one_row() -> HardCase:
    return HardCase(stills(), movers(), view(front(75, 1, 60.0)))


@case
def one_column() -> HardCase:
    return HardCase(stills(), movers(), view(front(1, 75, 60.0)))


@case
def field_of_view_of_170_degrees() -> HardCase:
    splats = stills(200, means=torch.cat([uniform(-8, 8, 200, 2), uniform(0.2, 2, 200, 1)], 1))
    return HardCase(splats, None, view(front(focal=24 / math.tan(math.radians(85)))))


@case
def tiny_focal_length() -> HardCase:
    return HardCase(stills(), None, view(front(focal=0.05)))


@case
def telephoto() -> HardCase:
    splats = stills(means=torch.cat([uniform(-2e-4, 2e-4, 60, 2), uniform(9, 11, 60, 1)], 1))
    return HardCase(
        dataclasses.replace(splats, log_scales=sized(60, 2e-5, 4e-5, 1e-3)), None, view(front(focal=1e6)), gradient=5e-5
    )


@case
def near_plane_of_a_millionth() -> HardCase:
    splats = stills(
        means=uniform(-1e-6, 1e-6, 60, 3) + torch.tensor([0, 0, 2.5e-6]), log_scales=sized(60, 1e-7, 2e-7, 3e-7)
    )
    return HardCase(splats, None, view(front(near=1e-6)))


@case
def principal_point_outside_the_picture() -> HardCase:
    splats = stills()
    splats.means[:, 0] += 4 * splats.means[:, 2]
    return HardCase(splats, None, view(dataclasses.replace(front(), cx=-136.0)))


@case
def camera_upside_down_and_turned() -> HardCase:
    a, b = 2.5, -1.1
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    pose = np.eye(4)
    pose[:3, :3] = about_z @ about_y
    splats = stills()
    means = splats.means @ torch.from_numpy(pose[:3, :3])  # moved into the turned camera's view
    return HardCase(
        dataclasses.replace(splats, means=means), None, view(dataclasses.replace(front(), world_to_camera=pose))
    )


# Scenes


@case
def no_splats() -> HardCase:
    return HardCase(stills(0), movers(0), view(), nothing_drawn)


@case
def one_splat() -> HardCase:
    means = torch.tensor([[0.1, 0.05, 2.0]], dtype=torch.float64)
    return HardCase(stills(1, means=means), None, view())


@case
def half_precision_values() -> HardCase:
    def rounded(array: Tensor) -> Tensor:
        return array.half().double()

    return HardCase(stills().map(rounded), movers().map(rounded), view())


@case
def everything_at_once() -> HardCase:
    kinds = (
        needles,
        pancakes,
        sub_pixel,
        screen_filling,
        all_scales_vanish,
        scales_that_overflow_harm_no_other,
        centres_behind_the_camera,
        directions_beyond_the_clamp,
        means_that_overflow_harm_no_other,
        opacity_towards_zero,
        opacity_one,
        zero_quaternions,
        huge_quaternions,
        tiny_quaternions,
    )
    still = joined(*(kind().static.take(slice(12)) for kind in kinds))  # type: ignore[union-attr]
    return HardCase(still, cancelling_motion(1.0, 0.4), view(), gradient=5e-5)
