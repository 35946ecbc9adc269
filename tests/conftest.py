"""Fixtures that every package's tests share."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.jobs.modules.s3_server import S3Server

REPOSITORY = Path(__file__).resolve().parent.parent

# Several workers share the cores, where small operations of torch that each take all of them wait for each other: 30
# pictures of 64x48 took 8 s of processor, and 0.3 s with one thread. OpenMP's variable would bind numpy's BLAS, too.
os.environ.setdefault("MKL_NUM_THREADS", "1")

# A property holds however long the machine takes to try an example.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# A shell starts jobs in the background with SIGINT ignored, and processes that tests start and interrupt inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_make_parametrize_id(val: object, argname: str) -> str | None:
    """Name binary values by their parameter: bytes may tell the time, and workers must collect the same names."""
    return argname if isinstance(val, bytes) and not (val.isascii() and val.decode().isprintable()) else None


@pytest.fixture
def small_views(monkeypatch: pytest.MonkeyPatch) -> None:
    """Made-up views of an imported scene have a sixteenth of their pixels: for tests of other things than the loss."""
    monkeypatch.setattr("hgs_core.fit.orbit_cameras.SIZE", (160, 120))
    monkeypatch.setattr("hgs_core.fit.orbit_cameras.FOCAL", 140.0)


@pytest.fixture(scope="session")
def test_data() -> Callable[[str], Path]:
    """Return a function that finds a capture outside the repository, or skips the test with the reason."""
    root = Path(os.environ.get("HGS_TEST_DATA", REPOSITORY.parent / "shared" / "data"))

    def find(name: str) -> Path:
        path = root / name
        if not path.exists():
            pytest.skip(f"{name} is not under {root}: set HGS_TEST_DATA to the folder that has it")
        return path

    return find


@pytest.fixture(scope="module")
def s3_server() -> Iterator[S3Server]:
    """A server that speaks S3, with a bucket named "bucket"."""
    from tests.jobs.modules.s3_server import running_s3_server

    with running_s3_server() as server:
        yield server


@pytest.fixture
def s3_url(s3_server: S3Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return a prefix of its bucket that is the test's own; the environment has its address and credentials."""
    for name, value in s3_server.settings.items():
        monkeypatch.setenv(name, value)
    return f"s3://bucket/{tmp_path.name}"


@pytest.fixture(scope="module")  # Playwright's event loop blocks asyncio.run while it is open
def browser() -> Iterator[Browser]:
    """A real browser without a window; the test is skipped where there is none."""
    from benchmarks.viewers.browser import CHROMIUM_HINT, find_chromium, open_browser

    chromium = find_chromium()
    if chromium is None:
        pytest.skip(CHROMIUM_HINT)
    with open_browser(chromium) as opened:
        yield opened
