"""USD files: splats as `ParticleField3DGaussianSplat` of OpenUSD 26.3 and newer, with time samples of moving splats.

Static splats are one prim; the splats of a segment are another, shown for its time. Scales and opacities are linear,
colours are 0.5 + SH_0 of degree 0; axes are right, up, back. Files are written by `usd-core`, of the extra `usd`.
"""

from __future__ import annotations

import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.antialiasing_note import NOTE
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.deviations import deviations_limited, deviations_of
from hgs_core.interchange.file_format import FileFormat
from hgs_core.interchange.ply.gaussian_ply import NO_NEGATIVE_COLOUR
from hgs_core.interchange.right_up_back import other_way_up, stored_rotations
from hgs_core.interchange.splat_properties import SH_0
from hgs_core.interchange.still_moment import LEAST_OPACITY
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.temporal import evaluate

__all__ = ["USD", "still_usd_file", "usd_file"]

ROOT = "/Scene"
_REACH = 3.0  # standard deviations
_FINEST = 1001  # denominator of rates: 30000/1001


class _Stage:
    """A stage in the making: one prim for each set of splats."""

    def __init__(self, antialiased: bool) -> None:
        try:
            from pxr import Usd, UsdGeom, UsdVol, Vt
        except ImportError as error:
            raise InputError(".usd", "needs the package usd-core", "pip install 'hgs[usd]'") from error
        self._vol, self._arrays = UsdVol, Vt
        self.stage: Any = Usd.Stage.CreateInMemory()
        self.stage.SetDefaultPrim(UsdGeom.Xform.Define(self.stage, ROOT).GetPrim())
        self.stage.GetRootLayer().customLayerData = {NOTE: antialiased}
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)

    def add(self, name: str, splats: StaticSplats[Floats] | DynamicSplats[Floats]) -> Any:
        """Return a new prim with the attributes that never change."""
        prim = self._vol.ParticleField3DGaussianSplat.Define(self.stage, f"{ROOT}/{name}")
        harmonics = (splats.rgb.astype(np.float64) - 0.5) / SH_0
        prim.CreateScalesAttr(self._triples(deviations_of(splats.log_scales)))
        prim.CreateRadianceSphericalHarmonicsDegreeAttr(0)
        prim.CreateRadianceSphericalHarmonicsCoefficientsAttr(self._triples(harmonics))
        return prim

    def place(
        self, prim: Any, moment: Any, places: Doubles | Floats, quats: Doubles | None, opacities: Doubles
    ) -> None:
        """Set the rest, at a time code or for all of them; rotations of None stay."""
        prim.CreatePositionsAttr().Set(self._triples(other_way_up(places)), moment)
        prim.CreateOpacitiesAttr().Set(self._arrays.FloatArray.FromNumpy(opacities.astype(np.float32)), moment)
        if quats is not None:
            turns = np.ascontiguousarray(stored_rotations(quats), np.float32)
            prim.CreateOrientationsAttr().Set(self._arrays.QuatfArray.FromNumpy(turns), moment)

    def bound(self, prim: Any, low: Doubles, high: Doubles, log_scales: Floats) -> None:
        """Set the box around places between two corners of our axes."""
        reach = _REACH * float(deviations_of(log_scales).max())
        corners = other_way_up(np.stack([low - reach, high + reach]))
        prim.CreateExtentAttr(self._triples(np.sort(corners, axis=0)))

    def file(self) -> bytes:
        """Return the binary file.

        Raises:
            InputError: it would hold nothing.
        """
        if not self.stage.GetDefaultPrim().GetChildren():
            raise InputError("splats", "are none", "choose another time")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "scene.usdc")
            self.stage.GetRootLayer().Export(str(path))
            return path.read_bytes()

    def _triples(self, values: Doubles | Floats) -> Any:
        return self._arrays.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))


def still_usd_file(splats: StaticSplats[Floats], antialiased: bool = False) -> Written:
    """Return the file of a still scene.

    Raises:
        InputError: the library is missing, or there are no splats.
    """
    made = _Stage(antialiased)
    _add_still(made, splats)
    return Written(made.file(), tuple(_changes(splats.log_scales, splats.rgb, antialiased)))


