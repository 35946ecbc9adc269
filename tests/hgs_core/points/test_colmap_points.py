"""pycolmap is imported in one place, which leaves the handlers of signals alone."""

from __future__ import annotations

import ast
import signal
import subprocess
import sys

import pytest

from tests.conftest import REPOSITORY

IMPORTS = {
    "main thread": "import hgs_core.points.colmap_points",
    "another thread": "import importlib, threading\n"
    "t = threading.Thread(target=importlib.import_module, args=['hgs_core.points.colmap_points'])\n"
    "t.start()\nt.join()",
}


def ended(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", program], cwd=REPOSITORY, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("where", IMPORTS)
@pytest.mark.parametrize("number", ["SIGTERM", "SIGINT"])
def test_a_handler_that_was_set_before_still_runs(where: str, number: str) -> None:
    program = (
        f"import os, signal\nsignal.signal(signal.{number}, lambda *_: print('handled'))\n{IMPORTS[where]}\n"
        f"os.kill(os.getpid(), signal.{number})\nprint('goes on')"
    )
    done = ended(program)
    assert (done.returncode, done.stdout.split("\n")[:2]) == (0, ["handled", "goes on"]), done.stderr


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGABRT, signal.SIGSEGV])
def test_without_a_handler_the_system_ends_the_process_without_a_word(number: signal.Signals) -> None:
    done = ended(f"import os\n{IMPORTS['main thread']}\nos.kill(os.getpid(), {int(number)})")
    assert (done.returncode, done.stderr) == (-number, "")


def test_nothing_else_imports_pycolmap() -> None:
    importing = []
    for folder in ("hgs_core", "jobs", "server"):
        for file in (REPOSITORY / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text())):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                if any(name.partition(".")[0] == "pycolmap" for name in names):
                    importing.append(file.relative_to(REPOSITORY).as_posix())
    assert importing == ["hgs_core/points/colmap_points.py"]
