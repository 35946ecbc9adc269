"""The rows of an ablation: each changes one thing of the full method and asks one question."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hgs_core.ablate.mask_changes import MaskChange, blobs_added, components_dropped, eroded, grown_to_share
from hgs_core.base.errors import InputError
from hgs_core.decompose.morphology import dilate
from hgs_core.runs.run_config import RunConfig

__all__ = ["FULL", "ROWS", "Row", "rows_named"]

_MASK_SHARES = (20, 40, 60, 80, 95)  # % of the picture
_MASK_PIXELS = 3  # pixels of erosion or dilation
_DROPPED_SHARE = 0.3  # share of the components
_BLOBS, _BLOB_SHARE = 8, 0.05  # discs in each picture, and what they cover of it


@dataclass(frozen=True)
class Row:
    """One change of the full method."""

    name: str
    asks: str  # the question, in a sentence
    fields: Mapping[str, Any] = field(default_factory=dict)  # dotted path -> replacement in the config
    masks: MaskChange | None = None  # done to every training mask, before the first points are found
    masks_vary: bool = False  # different masks for each seed
    statics_at_rest: bool = False  # not trained: the statics of the full run are stored as dynamics at rest

    def config(self, base: RunConfig, seed: int) -> RunConfig:
        """Return the config of this row's run with a seed."""
        return base.changed({"seed": seed, **self.fields})


def _grown(share: float) -> MaskChange:
    return lambda mask, _: grown_to_share(mask, share)


FULL = Row("full", "The whole method: what every other row is compared with.")

ROWS: Mapping[str, Row] = {
    row.name: row
    for row in (
        FULL,
        Row("no-interleaved-init", "Are moving points of one moment enough to start from?", {"points.interval": 1e6}),
        Row("coarse-points", "Does multi-view stereo help, or is a coarse sweep enough?", {"points.stereo": False}),
        Row("confirmed-points", "Are points that several cameras agree on enough?", {"points.continued": False}),
        Row("discs", "Do first splats that are discs in their surfaces help?", {"points.discs": True}),
        Row(
            "train-separate",
            "Can each set learn alone, where the masks say it belongs?",
            {"train.stages": "separate"},
        ),
        Row(
            "two-stage",
            "Is one step for each set, the statics first, better than one?",
            {"train.stages": "interleaved"},
        ),
        Row("order-1", "Is straight motion enough?", {"train.motion_order": 1}),
        Row("order-2", "Is motion with constant acceleration enough?", {"train.motion_order": 2}),
        Row("order-5", "Does motion of the fifth order, in place of a cubic, show more?", {"train.motion_order": 5}),
        Row(
            "all-dynamic",
            "What does the division save: a single set of dynamic splats with the whole budget?",
            {"train.labels.initial": "dynamic", "train.labels.adaptive": False},
        ),
        Row(
            "all-static",
            "What is time worth: a single set of static splats with the whole budget?",
            {"train.labels.initial": "static", "train.labels.adaptive": False, "train.density.birth_rounds": 0},
        ),
        Row(
            "no-parameter-sharing",
            "What would the full scene weigh if its statics were dynamic splats at rest?",
            statics_at_rest=True,
        ),
        Row("no-colour-correction", "Do the cameras' colour maps help?", {"train.colour_correction": False}),
        Row("no-lens-falloff", "Does learning how lenses darken corners help?", {"train.lens_falloff": False}),
        Row("no-time-shifts", "Does learning how late cameras are help?", {"train.time_shifts": False}),
        Row(
            "no-births",
            "Do splats that are born where moving pixels are wrong help?",
            {"train.density.birth_rounds": 0},
        ),
        Row(
            "no-opacity-penalty",
            "Does a steady pull of all opacities towards transparency help?",
            {"train.density.static_opacity_penalty": 0.0, "train.density.dynamic_opacity_penalty": 0.0},
        ),
        Row(
            "no-infill",
            "Do statics that are added where still pixels stay wrong help?",
            {"train.density.infill": 0.0},
        ),
        Row(
            "no-moving-steps",
            "Do further steps of the dynamics alone, where it moves, help?",
            {"train.moving_steps": 0.0},
        ),
        Row("no-settling", "Do steps that become small at the end help?", {"train.settled": 1.0}),
        Row(
            "no-mean",
            "Do steps that are held at the end, and the mean of the splats over the last of them, help?",
            {"train.hold_from": 1.0, "train.average_from": 1.0},
        ),
        Row("equal-steps", "Do smaller steps of what lives shortly help?", {"train.steps_by_life": False}),
        Row("fixed-labels", "Does it help that labels follow the evidence?", {"train.labels.adaptive": False}),
        *(
            Row(
                f"masks-{share}",
                f"What if masks call {share} % of every picture moving?",
                masks=_grown(share / 100),
            )
            for share in _MASK_SHARES
        ),
        Row(
            "masks-eroded",
            f"What if masks are {_MASK_PIXELS} pixels too narrow?",
            masks=lambda m, _: eroded(m, _MASK_PIXELS),
        ),
        Row(
            "masks-dilated",
            f"What if masks are {_MASK_PIXELS} pixels too wide?",
            masks=lambda m, _: dilate(m, _MASK_PIXELS),
        ),
        Row(
            "masks-dropped",
            f"What if masks miss {_DROPPED_SHARE:.0%} of the components that move?",
            masks=lambda mask, generator: components_dropped(mask, generator, _DROPPED_SHARE),
            masks_vary=True,
        ),
        Row(
            "masks-blobs",
            f"What if masks call {_BLOBS} random discs, {_BLOB_SHARE:.0%} of the picture, moving too?",
            masks=lambda mask, generator: blobs_added(mask, generator, _BLOBS, _BLOB_SHARE),
            masks_vary=True,
        ),
    )
}
"""By name, in the order of the table."""


def rows_named(names: Sequence[str] | None) -> tuple[Row, ...]:
    """Return the rows of these names, or all; the full method is always the first.

    Raises:
        InputError: there is no such row.
    """
    for name in names or ():
        if name not in ROWS:
            raise InputError("--rows", f"there is no row {name!r}", f"use {', '.join(ROWS)}")
    chosen = list(ROWS) if names is None else names
    return tuple(ROWS[name] for name in dict.fromkeys((FULL.name, *chosen)))
