"""The work of scripts/install, with pip and npm that only note their arguments."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

NOTING = '#!/bin/sh\necho "{name} $*" >>"{log}"\n'


@pytest.fixture
def install(tmp_path: Path) -> Callable[..., list[str]]:
    """Return a function that runs the script in a small copy of the tree and returns the arguments of pip and npm."""
    tree, log, tools = tmp_path / "tree", tmp_path / "log", tmp_path / "tools"
    for folder in (
        "scripts",
        ".venv/bin",
        "hgs_core/native/src",
        "jobs",
        "server/viewer",
        "web_client/src",
        "web_client/tests",
    ):
        (tree / folder).mkdir(parents=True)
    shutil.copy(REPOSITORY / "scripts" / "install", tree / "scripts" / "install")
    for file in (
        "pyproject.toml",
        "CMakeLists.txt",
        "hgs_core/native/src/a.cpp",
        "web_client/src/a.ts",
        "web_client/.npmrc",
    ):
        (tree / file).write_text(file)
    tools.mkdir()
    for program in (tree / ".venv" / "bin" / "python", tools / "npm"):
        program.write_text(NOTING.format(name=program.name, log=log))
        program.chmod(0o755)
    (tools / "node").write_text("#!/bin/sh\necho 22\n")
    (tools / "node").chmod(0o755)

    def run(*arguments: str, fails: bool = False) -> list[str]:
        log.write_text("")
        environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "CXX": "c++"}
        done = subprocess.run(
            [tree / "scripts" / "install", *arguments], env=environment, capture_output=True, text=True, check=False
        )
        assert (done.returncode != 0) == fails, done.stderr
        assert done.stdout == ""
        return [line for line in log.read_text().splitlines() if "pip" in line or line.startswith("npm")]

    return run


def tree(tmp_path: Path) -> Path:
    return tmp_path / "tree"


def packages(asked: list[str]) -> list[str]:
    return [line.split()[-1] for line in asked if "-e" in line.split()]


def test_what_is_done_is_not_done_again(install: Callable[..., list[str]]) -> None:
    assert packages(install()) == ["."]
    assert install() == []


@pytest.mark.parametrize("order", [("--dev", ""), ("", "--dev", "", "--dev", "")])
def test_the_demo_and_the_tests_do_not_undo_each_other(
    install: Callable[..., list[str]], order: tuple[str, ...]
) -> None:
    installed = [packages(install(*filter(None, [option]))) for option in order]
    assert [one for one in installed if one] == ([["."], [".[dev]"]] if order[0] == "" else [[".[dev]"]])


def test_an_installation_for_tests_stays_one_when_the_code_changes(
    install: Callable[..., list[str]], tmp_path: Path
) -> None:
    install("--dev")
    (tree(tmp_path) / "pyproject.toml").write_text("changed")
    assert packages(install()) == [".[dev]"]
    assert install("--dev") == []


def test_a_new_module_is_installed(install: Callable[..., list[str]], tmp_path: Path) -> None:
    install()
    (tree(tmp_path) / "jobs" / "new.py").touch()
    assert packages(install()) == ["."]


@pytest.mark.parametrize(
    "written",
    [
        "dist/types/a.d.ts",
        "node_modules/a/a.js",
        "coverage/a.html",
        "src/a.tsbuildinfo",
        ".vite/a",
        "tests/a.test.ts",
        "npm.log",
    ],
)
def test_what_checks_write_does_not_build_the_viewer_again(
    install: Callable[..., list[str]], tmp_path: Path, written: str
) -> None:
    assert install() != []
    file = tree(tmp_path) / "web_client" / written
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch()
    assert install() == []


@pytest.mark.parametrize("changed", ["src/a.ts", "src/new.ts", ".npmrc", "package.json"])
def test_what_the_viewer_is_made_of_builds_it_again(
    install: Callable[..., list[str]], tmp_path: Path, changed: str
) -> None:
    install()
    (tree(tmp_path) / "web_client" / changed).write_text("changed")
    assert [line.split()[1] for line in install()] == ["ci", "run"]
    assert install() == []


def test_what_a_build_says_is_shown_only_where_it_fails(install: Callable[..., list[str]], tmp_path: Path) -> None:
    npm = tmp_path / "tools" / "npm"
    npm.write_text("#!/bin/sh\necho chatter\n")
    script, environment = (
        tree(tmp_path) / "scripts" / "install",
        {**os.environ, "PATH": f"{npm.parent}:{os.environ['PATH']}"},
    )
    assert b"chatter" not in subprocess.run([script], env=environment, capture_output=True, check=True).stderr
    (tree(tmp_path) / "web_client" / "src" / "a.ts").write_text("changed")
    npm.write_text("#!/bin/sh\necho chatter\nexit 3\n")
    failed = subprocess.run([script], env=environment, capture_output=True, check=False)
    assert failed.returncode == 1
    assert b"chatter" in failed.stderr
    assert b"the viewer failed with status 3" in failed.stderr
    assert b"the viewer failed" in subprocess.run([script], env=environment, capture_output=True, check=False).stderr


def test_a_long_build_says_that_it_goes_on(install: Callable[..., list[str]], tmp_path: Path) -> None:
    (tmp_path / "tools" / "npm").write_text('#!/bin/sh\n[ "$1" = ci ] && sleep 5\nexit 0\n')
    environment = {**os.environ, "PATH": f"{tmp_path / 'tools'}:{os.environ['PATH']}"}
    done = subprocess.run([tree(tmp_path) / "scripts" / "install"], env=environment, capture_output=True, check=True)
    assert b"the viewer: 4 s" in done.stderr
