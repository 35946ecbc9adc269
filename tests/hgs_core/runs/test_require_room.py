"""A run that does not fit is refused before any work, with a cure that works."""

from __future__ import annotations

import dataclasses
import errno
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs import require_room as module
from hgs_core.runs.creation import create_run
from hgs_core.runs.require_room import require_room
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_costs import training_need
from hgs_core.runs.training_need import TrainingNeed, disk_words, memory_words
from tests.conftest import REPOSITORY
from tests.large_training import LARGE

STUDIO = REPOSITORY / "samples" / "studio"
GIB = 1 << 30
HALF = dataclasses.replace(LARGE, pixels=LARGE.pixels / 4)


def created(run: Path, **changes: object) -> Path:
    create_run(run, STUDIO, RunConfig.for_preset("preview", **{"capture.hold_out": ["cam00"], **changes}))
    return run


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return created(tmp_path_factory.mktemp("plain") / "run")


@pytest.fixture
def run(plain: Path, tmp_path: Path) -> Path:
    """A run of the sample that nothing was done with."""
    return shutil.copytree(plain, tmp_path / "run")


def needed(run: Path) -> TrainingNeed:
    need = require_room(run)
    assert need is not None
    return need


@pytest.fixture(autouse=True)
def room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_MEMORY_MIB", "65536")


@pytest.fixture
def large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module.TrainingSize, "of", lambda capture, config: LARGE)


def with_disk(monkeypatch: pytest.MonkeyPatch, free: float, total: float | None = None) -> None:
    usage = SimpleNamespace(free=int(free) + (1 << 28), total=int(free if total is None else total) + (1 << 28))
    monkeypatch.setattr(module.shutil, "disk_usage", lambda path: usage)


def test_the_need_of_a_run_that_fits_is_kept_in_its_folder(run: Path) -> None:
    need = needed(run)
    assert TrainingNeed.load(RunFolder(run).need) == need


def test_too_little_memory_names_a_reduction_that_fits(run: Path, monkeypatch: pytest.MonkeyPatch, large: None) -> None:
    whole, half = (training_need(one, RunConfig()).most_memory for one in (LARGE, HALF))
    monkeypatch.setenv("HGS_MEMORY_MIB", str(free := (half >> 20) + 1))
    with pytest.raises(InputError) as refused:
        require_room(run)
    there = f"the training needs {memory_words(whole)} of memory, and {memory_words(free << 20)} are free"
    assert refused.value.problem == there
    assert refused.value.field == "config.capture.downscale"
    assert refused.value.cure == f"--downscale 2 needs {memory_words(half)}"


def test_what_memory_s_cure_sets_does_fit(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    need = needed(run)
    monkeypatch.setenv("HGS_MEMORY_MIB", str((need.most_memory >> 20) - 100))
    with pytest.raises(InputError) as refused:
        require_room(tmp_path / "run")
    setting = re.search(r"--set (\S+)=(\d+) needs", refused.value.cure)
    assert setting is not None
    needed(created(tmp_path / "other", **{setting[1]: int(setting[2])}))


def test_where_nothing_helps_the_bound_is_named(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_MEMORY_MIB", "64")
    with pytest.raises(InputError, match=r"take a larger machine.*HGS_MEMORY_MIB"):
        require_room(run)
    assert not RunFolder(run).need.exists()


def test_a_stage_s_own_limit_counts(run: Path) -> None:
    assert require_room(run, {"initialise": 64 * GIB, "train": 64 * GIB, "publish": 1}) is not None
    with pytest.raises(InputError, match="HGS_STAGE_MEMORY gives to train"):
        require_room(run, {"initialise": 64 * GIB, "train": 64 << 20})


def test_too_little_disk_names_what_fits_there(run: Path, monkeypatch: pytest.MonkeyPatch, large: None) -> None:
    with_disk(monkeypatch, 8e9)
    with pytest.raises(InputError, match=r"needs 19 GB of disk, and 8\.0 GB are free in") as refused:
        require_room(run)
    half = training_need(HALF, RunConfig()).disk
    bound = training_need(LARGE, RunConfig.for_preset("standard", **{"capture.picture_disk_gib": 7})).disk
    assert refused.value.cure == (
        f"--downscale 2 needs {disk_words(half)}, or"
        f" --set capture.picture_disk_gib=7 needs {disk_words(bound)}, or another --out"
    )
    assert refused.value.field == "config.capture.picture_disk_gib"


def test_pictures_that_are_there_need_no_room_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = created(tmp_path / "run", **{"capture.frame_memory_mib": 64})
    need = needed(run)
    held = RunFolder(run).pictures / "0"
    held.mkdir(parents=True)
    with (held / "0.rgb").open("wb") as file:
        file.truncate(need.pictures)
    with_disk(monkeypatch, need.files)
    needed(run)
    shutil.rmtree(held)
    with pytest.raises(InputError):
        require_room(run)


def test_a_trained_run_needs_nothing(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    RunFolder(run).train_summary.write_text("{}")
    monkeypatch.setenv("HGS_MEMORY_MIB", "1")
    assert require_room(run) is None


@pytest.mark.parametrize(("share", "waits"), [(1.1, True), (0.9, False)])
def test_a_disk_that_others_have_filled_may_be_waited_for(
    run: Path, monkeypatch: pytest.MonkeyPatch, share: float, waits: bool
) -> None:
    disk = needed(run).disk
    with_disk(monkeypatch, disk / 2, disk * share)
    with pytest.raises(InputError) as refused:
        require_room(run)
    assert (getattr(refused.value.__cause__, "errno", None) == errno.ENOSPC) is waits
