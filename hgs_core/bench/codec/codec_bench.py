"""Bytes, errors and rates of the scene codec, beside other formats of the same splats."""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.bench.codec.codec_errors import StaticErrors, coded_errors, spz_errors
from hgs_core.bench.codec.codec_prefix import prefix_losses
from hgs_core.codec import EncodeSettings, decode_chunk, decode_scene, encode_scene
from hgs_core.codec.format.attributes import Kind
from hgs_core.codec.format.scene_folder import CHUNKS
from hgs_core.fit.coarseness import Fitted, fit
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.fit.encoding_views import EncodeViews, views_around
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.interchange.import_scene import import_scene
from hgs_core.interchange.splatv_file import splatv_file
from hgs_core.interchange.spz.spz_file import SPZ
from hgs_core.native.machine import machine_facts
from hgs_core.runs.encode_inputs import trained_scene, training_states, views_of_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState

__all__ = ["SWEEP", "CodecPoint", "CodecReport", "bench_codec"]

SWEEP = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
DECODING_REPEATS = 5  # the fastest counts: other work disturbs it least


@dataclass(frozen=True)
class CodecPoint:
    """An encoding."""

    name: str  # the budget, or "" in the sweep
    coarseness: float  # coarseness of static splats
    dynamic_share: float  # coarseness of dynamic splats over that
    bytes_static: int  # bytes of chunks, without the manifest
    bytes_dynamic: int
    splats_static: int  # encoded
    splats_dynamic: int
    loss: float  # dB, of training views, or of made-up ones
    loss_moving: float | None  # dB, of what moves in them; None: nothing tells what does
    loss_held_out: float | None  # dB, of cameras that nothing was chosen on
    encode_seconds: float  # search and fine-tuning included, for a budget


@dataclass(frozen=True)
class CodecReport:
    """The results of `bench_codec`."""

    machine: Mapping[str, Any]
    source: str
    splats_static: int  # trained splats
    splats_dynamic: int
    budgets: tuple[CodecPoint, ...]
    sweep: tuple[CodecPoint, ...]
    prefix_loss: float  # dB, of the first quarter of the bytes of the first encoding
    prefix_loss_shuffled: float  # dB, of a quarter of its chunks' bytes in random order
    decode_rates: Mapping[str, float]  # splats per second of processor time by kind, chunk by chunk
    bytes_splatv: int
    bytes_spz: Mapping[str, int]  # version -> bytes of a still scene
    errors: Mapping[str, StaticErrors]  # format -> errors of a still scene

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return dataclasses.asdict(self)


