"""One process at a time holds a run, also where the kernel's locks do not reach from one to the other."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs import lease
from hgs_core.runs.run_folder import RunFolder

HOLD = """
import fcntl, sys
from pathlib import Path
from hgs_core.runs.run_folder import RunFolder
if "without locks" in sys.argv:
    fcntl.flock = lambda *arguments: None
with RunFolder(Path(sys.argv[1])).exclusive():
    print("holds", flush=True)
    sys.stdin.read()
"""

Holder = subprocess.Popen[bytes]


@pytest.fixture
def hold() -> Iterator[Callable[..., Holder]]:
    """Return a function that starts a process that holds a run."""
    processes: list[Holder] = []

    def hold(run: Path, *options: str) -> Holder:
        command = [sys.executable, "-c", HOLD, str(run), *options]
        processes.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE))
        out = processes[-1].stdout
        assert out is not None
        assert out.readline() == b"holds\n"
        return processes[-1]

    yield hold
    for process in processes:
        process.kill()
        process.communicate()


@pytest.fixture
def no_locks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand for two machines between which locks do not reach."""
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)


@pytest.fixture
def mounts(tmp_path: Path) -> Iterator[tuple[Path, Path]]:
    """One folder, mounted twice by bindfs without shared locks."""
    if shutil.which("bindfs") is None or os.geteuid() != 0 or not Path("/dev/fuse").exists():
        pytest.skip("mounting a folder twice without shared locks takes root, /dev/fuse and bindfs")
    (tmp_path / "run").mkdir()
    both = (tmp_path / "first", tmp_path / "second")
    for mount in both:
        mount.mkdir()
        subprocess.run(["bindfs", tmp_path / "run", mount], check=True)
    yield both
    for mount in both:
        subprocess.run(["umount", "--lazy", mount], check=True)


def other_machine(run: Path, epoch: int, silent_for: float) -> Path:
    path = run / f"run.lease.{epoch}"
    path.write_text("elsewhere 1 1")
    date = time.time() - silent_for
    os.utime(path, (date, date))
    return path


def test_a_second_process_is_refused_where_locks_do_not_reach(
    tmp_path: Path, hold: Callable[..., Holder], no_locks: None
) -> None:
    holder = hold(tmp_path, "without locks")
    with pytest.raises(InputError, match=f"process {holder.pid} works on it"), RunFolder(tmp_path).exclusive():
        pass


def test_a_second_process_is_refused_through_a_second_mount(
    mounts: tuple[Path, Path], hold: Callable[..., Holder]
) -> None:
    holder = hold(mounts[0])
    with (mounts[1] / "run.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # the lock is free there
    with pytest.raises(InputError, match=f"process {holder.pid} works on it"), RunFolder(mounts[1]).exclusive():
        pass
    holder.kill()
    holder.wait()
    with RunFolder(mounts[1]).exclusive():
        pass


def test_a_stopped_process_still_holds_it(tmp_path: Path, hold: Callable[..., Holder], no_locks: None) -> None:
    hold(tmp_path, "without locks")
    (path,) = tmp_path.glob("run.lease.*")
    os.utime(path, (1, 1))
    with pytest.raises(InputError, match="works on it"), RunFolder(tmp_path).exclusive():
        pass


def test_a_killed_process_holds_nothing_even_before_its_status_is_read(
    tmp_path: Path, hold: Callable[..., Holder]
) -> None:
    holder = hold(tmp_path)
    holder.kill()
    with RunFolder(tmp_path).exclusive(patience=60.0):
        assert [path.name for path in tmp_path.glob("run.lease.*")] == ["run.lease.2"]


def test_nothing_stays_behind(tmp_path: Path) -> None:
    with RunFolder(tmp_path).exclusive():
        assert (tmp_path / "run.lease.1").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["run.lock"]


def test_another_machine_that_speaks_is_believed(tmp_path: Path) -> None:
    other_machine(tmp_path, 4, silent_for=10.0)
    with pytest.raises(InputError, match="a process of another machine works on it"), RunFolder(tmp_path).exclusive():
        pass


def test_one_that_was_silent_for_long_is_followed(tmp_path: Path) -> None:
    path = other_machine(tmp_path, 4, silent_for=30.0)
    with RunFolder(tmp_path).exclusive():
        assert (tmp_path / "run.lease.5").exists()
        assert not path.exists()


def test_the_date_is_renewed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lease, "BEAT", 0.01)
    with RunFolder(tmp_path).exclusive():
        path = tmp_path / "run.lease.1"
        os.utime(path, (1, 1))
        while path.stat().st_mtime == 1:
            time.sleep(0.01)


def test_who_lost_the_run_hears_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lease, "BEAT", 0.01)
    lost = threading.Event()
    with RunFolder(tmp_path).exclusive(on_lost=lost.set):
        (tmp_path / "run.lease.1").unlink()
        assert lost.wait(60)


def test_a_folder_that_is_moved_is_still_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lease, "BEAT", 0.01)
    (tmp_path / "run").mkdir()
    lost = threading.Event()
    with RunFolder(tmp_path / "run").exclusive(on_lost=lost.set):
        (tmp_path / "run").rename(tmp_path / "moved")
        path = tmp_path / "moved" / "run.lease.1"
        os.utime(path, (1, 1))
        while path.stat().st_mtime == 1:
            time.sleep(0.01)
    assert not lost.is_set()
