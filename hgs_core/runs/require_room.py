"""The need of a run compared with this machine before any work; where it does not fit, a cure that was tried."""

from __future__ import annotations

import dataclasses
import errno
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.free_memory import free_memory
from hgs_core.base.system_errors import as_input_error
from hgs_core.capture.capture import Capture
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_costs import training_need
from hgs_core.runs.training_need import TrainingNeed, disk_words, memory_words
from hgs_core.runs.training_size import TrainingSize

__all__ = ["require_room", "require_room_for"]

_FACTORS = (2, 3, 4, 6, 8)  # reductions that are tried
_IN_MEMORY = 256  # MiB of pictures, tried where more are held
_ALL = "all"  # stages
_SPARE = 1 << 28  # bytes of a disk that stay free


def require_room(run: Path, limits: Mapping[str, float] | None = None) -> TrainingNeed | None:
    """Return the need of a run, and keep it in its folder; None before its cameras are known, and once it is trained.

    `limits` are bytes of memory by stage, for stages with a limit of their own.

    Raises:
        InputError: as `require_room_for`, or the capture cannot be opened.
    """
    folder = RunFolder(run)
    spec = folder.read_spec()
    if not spec.fingerprint or folder.train_summary.exists():
        return None
    return require_room_for(folder, spec.open_capture(), spec.config, limits or {})


def require_room_for(
    folder: RunFolder, capture: Capture, config: RunConfig, limits: Mapping[str, float] | None = None
) -> TrainingNeed:
    """Return the need of a run with this capture, and keep it in its folder.

    Raises:
        InputError: the machine has less memory or disk; names a field of the config that helps, if one does.
    """
    size = TrainingSize.of(capture, config)
    need = training_need(size, config)
    _require_memory(size, config, need, limits or {})
    _require_disk(size, config, need, folder)
    need.save(folder.need)
    return need


def _require_memory(size: TrainingSize, config: RunConfig, need: TrainingNeed, limits: Mapping[str, float]) -> None:
    own = {stage: limit for stage, limit in limits.items() if stage in need.memory}
    for stage, room in {_ALL: free_memory(), **own}.items():

        def needed(other: TrainingNeed, stage: str = stage) -> int:
            return other.memory.get(stage, other.most_memory)

        if room is None or needed(need) <= room:
            continue
        there = "are free" if stage == _ALL else f"are what HGS_STAGE_MEMORY gives to {stage}"
        problem = f"the training needs {memory_words(needed(need))} of memory, and {memory_words(room)} {there}"
        for field, option, tried in _with_less_memory(size, config):
            if needed(tried) <= room:
                raise InputError.of_field(field, problem, f"{option} needs {memory_words(needed(tried))}")
        setting = "HGS_MEMORY_MIB" if stage == _ALL else "HGS_STAGE_MEMORY"
        raise InputError("memory", problem, f"take a larger machine, or fewer cameras; {setting} sets another bound")


def _require_disk(size: TrainingSize, config: RunConfig, need: TrainingNeed, folder: RunFolder) -> None:
    place = next(path for path in (folder.path, *folder.path.absolute().parents) if path.exists())
    try:
        usage = shutil.disk_usage(place)
        there = sum(file.stat().st_size for file in folder.pictures.glob("*/*.rgb"))
    except OSError as error:
        raise as_input_error(error, place) from error
    room = max(0, usage.free - _SPARE + there)
    if need.disk <= room:
        return
    problem = f"the training needs {disk_words(need.disk)} of disk, and {disk_words(room)} are free in {place}"
    cures = ["another --out"]
    field = "config.capture.downscale"
    if (gib := max(0, room - need.files) >> 30) and need.pictures > gib << 30:
        field, value = "config.capture.picture_disk_gib", gib
        tried = training_need(size, config.changed({field.removeprefix("config."): value}))
        cures.insert(0, f"--set capture.picture_disk_gib={value} needs {disk_words(tried.disk)}")
    for option, tried in _reduced(size, config):
        if tried.disk <= room:
            cures.insert(0, f"{option} needs {disk_words(tried.disk)}")
            break
    passes = need.disk <= usage.total - _SPARE  # others fill the disk: a job waits for them
    full = OSError(errno.ENOSPC, problem, str(place)) if passes else None
    raise InputError.of_field(field, problem, ", or ".join(cures)) from full


def _with_less_memory(size: TrainingSize, config: RunConfig) -> Iterator[tuple[str, str, TrainingNeed]]:
    """Yield fields of the config, the options that set them and the need with them, the mildest first."""
    if config.capture.frame_memory_mib > _IN_MEMORY and config.capture.picture_disk_gib:
        yield "config.capture.frame_memory_mib", *_with(size, config, "capture.frame_memory_mib", _IN_MEMORY)
    for option, need in _reduced(size, config):
        yield "config.capture.downscale", option, need


def _reduced(size: TrainingSize, config: RunConfig) -> Iterator[tuple[str, TrainingNeed]]:
    for factor in _FACTORS:
        smaller = dataclasses.replace(size, pixels=size.pixels / factor**2)
        yield f"--downscale {config.capture.downscale * factor}", training_need(smaller, config)


def _with(size: TrainingSize, config: RunConfig, field: str, value: Any) -> tuple[str, TrainingNeed]:
    return f"--set {field}={value}", training_need(size, config.changed({field: value}))
