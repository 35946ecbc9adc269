from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.store_lock import StoreLock


class Waited(Exception):  # noqa: N818
    pass


def refuse() -> None:
    raise Waited


def test_publishers_do_not_wait_for_each_other(tmp_path: Path) -> None:
    lock = StoreLock(tmp_path / "store" / "lock")
    with lock.publishing(refuse), lock.publishing(refuse):
        pass


def test_a_publisher_waits_for_a_collector(tmp_path: Path) -> None:
    lock = StoreLock(tmp_path / "lock")
    with lock.collecting(0), pytest.raises(Waited), lock.publishing(refuse):
        pass
    with lock.publishing(refuse):
        pass


@pytest.mark.parametrize("other", ["publishing", "collecting"])
def test_a_collector_waits_for_everybody_but_not_for_ever(tmp_path: Path, other: str) -> None:
    lock = StoreLock(tmp_path / "lock")
    held = lock.publishing(refuse) if other == "publishing" else lock.collecting(0)
    with held, pytest.raises(InputError, match="try again later"), lock.collecting(0.0):
        pass
