"""The memory that may still be taken, from files as the kernel writes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.free_memory import free_memory

GIB = 1 << 30


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine with 8 GiB free, and no groups."""
    monkeypatch.delenv("HGS_MEMORY_MIB", raising=False)
    write(tmp_path, "proc/meminfo", f"MemTotal:       16777216 kB\nMemAvailable:   {8 << 20} kB\n")
    write(tmp_path, "proc/self/cgroup", "0::/")
    return tmp_path


def write(root: Path, name: str, text: object) -> None:
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    (root / name).write_text(f"{text}\n")


def test_without_groups_it_is_what_the_system_has(root: Path) -> None:
    assert free_memory(root) == 8 * GIB


def test_a_limit_of_a_group_counts_less_what_the_group_has_taken(root: Path) -> None:
    write(root, "proc/self/cgroup", "0::/app/worker")
    write(root, "sys/fs/cgroup/app/worker/memory.max", 3 * GIB)
    write(root, "sys/fs/cgroup/app/worker/memory.current", GIB)
    assert free_memory(root) == 2 * GIB


def test_a_group_gives_back_the_files_that_it_has_read(root: Path) -> None:
    write(root, "proc/self/cgroup", "0::/app")
    write(root, "sys/fs/cgroup/app/memory.max", 3 * GIB)
    write(root, "sys/fs/cgroup/app/memory.current", 3 * GIB)
    write(root, "sys/fs/cgroup/app/memory.stat", f"anon {2 * GIB}\ninactive_file {GIB}")
    assert free_memory(root) == GIB


def test_a_group_around_the_group_may_have_less(root: Path) -> None:
    write(root, "proc/self/cgroup", "0::/app/worker")
    write(root, "sys/fs/cgroup/app/worker/memory.max", "max")
    write(root, "sys/fs/cgroup/app/worker/memory.current", GIB)
    write(root, "sys/fs/cgroup/app/memory.max", 2 * GIB)
    write(root, "sys/fs/cgroup/app/memory.current", GIB)
    assert free_memory(root) == GIB


def test_groups_of_the_first_version_count_too(root: Path) -> None:
    write(root, "proc/self/cgroup", "5:cpu:/\n4:memory:/docker/1f9c\n0::/")
    write(root, "sys/fs/cgroup/memory/memory.limit_in_bytes", 5 * GIB)  # a container sees its own group at the top
    write(root, "sys/fs/cgroup/memory/memory.usage_in_bytes", GIB)
    assert free_memory(root) == 4 * GIB


def test_a_group_beyond_its_limit_has_nothing_left(root: Path) -> None:
    write(root, "proc/self/cgroup", "0::/app")
    write(root, "sys/fs/cgroup/app/memory.max", GIB)
    write(root, "sys/fs/cgroup/app/memory.current", 2 * GIB)
    assert free_memory(root) == 0


def test_a_system_that_does_not_tell_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HGS_MEMORY_MIB", raising=False)
    assert free_memory(tmp_path) is None


def test_a_setting_counts_instead(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_MEMORY_MIB", "16384")
    assert free_memory(root) == 16 * GIB


@pytest.mark.parametrize("text", ["0", "-1", "8G", "1.5"])
def test_a_setting_that_is_no_number_is_named(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_MEMORY_MIB", text)
    with pytest.raises(InputError, match=r"HGS_MEMORY_MIB: .* is not a positive integer"):
        free_memory()