def usd_file(scene: HybridScene[Floats], rate: float) -> Written:
    """Return the file of a whole scene, with samples of moving splats at `rate` a second: time code = second x rate.

    Raises:
        InputError: the library is missing, the rate is not positive, or no sample shows a splat.
    """
    if not rate > 0:
        raise InputError("--fps", f"{rate:g} is not positive", "give samples for each second, like 30")
    rate = float(Fraction(rate).limit_denominator(_FINEST))
    made = _Stage(scene.antialiased)
    stage = made.stage
    count = int((scene.end - scene.start) * rate + 1e-6) + 1 if scene.dynamic_splats else 1
    times = np.minimum(scene.start + np.arange(count) / rate, scene.end)
    codes = scene.start * rate + np.arange(count, dtype=np.float64)
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(codes[0])
    stage.SetEndTimeCode(codes[-1])
    _add_still(made, scene.static)
    shown = 0
    for number, segment in enumerate(scene.segments):
        own = [scene.segment_at(float(time)) is segment for time in times]
        shown += _add_moving(made, f"moving_{number}", segment, times[own], codes[own])
    total, moving = len(scene.static) + scene.dynamic_splats, scene.dynamic_splats
    samples = f"by {count} samples, {rate:g} a second, and straight between them"
    rgb, scales = (
        np.concatenate([getattr(scene.static, name), *(getattr(part.dynamic, name) for part in scene.segments)])
        for name in ("rgb", "log_scales")
    )
    return Written(
        made.file(),
        (
            Change(Action.LEFT_OUT, "splats", moving - shown, total, "no sample shows them"),
            Change(Action.REPLACED, "motion, turning and life", shown, total, samples),
            *_changes(scales, rgb, scene.antialiased),
        ),
    )


def _add_still(made: _Stage, splats: StaticSplats[Floats]) -> None:
    if len(splats):
        prim = made.add("static", splats)
        made.place(prim, _always(), splats.means, unit_quaternions(splats.quats), opacities_of(splats.opacity_logits))
        places = splats.means.astype(np.float64)
        made.bound(prim, places.min(axis=0), places.max(axis=0), splats.log_scales)


def _add_moving(made: _Stage, name: str, segment: Segment[Floats], times: Doubles, codes: Doubles) -> int:
    """Add a segment's splats, sampled at its seconds, with their time codes; return how many any sample shows."""
    moments = [evaluate(segment.dynamic, segment.normalised(float(time))) for time in times]
    seen = np.zeros(len(segment.dynamic), np.bool_)
    for _, _, opacities in moments:
        seen |= opacities >= LEAST_OPACITY
    splats = segment.dynamic.take(seen)
    if not len(splats):
        return 0
    prim = made.add(name, splats)
    turning = bool(splats.rotation[:, 1].any())
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for number, (code, (places, quats, opacities)) in enumerate(zip(codes, moments, strict=True)):
        held = quats[seen] if turning or not number else None
        made.place(prim, code, places[seen], held, np.where(opacities >= LEAST_OPACITY, opacities, 0.0)[seen])
        low, high = np.minimum(low, places[seen].min(axis=0)), np.maximum(high, places[seen].max(axis=0))
    made.bound(prim, low, high, splats.log_scales)
    _show(prim, made, codes)
    return len(splats)


def _show(prim: Any, made: _Stage, codes: Doubles) -> None:
    """Hide a prim before its first sample and from the sample after its last one."""
    from pxr import UsdGeom

    first, last = made.stage.GetStartTimeCode(), made.stage.GetEndTimeCode()
    visibility = prim.CreateVisibilityAttr()
    if codes[0] > first:
        visibility.Set(UsdGeom.Tokens.invisible, first)
    visibility.Set(UsdGeom.Tokens.inherited, codes[0])
    if codes[-1] < last:
        visibility.Set(UsdGeom.Tokens.invisible, codes[-1] + 1)


def _always() -> Any:
    from pxr import Usd

    return Usd.TimeCode.Default()


def _changes(log_scales: Floats, rgb: Floats, antialiased: bool) -> list[Change]:
    thin = "USD has no word for it: programs draw thin splats too strong; try --bake"
    return [
        *([Change.whole(Action.LEFT_OUT, "antialiasing", thin)] if antialiased else []),
        Change.whole(Action.ASSUMED, "unit", "the file calls it a metre"),
        deviations_limited(log_scales),
        Change.where(Action.LIMITED, "colour", rgb < 0, NO_NEGATIVE_COLOUR),
    ]


USD = tuple(
    FileFormat(suffix, write_still=still_usd_file, write_whole=usd_file, sampled=True) for suffix in (".usd", ".usdc")
)
