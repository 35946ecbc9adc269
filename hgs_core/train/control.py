"""Which splats there are: rounds of density control, pruning, births and labelling over a training state."""

from __future__ import annotations

import dataclasses
from typing import TypeVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.points.sweep import depth_ranges
from hgs_core.render.fixed_view import FixedView
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.adam import Adam
from hgs_core.train.births import Births, chosen_births, find_births, picture_error
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.density import DensityRound, is_fog, joined, refine
from hgs_core.train.hull import ever_inside, strayed
from hgs_core.train.infill import find_infill
from hgs_core.train.initialise import initial_splats
from hgs_core.train.lives import haunting, trimmed
from hgs_core.train.relabel import as_dynamics, as_statics, standing_still
from hgs_core.train.residuals import temporal_residuals
from hgs_core.train.schedule import Schedule
from hgs_core.train.segments import CaptureSegment
from hgs_core.train.training_views import TrainingViews

__all__ = ["control_births", "control_contributions", "control_density", "control_infill", "control_labels"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])
Mask = npt.NDArray[np.bool_]

_CONTRIBUTION_MOMENTS = 60  # of the segment at which contributions are weighed, at most
_CONTRIBUTION_FRAMES = 2  # apart: the briefest splat, gone by half in half a frame, still has a sixteenth a frame on
_BIRTH_INSTANTS = 30  # of the segment that a round of births looks at
_BIRTH_OPACITY = 0.6
_INFILL_OPACITY = 0.5
_MOST_AT_ONCE = 0.02  # share of the statics that one round may make dynamic, the most restless first (as Ex4DGS)


