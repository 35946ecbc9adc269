"""An edited scene as a run: `hgs edit` makes it of another run, which stays as it is."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import secrets
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.codec import Manifest, decode_scene, kept_chunks, load_manifest
from hgs_core.codec.format.scene_folder import MANIFEST, read_audio
from hgs_core.edit.deletion import deletion_of
from hgs_core.edit.splat_list import SplatList, drop_listed
from hgs_core.edit.viewed_scene import Edit, ViewedScene
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.runs.encoding import encode, encode_kept
from hgs_core.runs.kept_views import KeptViews
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.sound import write_sound
from hgs_core.runs.source import encoded_scene, open_source
from hgs_core.scene.files import save_scene

__all__ = ["EditableScene", "EditedRun", "edit_run", "open_editable"]


@dataclass(frozen=True)
class EditableScene:
    """An editable scene, with the properties of its own."""

    viewed: ViewedScene
    title: str
    config: RunConfig
    held_out: frozenset[str]  # names of cameras


@dataclass(frozen=True)
class EditedRun:
    """The result of an edit."""

    splats: int  # splats of the source
    kept: int  # splats of the encoded scene
    changes: tuple[Change, ...]  # losses of editing and encoding

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return {"splats": self.splats, "kept": self.kept, "changes": [change.to_json() for change in self.changes]}


def open_editable(path: Path) -> EditableScene:
    """Open a run, of which the float32 scene is taken, or the folder of an encoded scene, which is decoded.

    Raises:
        InputError: it is neither, or damaged.
    """
    scene = open_source(path).scene
    if (path / MANIFEST).is_file():
        manifest, config = load_manifest(path), RunConfig.from_json({"preset": "imported"})
        return EditableScene(_as_encoded(manifest, scene), manifest.title, config, frozenset())
    folder = RunFolder(path)
    spec, manifest = folder.read_spec(), load_manifest(folder.manifest)
    if spec.edited:
        kept = KeptViews.load(folder.views)
        viewed = ViewedScene(scene, kept.cameras, kept.times, kept.up)
        return EditableScene(viewed, kept.title, spec.config, kept.held_out)
    held_out = frozenset(spec.config.capture.hold_out)
    return EditableScene(_as_encoded(manifest, scene), manifest.title, spec.config, held_out)


def _as_encoded(manifest: Manifest, scene: Any) -> ViewedScene:
    """Return a scene with its manifest's cameras, unless those were made up, and its clock."""
    frames = int(np.floor((manifest.end - manifest.start) * manifest.frame_rate + 1e-3)) + 1
    times = manifest.start + np.arange(frames) / manifest.frame_rate
    made_up = not manifest.photographed and "imported" in manifest.training
    return ViewedScene(scene, () if made_up else manifest.cameras, times, None if made_up else manifest.up)


def edit_run(
    source: Path,
    out: Path,
    steps: Sequence[Callable[[ViewedScene], Edit]],
    progress: ProgressCallback,
    budget: str,
    splats: SplatList | None = None,
) -> EditedRun:
    """Make a new run of another, or of an encoded scene, with the scene changed by all `steps` in order.

    The run appears whole or not at all; `source` is only read. `budget` is what encoding may lose. `splats` go first;
    then the encoded scene is edited, also of a run, because lists name its splats. Where an encoded scene only loses
    splats, nothing is encoded anew: the others decode to the same bits.

    Raises:
        InputError: the source cannot be edited, a step refuses it, nothing is left, or `out` is there already.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(out, "exists", "choose a new or empty folder for --out")
    given = open_editable(source)
    viewed, changes = given.viewed, list[Change]()
    encoded = encoded_scene(source) if splats is not None or (source / MANIFEST).is_file() else None
    if splats is not None and encoded is not None:
        viewed = dataclasses.replace(viewed, scene=decode_scene(encoded))
        steps = [partial(_without, splats, load_manifest(encoded)), *steps]
    first, before = viewed, len(viewed.scene.static) + viewed.scene.dynamic_splats
    for step in steps:
        edit = step(viewed)
        viewed, changes = edit.viewed, [*changes, *edit.changes]
    left = len(viewed.scene.static) + viewed.scene.dynamic_splats
    if left == 0:
        raise InputError(source, f"none of {before:,} splats is left", "keep more of it")
    out.absolute().parent.mkdir(parents=True, exist_ok=True)
    temporary = out.absolute().parent / f".{out.name}.{secrets.token_hex(6)}.tmp"
    try:
        _write(RunFolder(temporary), source, given, viewed, changes, budget)
        deletion = None if encoded is None else deletion_of(first, viewed)
        if encoded is None or deletion is None:
            encode(temporary, progress)
        else:
            encode_kept(temporary, kept_chunks(encoded, deletion.static, deletion.moving), progress)
        _carry_sound(source, temporary / "scene", viewed.begins)
        totals = load_manifest(temporary / "scene").totals
        kept = totals.splats_static + totals.splats_dynamic
        if kept == 0:
            raise InputError(source, f"none of {left:,} splats that are left shows in any picture", "keep more")
        temporary.replace(out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    missed = Change(Action.LEFT_OUT, "splats", left - kept, left, "no picture misses them")
    return EditedRun(before, kept, nonzero((*changes, missed)))


def _without(splats: SplatList, manifest: Manifest, viewed: ViewedScene) -> Edit:
    """Leave out listed splats of the decoded scene of a manifest."""
    segments: list[list[tuple[str, int]]] = [[] for _ in manifest.segments]
    for piece in manifest.slices:
        segments[piece.segment] += [(chunk.id, chunk.splats) for chunk in piece.chunks]
    return drop_listed(viewed, splats, [(chunk.id, chunk.splats) for chunk in manifest.static], segments)


def _carry_sound(source: Path, scene: Path, begins: float) -> None:
    """Keep the sound of the scene that was edited, which is `begins` seconds later on its clock."""
    before = source if (source / MANIFEST).is_file() else RunFolder(source).scene
    sound, manifest = read_audio(before, load_manifest(before)), load_manifest(scene)
    if sound is not None:
        write_sound(scene, sound.moved(-begins, manifest.start, manifest.end))


def _write(
    folder: RunFolder, source: Path, given: EditableScene, viewed: ViewedScene, changes: Sequence[Change], budget: str
) -> None:
    config = given.config.changed({"train.antialiased": viewed.scene.antialiased, "encode.budget": budget})
    origin = source / MANIFEST
    if not origin.is_file():
        origin = RunFolder(source).trained
    fingerprint = hashlib.sha256(origin.read_bytes()).hexdigest()
    folder.write_spec(RunSpec(source.resolve(), fingerprint, config, without_capture=True, edited=True))
    save_scene(folder.trained, viewed.scene)
    KeptViews(given.title, viewed.cameras, given.held_out, viewed.times, viewed.up).save(folder.views)
    told = {"of": source.resolve().name, "changes": [change.to_json() for change in changes]}
    write_bytes(folder.train_summary, json.dumps({"seconds": 0.0, "edited": told}, indent=1).encode())
