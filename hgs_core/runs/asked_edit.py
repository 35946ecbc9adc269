"""An edit that a job makes: asked for with a copy of a scene and a file of edits, made by the job's first stage.

This module is light, as `hgs_core.runs.stages` is: the API process asks for edits without loading torch.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hgs_core.base.atomic import write_bytes
from hgs_core.base.progress import ProgressCallback
from hgs_core.codec.format.scene_folder import CHUNKS
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec

if TYPE_CHECKING:
    from hgs_core.edit.splat_list import SplatList
    from hgs_core.edit.viewed_scene import Edit, ViewedScene

__all__ = ["ask_edit", "make_edit", "source_of_edit"]

_EDIT = "edit.json"
_MADE = ".edited"


def source_of_edit(run: Path, scene_id: str) -> Path:
    """Return where a run has the copy of the scene that it edits."""
    return run / "source" / scene_id


def ask_edit(run: Path, scene_id: str, document: bytes) -> RunConfig:
    """Write run.json for an edit of the copied scene by a file's `document`, which nobody has read yet."""
    # A trimmed scene is encoded anew: losses add up, so that each must be small.
    folder, config = RunFolder(run), RunConfig.from_json({"preset": "imported", "encode": {"budget": "high"}})
    write_bytes(run / _EDIT, document)
    folder.replace_spec(RunSpec(source_of_edit(run, scene_id), "", config, without_capture=True, edited=True))
    return config


def make_edit(run: Path, progress: ProgressCallback) -> None:
    """Make the edit and encode it; its last file is train.json. The copied chunks are removed then.

    Raises:
        InputError: the file is malformed, its list is of another scene, or nothing is left.
    """
    folder, made = RunFolder(run), RunFolder(run / _MADE)
    if folder.train_summary.exists():
        return
    spec, (splats, steps) = folder.read_spec(), _edit_of(run / _EDIT)
    from hgs_core.runs.edited import edit_run  # loads torch, in vain for a bad file

    source = source_of_edit(run, spec.capture.name)  # the run may have come from another machine
    for left in (made.path, folder.scene):
        shutil.rmtree(left, ignore_errors=True)
    edit_run(source, made.path, steps, progress, spec.config.encode.budget, splats)
    folder.replace_spec(made.read_spec())
    for name in (made.trained.name, made.views.name, made.scene.name, made.train_summary.name):
        (made.path / name).replace(run / name)
    shutil.rmtree(made.path, ignore_errors=True)
    shutil.rmtree(source / CHUNKS, ignore_errors=True)


def _edit_of(file: Path) -> tuple[SplatList | None, Sequence[Callable[[ViewedScene], Edit]]]:
    """Return the list of splats that go first, and the later steps, of a file in either format."""
    from hgs_core.edit.crop_file import CropFile
    from hgs_core.edit.edit_file import EditFormat, read_edit_file
    from hgs_core.edit.splat_list import SplatList

    fields = read_edit_file(file, list(EditFormat))
    if fields["format"] == EditFormat.SPLATS:
        return SplatList.of(file, fields), ()
    asked = CropFile.of(file, fields)
    return None, (asked.trimmed, asked.cropped)