def control_density(
    state: TrainState,
    schedule: Schedule,
    cycle: int,
    first_counts: tuple[int, int],
    camera: Camera,  # the last view's: screen gradients are measured in half widths of its picture
    statics_learn: bool,
) -> None:
    """Prune, clone and split both sets, each within its own budget; children inherit their parent's label."""
    config, statics = schedule.config, len(state.static)
    most_static, most_dynamic = schedule.splat_budgets
    generator = torch.Generator().manual_seed(int(np.random.default_rng((config.seed, 3, cycle)).integers(2**62)))

    def plan(first: int, most: int) -> DensityRound:
        budget = schedule.budget(cycle, first, most)
        half_width = 0.5 * max(camera.width, camera.height)
        return DensityRound(budget, schedule.extent, half_width, config, generator)

    seen = state.statistics
    if statics_learn and statics:
        static_seen = seen.rows(slice(0, statics))
        state.static = refine(state.static, state.static_adam, static_seen, plan(first_counts[0], most_static))
    if len(state.dynamic):
        dynamic_seen = seen.rows(slice(statics, None))
        state.dynamic = refine(state.dynamic, state.dynamic_adam, dynamic_seen, plan(first_counts[1], most_dynamic))
    state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def control_contributions(
    state: TrainState, schedule: Schedule, views: TrainingViews, segment: CaptureSegment, statics_learn: bool
) -> None:
    """Remove the splats that no training view needs, and dynamic ones that are fog or have left the hull of what moves.

    No view needs those whose largest weight T alpha in any pixel is too small.
    """
    config, statics = schedule.config, len(state.static)
    peak = np.zeros(statics + len(state.dynamic), np.float32)
    moments_asked = min(_CONTRIBUTION_MOMENTS, -(-segment.frames // _CONTRIBUTION_FRAMES))
    for camera, moments in views.poses(moments_asked):
        fixed = FixedView(state.static, camera, antialiased=config.antialiased, backend=config.backend)
        for moment in moments:
            np.maximum(peak, fixed.contributions(state.dynamic, moment).peak, out=peak)
    needed = peak >= config.prune_contribution
    needed[statics:] &= ~is_fog(state.dynamic, schedule.extent, config).numpy()
    if views.masked:
        needed[statics:] &= ~strayed(state.dynamic, views.cameras, segment.frames, views.moving)
    if statics_learn:
        state.static = _kept(state.static, state.static_adam, needed[:statics])
    state.dynamic = _kept(state.dynamic, state.dynamic_adam, needed[statics:])
    state.history.pruned += len(peak) - len(state.static) - len(state.dynamic)
    state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def control_births(
    state: TrainState, schedule: Schedule, views: TrainingViews, segment: CaptureSegment, cycle: int
) -> None:
    """Add dynamic splats where moving pixels are wrong, at moments all over the segment, in half of the room left.

    Before, the lives of those there are end where still pixels are wrong.
    """
    config = schedule.config
    generator = np.random.default_rng((config.seed, 5, cycle))
    instants = min(_BIRTH_INSTANTS, segment.frames)
    most = max(0, schedule.splat_budgets[1] - len(state.dynamic)) // 2
    known = torch.cat([state.static.means, state.dynamic.motion[:, 0]]).numpy()
    ranges = depth_ranges(views.cameras, known)
    fixed = [
        FixedView(state.static, camera, antialiased=config.antialiased, backend=config.backend)
        for camera in views.cameras
    ]
    born, moments, ghosts = [], [], []
    for instant in views.instants(instants, generator):
        errors = [
            picture_error(view.frame(state.dynamic, instant.moment).rgb, truth)
            for view, truth in zip(fixed, instant.pictures, strict=True)
        ]
        moments.append(instant.moment)
        ghosts.append(haunting(state.dynamic, views.cameras, instant.moment, instant.moving, errors))
        if most == 0:
            continue
        found = find_births(views.cameras, instant.pictures, instant.moving, errors, ranges)
        count = len(found.points)
        alive, moving = np.full(count, instant.seconds, np.float32), np.ones(count, np.float32)
        born.append(Births(dataclasses.replace(found.points, times=alive, dynamic=moving), found.urgency))
    shortened, changed = trimmed(state.dynamic, np.array(moments), np.stack(ghosts))
    state.dynamic = _kept(state.dynamic, state.dynamic_adam, ~changed, shortened.take(_rows(changed)))
    # They live for about a frame: what lives longer will learn to. So few cycles show them that they start opaque.
    points = chosen_births(born, most, generator)
    coefficients = state.dynamic.motion.shape[1]
    _, dynamic = initial_splats(
        points, segment.clock, segment.frames, opacity=_BIRTH_OPACITY, coefficients=coefficients
    )
    state.dynamic = _kept(state.dynamic, state.dynamic_adam, None, dynamic)
    state.history.births += len(dynamic)
    state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def control_infill(
    state: TrainState, schedule: Schedule, views: TrainingViews, segment: CaptureSegment, cycle: int
) -> None:
    """Add static splats where still pixels are wrong, at most the share `infill` of the budget."""
    config, budget = schedule.config, schedule.splat_budgets[0]
    generator = np.random.default_rng((config.seed, 6, cycle))
    most = min(round(config.infill * budget), budget - len(state.static))
    if most <= 0:
        return
    ranges = depth_ranges(views.cameras, state.static.means.numpy())
    points = find_infill(
        state.static, state.dynamic, views.everywhere(cycle), config, state.shown, ranges, most, generator
    )
    static, _ = initial_splats(points, segment.clock, segment.frames, opacity=_INFILL_OPACITY)
    state.static = _kept(state.static, state.static_adam, None, static)
    state.history.infilled += len(static)
    state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def control_labels(state: TrainState, schedule: Schedule, views: TrainingViews, cycle: int) -> None:
    """Make dynamic splats that stand still static, and statics under which the error varies with time dynamic.

    The config's `still_pixels` and `restless_error` are the two thresholds. Where it is known what moves, a static must
    lie in the hull of it at a moment: the error under a false point in the air varies, too, with what passes behind it.
    """
    config = schedule.config
    restless = np.zeros(len(state.static), np.bool_)
    room = schedule.splat_budgets[1] - len(state.dynamic)
    if config.restless_error > 0 and room > 1 and len(state.static):
        varies = temporal_residuals(state.static, state.dynamic, views.samples(cycle), config, state.shown)
        most = min(int(_MOST_AT_ONCE * len(state.static)), room // 2)
        worst = np.argsort(-varies, kind="stable")[:most]
        worst = worst[varies[worst] > config.restless_error]
        if views.masked:
            worst = worst[ever_inside(state.static.means.numpy()[worst], views.cameras, schedule.frames, views.moving)]
        restless[worst] = True
    still = standing_still(state.dynamic, views.cameras, config.still_pixels)
    to_static = as_statics(state.dynamic.take(_rows(still)))
    to_dynamic = as_dynamics(state.static.take(_rows(restless)), state.dynamic.motion.shape[1])
    state.static = _kept(state.static, state.static_adam, ~restless, to_static)
    state.dynamic = _kept(state.dynamic, state.dynamic_adam, ~still, to_dynamic)
    state.history.relabelled(len(to_static), int(restless.sum()))
    state.statistics = ScreenStatistics.zeros(len(state.static) + len(state.dynamic))


def _kept(splats: S, adam: Adam[S], kept: Mask | None, added: S | None = None) -> S:
    """Return the splats that are kept (None: all) and those added; the optimiser follows, with no moments of these."""
    rows = torch.arange(len(splats)) if kept is None else _rows(kept)
    adam.select(rows, 0 if added is None else len(added))
    left = splats.take(rows)
    return left if added is None else joined(left, added)


def _rows(mask: Mask) -> Tensor:
    return torch.from_numpy(np.flatnonzero(mask))
