"""HGS as a library: from a multi-view capture to a compact 4D Gaussian scene, and back to pictures.

    import hgs_core as hgs

offers the names of `__all__`; each is loaded when it is first used, so that importing the package loads neither torch
nor any other heavy library. Nothing here imports a web framework, a queue or a database.

Training and scoring are called `train_scene` and `evaluate_run` because `hgs_core.train` and `hgs_core.evaluate` are
packages.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hgs_core.base.errors import InputError
    from hgs_core.capture.capture import Capture
    from hgs_core.capture.capture_config import CaptureConfig
    from hgs_core.capture.open import open_capture
    from hgs_core.check.capture_check import check_capture
    from hgs_core.check.findings import CaptureCheck
    from hgs_core.codec import EncodeSettings, Manifest, decode_scene, encode_scene, load_manifest
    from hgs_core.evaluate.run import evaluate_run
    from hgs_core.fit.fit_config import EncodeConfig
    from hgs_core.points.points_config import PointsConfig
    from hgs_core.render import Render
    from hgs_core.render.rasterize import rasterize
    from hgs_core.runs.run_config import RunConfig
    from hgs_core.runs.stages import train_scene
    from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats, load_scene, save_scene
    from hgs_core.scene.camera import Camera
    from hgs_core.train.train_config import TrainConfig

__all__ = [
    "Camera",
    "Capture",
    "CaptureCheck",
    "CaptureConfig",
    "DynamicSplats",
    "EncodeConfig",
    "EncodeSettings",
    "HybridScene",
    "InputError",
    "Manifest",
    "PointsConfig",
    "Render",
    "RunConfig",
    "Segment",
    "StaticSplats",
    "TrainConfig",
    "check_capture",
    "decode_scene",
    "encode_scene",
    "evaluate_run",
    "load_manifest",
    "load_scene",
    "open_capture",
    "rasterize",
    "save_scene",
    "train_scene",
]

_HOMES = {
    "Camera": "hgs_core.scene.camera",
    "Capture": "hgs_core.capture.capture",
    "CaptureCheck": "hgs_core.check.findings",
    "CaptureConfig": "hgs_core.capture.capture_config",
    "DynamicSplats": "hgs_core.scene",
    "EncodeConfig": "hgs_core.fit.fit_config",
    "EncodeSettings": "hgs_core.codec",
    "HybridScene": "hgs_core.scene",
    "InputError": "hgs_core.base.errors",
    "Manifest": "hgs_core.codec",
    "PointsConfig": "hgs_core.points.points_config",
    "Render": "hgs_core.render",
    "RunConfig": "hgs_core.runs.run_config",
    "Segment": "hgs_core.scene",
    "StaticSplats": "hgs_core.scene",
    "TrainConfig": "hgs_core.train.train_config",
    "check_capture": "hgs_core.check.capture_check",
    "decode_scene": "hgs_core.codec",
    "encode_scene": "hgs_core.codec",
    "evaluate_run": "hgs_core.evaluate.run",
    "load_manifest": "hgs_core.codec",
    "load_scene": "hgs_core.scene",
    "open_capture": "hgs_core.capture.open",
    "rasterize": "hgs_core.render.rasterize",
    "save_scene": "hgs_core.scene",
    "train_scene": "hgs_core.runs.stages",
}


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, loaded or not."""
    return sorted({*globals(), *__all__})
