"""Control of the set of splats between steps of a training, one round a file.

A round says after which iterations it is due and what it then does. A new one is a file with a class, and its place in
`rounds`, which says the order in which rounds follow one iteration.
"""

from __future__ import annotations

from hgs_core.points.backdrop import Backdrop
from hgs_core.points.far_apart import LONG
from hgs_core.train.control.backdrop_fill import BackdropFill
from hgs_core.train.control.backdrop_round import BackdropRound
from hgs_core.train.control.births import BirthRound
from hgs_core.train.control.density import DensityRound
from hgs_core.train.control.hull_round import HullRound
from hgs_core.train.control.infill import InfillRound
from hgs_core.train.control.moving_steps import MovingSteps
from hgs_core.train.control.pruning import PruningRound
from hgs_core.train.control.relabelling import LabelRound
from hgs_core.train.control.round import Round, RoundContext
from hgs_core.train.control.silhouette_steps import SilhouetteSteps
from hgs_core.train.train_config import TrainConfig

__all__ = ["Round", "RoundContext", "rounds"]


def rounds(
    config: TrainConfig, *, masked: bool, statics_learn: bool, backdrop: Backdrop | None = None
) -> tuple[Round, ...]:
    """Return the rounds of a training in the order in which they follow an iteration.

    Args:
        config: of the run.
        masked: whether it is known what moves.
        statics_learn: whether the segment trains the statics; they stay as they are otherwise.
        backdrop: surface that statics lie on where cameras stand far apart: movers stay in their hull then.
    """
    if backdrop is not None:
        return _far_apart(config, backdrop, statics_learn=statics_learn)
    found: list[Round] = [PruningRound(config)]
    if masked:
        found.append(BirthRound(config))
    if masked and config.moving_steps:
        found.insert(0, MovingSteps(config))
    if statics_learn:
        found.append(InfillRound(config))
    found.append(DensityRound(config))
    if statics_learn:
        found.append(LabelRound(config))
    return tuple(found)


def _far_apart(config: TrainConfig, backdrop: Backdrop, *, statics_learn: bool) -> tuple[Round, ...]:
    """Return the rounds of cameras that stand far apart: statics are added nowhere but on the backdrop."""
    over_room = config.moving_steps > 0 and config.iterations >= LONG
    found: list[Round] = [SilhouetteSteps(config, throughout=not over_room), PruningRound(config)]
    if over_room:
        found = [MovingSteps(config), *found, BirthRound(config)]
    found += [DensityRound(config), HullRound(config, backdrop)]
    if statics_learn:
        found += [BackdropFill(config, backdrop), BackdropRound(config, backdrop)]
    return tuple(found)
