from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hgs_core.base.own_modules import guard_imports, module_command
from tests.conftest import REPOSITORY

SOURCES = sorted(path for package in ("hgs_core", "jobs", "server") for path in (REPOSITORY / package).rglob("*.py"))
ONE_PLACE = REPOSITORY / "hgs_core" / "base" / "own_modules.py"
SPAWN = "import multiprocessing as m; p = m.get_context('spawn').Process(target=print); p.start(); p.join()"


@pytest.fixture
def trap(tmp_path: Path) -> Path:
    """A folder in which every import leaves a mark."""
    for name in ("numpy", "random", "pickle", "socket", "selectors"):
        (tmp_path / f"{name}.py").write_text(f"import os; os.open({str(tmp_path / 'mark')!r}, os.O_CREAT)")
    return tmp_path


def run(trap: Path, *command: str, **environment: str) -> bool:
    """Run a command in the folder; return whether anything of it was imported."""
    subprocess.run(command, cwd=trap, env={**os.environ, **environment}, capture_output=True, check=False)
    return (trap / "mark").exists()


def test_the_working_directory_is_not_imported_from(trap: Path) -> None:
    assert not run(trap, *module_command("random"))
    assert run(trap, sys.executable, "-m", "random")


def test_children_of_libraries_do_not_import_from_it_either(trap: Path) -> None:
    environment = {"PYTHONPATH": f"{os.pathsep}{REPOSITORY}"}
    guard_imports(environment)
    assert environment == {"PYTHONSAFEPATH": "1", "PYTHONPATH": str(REPOSITORY)}
    assert not run(trap, sys.executable, "-c", SPAWN, **environment)
    assert run(trap, sys.executable, "-c", SPAWN)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_processes_of_ours_are_started_in_one_way(path: Path) -> None:
    """Nothing but `module_command` writes the options of a Python by which the working directory comes first."""
    text = path.read_text()
    words = {node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant)}
    assert path == ONE_PLACE or "sys.executable" not in text or not words & {"-m", "-c"}
