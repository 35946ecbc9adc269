"""How far the numbers of coded static splats are from the originals."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.codec import EncodeSettings, Utility
from hgs_core.codec.encoder.chunking import static_layers
from hgs_core.codec.encoder.decoded_preview import decoded_arrays
from hgs_core.codec.encoder.encode_chunk import static_numbers
from hgs_core.codec.encoder.prepare import prepare_static
from hgs_core.codec.encoder.rotation_coding import turn_between
from hgs_core.codec.encoder.steps import Steps
from hgs_core.codec.format.attributes import Kind
from hgs_core.interchange.spz.spz_file import read_spz
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import StaticSplats

__all__ = ["StaticErrors", "coded_errors", "spz_errors"]


@dataclass(frozen=True)
class StaticErrors:
    """Root mean squares over splats, components together."""

    position: float  # world units
    log_scale: float
    rotation: float  # radians, about each axis
    opacity: float
    rgb: float


def coded_errors(
    splats: StaticSplats[Floats],
    cameras: Sequence[Camera],
    utility: Utility,
    settings: EncodeSettings,
    *,
    antialiased: bool,
) -> StaticErrors:
    """Return the errors of the splats that encoding keeps."""
    prepared = prepare_static(splats, cameras, utility.static, settings, antialiased=antialiased)
    layers = [prepared.take(layer.index) for layer in static_layers(prepared, settings)]
    decoded = [decoded_arrays(Kind.STATIC, static_numbers(part, Steps.of(part, settings))) for part in layers]
    order = np.concatenate([layer.index for layer in static_layers(prepared, settings)])
    found = {name: np.concatenate([arrays[name] for arrays in decoded]).astype(np.float64) for name in decoded[0]}
    return _errors(vars(prepared.take(order)), found)


def spz_errors(splats: StaticSplats[Floats], data: bytes) -> StaticErrors:
    """Return the errors of an SPZ file of these splats."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.spz"
        path.write_bytes(data)
        read = read_spz(path)[0]
    quats = splats.quats.astype(np.float64)
    original = {
        "position": splats.means.astype(np.float64),
        "log_scale": splats.log_scales.astype(np.float64),
        "rgb": splats.rgb.astype(np.float64),
        "rotation": quats / np.linalg.norm(quats, axis=1, keepdims=True),
        "opacity": 1 / (1 + np.exp(-splats.opacity_logits[:, None].astype(np.float64))),
    }
    opacities = 1 / (1 + np.exp(-read.opacity_logits.astype(np.float64)))
    found = {"means": read.means, "log_scales": read.log_scales, "quats": read.quats, "rgb": read.rgb}
    return _errors(original, {name: a.astype(np.float64) for name, a in found.items()} | {"opacities": opacities})


def _errors(original: Mapping[str, Doubles], found: Mapping[str, Doubles]) -> StaticErrors:
    quats = found["quats"] / np.linalg.norm(found["quats"], axis=1, keepdims=True)
    return StaticErrors(
        _rms(found["means"] - original["position"]),
        _rms(found["log_scales"] - original["log_scale"]),
        _rms(turn_between(original["rotation"], quats)),
        _rms(found["opacities"] - original["opacity"][:, 0]),
        _rms(found["rgb"] - original["rgb"]),
    )


def _rms(differences: Doubles) -> float:
    return float(np.sqrt((differences**2).mean()))
