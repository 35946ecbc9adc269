"""HGS as people install it, from a wheel, started in folders that hold modules of the same names as its own."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import time
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from tests.conftest import REPOSITORY

PIPELINE = REPOSITORY / "tests" / "server" / "modules" / "ready_pipeline.py"
OTHERS = ("numpy", "random", "torch", "json", "socket", "pickle", "argparse", "sqlalchemy", "jobs", "hgs_core")

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("scikit_build_core") is None, reason="needs scikit-build-core, which makes the wheel"
)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel, beside the libraries that the tests run with; its `bin`.

    The wheel has no compiled kernels, which nothing here needs.
    """
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    make = [*pip, "wheel", "--no-deps", "--no-build-isolation", "-C", "wheel.cmake=false", "-w", folder, REPOSITORY]
    subprocess.run(make, check=True)
    venv.create(folder / "venv", symlinks=True)
    python = folder / "venv" / "bin" / "python"
    (wheel,) = folder.glob("*.whl")
    subprocess.run([*pip, "--python", python, "install", "--no-deps", "--no-index", wheel], check=True)
    (site,) = (folder / "venv" / "lib").glob("*/site-packages")
    libraries = [path for path in sys.path if "site-packages" in path]
    (site / "libraries.pth").write_text("\n".join(libraries))
    shutil.copy(PIPELINE, site)
    return python.parent


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder of somebody's own project: every imported module of it leaves a mark."""
    folder = tmp_path / "project"
    folder.mkdir()
    mark = f"import os; os.open(os.path.join({str(tmp_path)!r}, 'mark-' + __name__), os.O_CREAT)\n"
    for name in OTHERS:
        (folder / f"{name}.py").write_text(mark)
    (folder / "server").mkdir()
    (folder / "server" / "__init__.py").write_text(mark)
    return folder


@contextmanager
def serving(command: list[str], project: Path, home: Path) -> Iterator[tuple[httpx.Client, Path]]:
    """Run a server with one worker in the project's folder; yield a client of it, and its log."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {"HGS_HOME": str(home), "HGS_PIPELINE": "ready_pipeline"}
    log = home.with_name("log")
    with log.open("wb") as file:
        process = subprocess.Popen(
            [*command, "serve", "--port", "0", "--workers", "1", "--captures", str(home.parent)],
            cwd=project,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=file,
            text=True,
        )
    try:
        assert process.stdout is not None
        page = process.stdout.readline().strip()
        assert page, log.read_text()
        with httpx.Client(base_url=page, timeout=60) as client:
            yield client, log
    finally:
        process.terminate()
        process.communicate(timeout=60)


def wait_for(log: Path, words: str) -> None:
    while not re.search(words, log.read_text()):
        assert "a worker ended" not in log.read_text(), log.read_text()
        time.sleep(0.1)


def test_server_worker_stages_and_checks_run_nothing_of_the_folder_they_are_started_in(
    installed: Path, project: Path, tmp_path: Path, scene_folder: Path
) -> None:
    capture = shutil.copytree(scene_folder, tmp_path / "capture")
    with serving([str(installed / "hgs")], project, tmp_path / "home") as (client, log):
        wait_for(log, "worker .* is ready")
        job = client.post("/v1/jobs", json={"capture": str(capture)}).raise_for_status().json()
        with client.stream("GET", f"/v1/jobs/{job['id']}/events") as events:
            assert list(events.iter_lines())
        assert client.get(f"/v1/jobs/{job['id']}").json()["state"] == "succeeded"
        check = client.post("/v1/captures/check", json={"capture": str(capture)}).raise_for_status().json()
        while check["state"] in ("waiting", "running"):
            check = client.get("/v1/captures/check", params={"capture": str(capture)}).json()
        assert "capture" in check["error"]  # the folder is none; `hgs check` has said so
    assert sorted(tmp_path.glob("mark*")) == []


def test_the_module_of_the_command_line_does_not_import_from_it_either(
    installed: Path, project: Path, tmp_path: Path
) -> None:
    """`python -m` takes the package `server` from the folder, which is not there; the rest comes from the wheel."""
    shutil.rmtree(project / "server")
    with serving([str(installed / "python"), "-m", "server.cli"], project, tmp_path / "home") as (client, log):
        wait_for(log, "worker .* is ready")
        assert client.get("/healthz").status_code == 200
    assert {path.name for path in tmp_path.glob("mark*")} == set()
