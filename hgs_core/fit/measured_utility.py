"""The utility of every splat, measured by drawing the pictures of a capture."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.bounded_map import bounded_map
from hgs_core.base.cores import core_pool
from hgs_core.codec.encoder.utility import SetUtility, Utility, estimated_utility, pixels_per_unit
from hgs_core.render.contributions import contributions
from hgs_core.render.rasterize import rasterize
from hgs_core.render.threads import one_torch_thread
from hgs_core.render.tiles import tiles_of_dynamic
from hgs_core.scene.camera import Camera
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import DynamicSplats, HybridScene, StaticSplats

__all__ = ["measure_utility"]

CAMERAS_PER_FRAME = 2  # least cameras for dynamic splats; the next frame takes the next cameras
STATIC_VIEWS = 60  # views for static splats, spread over cameras and frames; at least all cameras
LARGEST_LOGIT = math.log(0.98 / 0.02)  # limit of the opacity: near 1 it has no gradient

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def measure_utility(
    scene: HybridScene[Floats],
    cameras: Sequence[Camera],
    times: Doubles,
    *,
    any_background: bool = False,
) -> Utility:
    """Weigh every splat in every frame, from some of `cameras` in turn; `times` [F] are the frames' seconds.

    Whole pictures are drawn for the static splats; for the others the tiles that they touch do. The background is
    black, or, with `any_background`, black or white at random in every pixel and channel: what is missed is then the
    mean over black and white. Of a splat that shows in no picture nothing is known: it is missed without limit, so
    that it is never left out, and is taken to show as its size and opacity let expect, in one picture of two more than
    were drawn.
    """
    static, dynamic = _Weighed.of(scene.static), [_Weighed.of(segment.dynamic) for segment in scene.segments]
    views = list(_views(scene, cameras, times))

    def drawn(random: _Random) -> _Measured:
        return _measured(static, dynamic[random.view.segment], random, antialiased=scene.antialiased)

    with one_torch_thread(), core_pool() as pool:
        randoms = _randoms(views, dynamic, antialiased=scene.antialiased, any_background=any_background)
        for found in bounded_map(pool, drawn, randoms):
            moving = dynamic[found.view.segment]
            moving.add(found.squares[len(scene.static) :], found.dynamic_gradient)
            if found.view.whole:
                static.add(found.squares[: len(scene.static)], found.static_gradient)
    whole = sum(view.whole for view in views)
    return Utility(
        _with_unseen(static.mean(whole), scene.static, scene.static.means, cameras, whole),
        tuple(
            _with_unseen(sums.mean(len(views)), part.dynamic, part.dynamic.motion[:, 0], cameras, len(views))
            for sums, part in zip(dynamic, scene.segments, strict=True)
        ),
    )


def _with_unseen(
    measured: SetUtility,
    splats: StaticSplats[Floats] | DynamicSplats[Floats],
    places: Floats,
    cameras: Sequence[Camera],
    views: int,
) -> SetUtility:
    """Guess the utility of splats that none of the `views` shows: the chance to show in one is 1 / (views + 2)."""
    unseen = measured.shown == 0
    if not unseen.any():
        return measured
    opacity = opacities_of(splats.opacity_logits[unseen])
    scale = pixels_per_unit(places[unseen].astype(np.float64), cameras)
    guess = estimated_utility(splats.log_scales[unseen].astype(np.float64), opacity, scale) / (views + 2)
    shown, missed = measured.shown.copy(), measured.missed.copy()
    shown[unseen], missed[unseen] = guess, np.inf
    return SetUtility(shown, missed)


@dataclass(frozen=True)
class _View:
    segment: int
    camera: Camera
    moment: float  # normalised
    whole: bool  # drawn so, for the static splats


@dataclass(frozen=True)
class _Random:
    """The random numbers of a view."""

    view: _View
    tiles: NDArray[np.bool_] | None  # drawn ones; None: all
    background: Tensor | None  # [3, H, W] 0 or 1; None: black
    signs: Tensor  # [3, H, W] -1 or 1


@dataclass(frozen=True)
class _Measured:
    """The measurement of a view."""

    view: _View
    squares: Doubles  # [N + M] of weights, statics first
    static_gradient: Tensor | None  # [N] of a view that is drawn whole
    dynamic_gradient: Tensor | None  # [M]


def _randoms(
    views: Sequence[_View], dynamic: Sequence[_Weighed[Any]], *, antialiased: bool, any_background: bool
) -> Iterator[_Random]:
    """Yield the views that show something, with random numbers of one sequence."""
    generator = torch.Generator().manual_seed(0)
    for view in views:
        tiles = None
        if not view.whole:
            splats = dynamic[view.segment].splats
            tiles = tiles_of_dynamic(splats, view.camera, view.moment, antialiased=antialiased)
            if not tiles.any():
                continue
        shape = 3, view.camera.height, view.camera.width
        background = torch.randint(0, 2, shape, generator=generator) if any_background else None
        yield _Random(view, tiles, background, torch.randint(0, 2, shape, generator=generator).float() * 2 - 1)


def _measured(static: _Weighed[Any], moving: _Weighed[Any], random: _Random, *, antialiased: bool) -> _Measured:
    """Draw a view and differentiate it; several threads may do that with the same sets."""
    view = random.view
    seen = contributions(
        static.splats, moving.splats, view.camera, view.moment, antialiased=antialiased, tile_mask=random.tiles
    )
    eased = [weighed.eased() for weighed in (static, moving)]
    render = rasterize(
        eased[0],
        eased[1],
        view.camera,
        view.moment,
        gradients="all" if view.whole else "dynamic",
        tile_mask=random.tiles,
        antialiased=antialiased,
    )
    picture = render.rgb
    if random.background is not None:
        picture = picture + (1 - render.alpha) * random.background
    picture.backward(random.signs)  # type: ignore[no-untyped-call]
    squares = seen.total.astype(np.float64) * seen.peak / 2
    return _Measured(view, squares, *(splats.opacity_logits.grad for splats in eased))


def _views(scene: HybridScene[Floats], cameras: Sequence[Camera], times: Doubles) -> Iterator[_View]:
    count = min(max(CAMERAS_PER_FRAME, -(-STATIC_VIEWS // len(times))), len(cameras))
    step = max(1, len(cameras) // count)
    every = max(1, count * len(times) // STATIC_VIEWS)
    for frame, seconds in enumerate(times):
        segment = scene.segment_at(float(seconds))
        number = next(i for i, other in enumerate(scene.segments) if other is segment)
        for i in range(count):
            # The view of a frame that is drawn whole changes from frame to frame, and with it the camera.
            whole = (frame * count + (i + frame // max(1, every // count)) % count) % every == 0
            camera = cameras[(frame + i * step) % len(cameras)]
            yield _View(number, camera, segment.normalised(float(seconds)), whole)


@dataclass(frozen=True)
class _Weighed(Generic[S]):
    """A set with its sums over views: the sizes of errors and of absences of its splats.

    The sum of squares of a splat's weights in a view is taken to be half its total times its peak, as it is for a
    Gaussian of which everything before it lets through the same share.

    Without a splat a pixel changes by alpha times the derivative towards alpha, since it is linear in that. Where a
    loss has the gradient +1 or -1 in every pixel and channel, at random, the splat's gradient is the sum of those
    changes with random signs, whose square is expected to be the sum of their squares (Hutchinson, 1990).
    """

    splats: S
    shown: Doubles
    missed: Doubles

    @staticmethod
    def of(splats: Any) -> _Weighed[Any]:
        return _Weighed(splats.map(torch.from_numpy), np.zeros(len(splats)), np.zeros(len(splats)))

    def eased(self) -> S:
        """Return the splats, no opacity so near 1 that it has no gradient, which it will get."""
        logits = self.splats.opacity_logits.clamp(max=LARGEST_LOGIT).requires_grad_(True)
        return dataclasses.replace(self.splats, opacity_logits=logits)

    def add(self, squares: Doubles, gradient: Tensor | None) -> None:
        """Add a view: its `squares` [N] of weights, and the gradient towards the logits, if it has one."""
        self.shown[:] += squares
        if gradient is not None:
            # d alpha / d logit = alpha (1 - opacity), and 1 / (1 - opacity) = 1 + exp(logit)
            logits = self.splats.opacity_logits.clamp(max=LARGEST_LOGIT)
            change = gradient.double() * (1 + logits.double().exp())
            self.missed[:] += (change**2).numpy()

    def mean(self, views: int) -> SetUtility:
        return SetUtility(self.shown / max(1, views), self.missed / max(1, views))