def bench_codec(
    source: Path, progress: ProgressCallback, *, budgets: Sequence[str], sweep: Sequence[float] = SWEEP
) -> CodecReport:
    """Encode a finished run, or a file of splats, with some budgets and over a sweep of coarsenesses; nothing is kept.

    Raises:
        InputError: the source is neither, or damaged; of a run also if its capture is gone.
    """
    scene, views, config, states, held_out = _opened(source)
    steps, done = 2 + len(budgets) + len(sweep), 0

    def tell() -> None:
        nonlocal done
        done += 1
        progress(Progress("codec", done, steps))

    utility = measure_utility(
        scene,
        list(views.trained.values()),
        views.times,
        any_background=views.any_background,
    )
    tell()
    seen = Loss(scene, views, views.trained)
    unseen = Loss(scene, views, held_out) if held_out else None
    points: list[CodecPoint] = []
    iterations = config.encode.fine_tune_iterations(config.train.iterations)
    chosen = []
    for name in budgets:
        began = time.process_time()
        found = fit(scene, views, utility, name, config.train, seed=config.seed, iterations=iterations, states=states)
        chosen.append((name, found, time.process_time() - began))
    plain = [
        ("", Fitted(scene, utility, EncodeSettings(coarseness=coarseness), Decibels(0.0, None)), 0.0)
        for coarseness in sweep
    ]
    rates: dict[str, float] = {}
    prefix = (0.0, 0.0)
    for name, found, fitting in [*chosen, *plain]:
        with tempfile.TemporaryDirectory() as out:
            began = time.process_time()
            manifest = encode_scene(
                found.scene,
                Path(out),
                cameras=views.cameras,
                closer=views.closer,
                times=views.times,
                title=views.title,
                settings=found.settings,
                utility=found.utility,
            )
            seconds = fitting + time.process_time() - began
            decoded = decode_scene(Path(out))
            if not rates:
                rates, prefix = _decode_rates(Path(out)), prefix_losses(Path(out), seen)
        totals = manifest.totals
        lost = seen.of(decoded)
        points.append(
            CodecPoint(
                name,
                found.settings.coarseness,
                found.settings.dynamic_share,
                totals.bytes_static,
                totals.bytes_dynamic,
                totals.splats_static,
                totals.splats_dynamic,
                lost.whole,
                lost.moving,
                None if unseen is None else unseen.of(decoded).whole,
                seconds,
            )
        )
        tell()
    moving = [segment.dynamic for segment in scene.segments]
    still = not any(map(len, moving))
    splatv = sum(
        len(splatv_file(scene.static.take(slice(0, None if i == 0 else 0)), part, views.cameras).data)
        for i, part in enumerate(moving)
    )
    errors: dict[str, StaticErrors] = {}
    spz: dict[str, int] = {}
    if still:
        versions = {f"spz {version}": write(scene.static, False).data for version, write in SPZ.versions.items()}
        spz = {name: len(data) for name, data in versions.items()}
        errors = {name: spz_errors(scene.static, data) for name, data in versions.items()}
        for name, found, _ in chosen:
            errors[name] = coded_errors(
                found.scene.static, views.every_camera, found.utility, found.settings, antialiased=scene.antialiased
            )
    tell()
    return CodecReport(
        machine_facts(),
        source.name,
        len(scene.static),
        sum(map(len, moving)),
        tuple(points[: len(chosen)]),
        tuple(points[len(chosen) :]),
        *prefix,
        rates,
        splatv,
        spz,
        errors,
    )


def _opened(
    source: Path,
) -> tuple[HybridScene[Floats], EncodeViews, RunConfig, Sequence[TrainState], dict[int, Any]]:
    """Return the scene, its views, its config, the states its training ended in, and the cameras held out, by index."""
    if source.is_file():
        imported = import_scene(source, 50 / 30)
        config = RunConfig().changed({"train.antialiased": imported.scene.antialiased})
        views = views_around(imported.scene, source.stem)
        return imported.scene, views, config, (), {}
    folder = RunFolder(source)
    spec = folder.read_spec()
    if not folder.trained.is_file():
        raise InputError(source, "is not trained yet", "finish it with hgs train")
    scene = trained_scene(folder)
    views = views_of_run(folder, spec, scene)
    hidden = {i: camera for i, camera in enumerate(views.cameras) if i not in views.trained}
    return scene, views, spec.config, training_states(folder, scene), hidden


def _decode_rates(folder: Path) -> dict[str, float]:
    """Return how many splats of each kind a core decodes in a second, from the chunks' bytes in memory."""
    files = [path.read_bytes() for path in sorted((folder / CHUNKS).iterdir())]
    chunks = [(decode_chunk(data), data) for data in files]
    rates = {}
    for kind in Kind:
        of_kind = [data for chunk, data in chunks if chunk.kind == kind]
        if of_kind:
            fastest = min(_decoding_seconds(of_kind) for _ in range(DECODING_REPEATS))
            rates[kind.name.lower()] = sum(chunk.count for chunk, _ in chunks if chunk.kind == kind) / fastest
    return rates


def _decoding_seconds(chunks: Sequence[bytes]) -> float:
    began = time.process_time()
    for data in chunks:
        decode_chunk(data)
    return max(time.process_time() - began, 1e-9)
