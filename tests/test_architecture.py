"""The rules of docs/architecture.md that a machine can check."""

from __future__ import annotations

import ast
from collections.abc import Container, Iterator
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

PACKAGES = ("hgs_core", "jobs", "server")
MODULES = sorted(path for package in PACKAGES for path in (REPOSITORY / package).rglob("*.py"))


def imports(path: Path) -> Iterator[str]:
    """Every module that a file imports, at its top or inside a function."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_arrows_run_from_server_to_jobs_to_hgs_core(path: Path) -> None:
    package = path.relative_to(REPOSITORY).parts[0]
    above = PACKAGES[PACKAGES.index(package) + 1 :]
    assert not [name for name in imports(path) if name.split(".")[0] in above]


@pytest.mark.parametrize("library", ["fastapi", "uvicorn", "websockets", "dbos", "sqlalchemy", "obstore"])
def test_the_science_knows_no_web_queue_or_database_library(library: str) -> None:
    users = [p for p in MODULES if "hgs_core" in p.parts and any(n.split(".")[0] == library for n in imports(p))]
    assert users == []


def test_no_module_circles_inside_a_process_start() -> None:
    """Top-level imports between our modules form no circle."""
    names = {".".join(p.relative_to(REPOSITORY).with_suffix("").parts).removesuffix(".__init__"): p for p in MODULES}
    edges = {name: {i for i in _top_level(path, names) if i in names and i != name} for name, path in names.items()}
    done: set[str] = set()

    def visit(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join((*trail[trail.index(name) :], name))
        if name not in done:
            for other in edges[name]:
                visit(other, (*trail, name))
            done.add(name)

    for name in names:
        visit(name, ())


def _top_level(path: Path, names: Container[str]) -> Iterator[str]:
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            submodules = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in names else node.module for name in submodules)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_every_module_says_what_it_offers(path: Path) -> None:
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "no docstring"
    assigned = [t.id for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign) for t in _targets(node)]
    assert "__all__" in assigned


def _targets(node: ast.Assign | ast.AnnAssign) -> list[ast.Name]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [target for target in targets if isinstance(target, ast.Name)]
