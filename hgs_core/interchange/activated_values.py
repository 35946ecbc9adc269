"""Scales and opacities that stand in a file as they are drawn, where logarithms and logits belong."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Doubles, Floats, Mask
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.deviations import log_scales_of
from hgs_core.scene.opacities import logits_of_any

__all__ = ["Stored", "as_stored"]

ENOUGH = 30  # splats, of which fewer tell nothing together
SPREAD = 0.5  # between the least and the largest opacity: logits that differ so little all stay beyond [0, 1]
EVEN = 1.0  # between the least and the largest scale: logarithms that differ so little are rare
TOO_LARGE = 8.0  # standard deviations, in gaps between neighbours
SAMPLE = 64  # splats whose neighbours are looked for


@dataclass(frozen=True)
class Stored:
    """Logarithms of scales [N, 3] and logits of opacities [N], with the changes to the file's numbers."""

    log_scales: Floats
    logits: Floats
    changes: tuple[Change, ...] = ()


def as_stored(
    path: Path, scales: Doubles, opacities: Doubles, places: Doubles, activated: bool | None, counted: Mask
) -> Stored:
    """Return logarithms and logits of a file's `scales` [N, 3] and `opacities` [N], whichever it holds.

    `activated` says that they stand there as they are drawn, those at least whose range allows it, False that they do
    not; None: their ranges tell. Scales that are all positive and opacities that all lie in 0 to 1 are what no training
    leaves of logarithms and logits. Of that the splats tell that are `counted` [N].

    Raises:
        InputError: the ranges fit both, or `activated` holds and they fit neither.
    """
    finite = np.isfinite(scales).all(axis=1) & np.isfinite(opacities) & counted
    if activated is False or not finite.any():
        return _stored(scales, opacities, bool(activated), bool(activated))
    shown, opaque = scales[finite], opacities[finite]
    positive = bool((shown >= 0).all() and (shown > 0).any())
    share = bool(((opaque >= 0) & (opaque <= 1)).all())
    many = int(finite.sum()) >= ENOUGH
    if activated and not positive and not share:
        problem = f"scales from {shown.min():.3g} and opacities of {opaque.min():.3g} to {opaque.max():.3g} are none"
        raise InputError(path, f"holds no number as it is drawn: {problem}", "import it without --activated")
    if activated or (positive and share):
        return _stored(scales, opacities, positive, share)
    if positive and many and (float(np.ptp(shown)) < EVEN or _larger_than_gaps(shown, places[finite])):
        _ask(path, f"all scales are positive, {shown.min():.3g} to {shown.max():.3g}, which logarithms seldom are")
    if share and many:
        if float(np.ptp(opaque)) > SPREAD:
            return _stored(scales, opacities, False, True)
        _ask(path, f"all opacities lie in {opaque.min():.3g} to {opaque.max():.3g}, as logits or as they are drawn")
    return _stored(scales, opacities, False, False)


def _ask(path: Path, problem: str) -> None:
    raise InputError(
        path,
        f"may hold scales and opacities as they are drawn: {problem}",
        "import it with --activated if so, with --no-activated if they are logarithms and logits",
    )


def _larger_than_gaps(scales: Doubles, places: Doubles) -> bool:
    """Return whether scales taken as logarithms are far larger than the gaps between splats, and as they stand not."""
    places = places[np.isfinite(places).all(axis=1)]
    if len(places) < ENOUGH:
        return False
    chosen = places[:: max(1, len(places) // SAMPLE)]
    with np.errstate(over="ignore"):
        nearest = [np.partition(((places - one) ** 2).sum(axis=1), 1)[1] for one in chosen]
    gap = float(np.sqrt(np.median(nearest)))
    size = float(np.median(scales))
    return float(np.exp(min(size, 700.0))) > TOO_LARGE * gap and size <= TOO_LARGE * gap


def _stored(scales: Doubles, opacities: Doubles, drawn_scales: bool, drawn_opacities: bool) -> Stored:
    changes = []
    for drawn, what, how in ((drawn_scales, "scale", "logarithms"), (drawn_opacities, "opacity", "logits")):
        if drawn:
            reason = f"by their {how}: the file holds them as they are drawn"
            changes.append(Change(Action.REPLACED, what, len(scales), len(scales), reason))
    with np.errstate(over="ignore"):
        logits = logits_of_any(np.where(np.isfinite(opacities), opacities, 0.5)) if drawn_opacities else None
        return Stored(
            log_scales_of(scales) if drawn_scales else scales.astype(np.float32),
            opacities.astype(np.float32) if logits is None else np.where(np.isnan(opacities), np.nan, logits),
            tuple(changes),
        )
