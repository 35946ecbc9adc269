"""The rules of docs/architecture.md that a machine can check."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

PACKAGES = ("hgs_core", "jobs", "server", "benchmarks")
MODULES = sorted(path for package in PACKAGES for path in (REPOSITORY / package).rglob("*.py"))
NAMES = {".".join(p.relative_to(REPOSITORY).with_suffix("").parts).removesuffix(".__init__"): p for p in MODULES}


def imports(path: Path) -> Iterator[str]:
    """Every module that a file imports, at its top or inside a function."""
    return _imported(ast.walk(ast.parse(path.read_text())))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_arrows_run_from_server_to_jobs_to_hgs_core(path: Path) -> None:
    package = path.relative_to(REPOSITORY).parts[0]
    above = PACKAGES[PACKAGES.index(package) + 1 :]
    assert not [name for name in imports(path) if name.split(".")[0] in above]


WINGS = ("codec", "jobs", "server")
"""The folders with rooms of their own inside."""

DOORS = ("server.app", "server.parts", "server.service")
"""Single modules that are rooms: those above and below them differ."""


def room(name: str) -> str:
    """The room of a module, as docs/architecture.md calls it; rooms of the science without `hgs_core/`."""
    if name in DOORS:
        return name.replace(".", "/")
    inside = name.split(".")[name.startswith("hgs_core") :]
    folder = inside if NAMES[name].stem == "__init__" else inside[:-1]
    return "/".join(folder[: 2 if folder and folder[0] in WINGS else 1])


def rooms_imported() -> dict[str, set[str]]:
    """Which rooms each room imports, at the top of its modules or inside functions."""
    found: dict[str, set[str]] = {}
    for name, path in NAMES.items():
        here = room(name)
        if here:  # not hgs_core/__init__.py: the library's front door opens onto all rooms
            found.setdefault(here, set()).update({room(other) for other in our_imports(path)} - {here, ""})
    return found


def rooms_documented() -> dict[str, set[str]]:
    """The table of docs/architecture.md: the permitted imports of each room."""
    rows = re.findall(r"^\| `([\w/]+)` \|.*\| ([^|]*) \|$", (REPOSITORY / "docs" / "architecture.md").read_text(), re.M)
    return {name.removeprefix("hgs_core/"): set(re.findall(r"`([^`]+)`", imported)) for name, imported in rows}


def test_rooms_import_what_their_row_says_and_nothing_else() -> None:
    assert rooms_imported() == rooms_documented()


def test_no_arrow_runs_back_up_between_rooms() -> None:
    above = list(rooms_documented())
    back = [(a, b) for a, imported in rooms_imported().items() for b in imported if above.index(b) >= above.index(a)]
    assert back == []


def started_with(name: str) -> dict[str, str]:
    """Every module that a process of `name` may import, with its importer.

    For the science imports at the top count: only openers of files call its functions. For jobs and server those of
    functions count, too.
    """
    found, waiting = {name: ""}, [name]
    while waiting:
        module = waiting.pop()
        imported = imports if not module.startswith("hgs_core") else _top_level
        for other in imported(NAMES[module]):
            if other not in found:
                found[other] = module
                if other in NAMES:
                    waiting.append(other)
    return found


OPENING = (
    "av",
    "PIL",
    "cv2",
    "torch",
    "hgs_core.capture",
    "hgs_core.check",
    "hgs_core.calibrate",
    "hgs_core.interchange",
)
"""The modules that open or parse the files of captures; a process of strangers' requests has none of them."""

HARMLESS = {
    "hgs_core.capture.capture_config": "numbers and names",
    "hgs_core.capture.held_out": "names of cameras",
}


@pytest.mark.parametrize("process", ["server.app", "jobs.worker"])
def test_what_opens_captures_is_in_no_process_that_must_live_on(process: str) -> None:
    def opens(name: str) -> bool:
        return any(name == one or name.startswith(f"{one}.") for one in OPENING) and name not in HARMLESS

    assert {name: by for name, by in started_with(process).items() if opens(name)} == {}


@pytest.mark.parametrize("library", ["fastapi", "uvicorn", "websockets", "dbos", "sqlalchemy", "obstore"])
def test_the_science_knows_no_web_queue_or_database_library(library: str) -> None:
    users = [p for p in MODULES if "hgs_core" in p.parts and any(n.split(".")[0] == library for n in imports(p))]
    assert users == []


def test_no_module_circles_inside_a_process_start() -> None:
    """Top-level imports between our modules form no circle."""
    edges = {name: {i for i in _top_level(path) if i in NAMES and i != name} for name, path in NAMES.items()}
    done: set[str] = set()

    def visit(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join((*trail[trail.index(name) :], name))
        if name not in done:
            for other in edges[name]:
                visit(other, (*trail, name))
            done.add(name)

    for name in NAMES:
        visit(name, ())


def our_imports(path: Path) -> set[str]:
    """Our modules that a file imports, at its top or inside a function."""
    return {name for name in imports(path) if name in NAMES}


def _top_level(path: Path) -> Iterator[str]:
    return _imported(ast.parse(path.read_text()).body)


def _imported(nodes: Iterable[ast.AST]) -> Iterator[str]:
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            submodules = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in NAMES else node.module for name in submodules)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_every_module_says_what_it_offers(path: Path) -> None:
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "no docstring"
    assigned = [t.id for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign) for t in _targets(node)]
    assert "__all__" in assigned


def _targets(node: ast.Assign | ast.AnnAssign) -> list[ast.Name]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [target for target in targets if isinstance(target, ast.Name)]


WITHOUT_TESTS_OF_THEIR_NAME: dict[str, str] = {
    "hgs_core.base.arrays": "names of array types",
    "hgs_core.base.progress": "a report, a signal and a callback that does nothing",
    "benchmarks.against.iteration_times": "run as a program by benchmarks.against.comparison",
    "hgs_core.bench.raster.operations": "constants",
    "hgs_core.interchange.file_format": "records",
    "hgs_core.render.constants": "constants",
    "server.http.media_types": "constants",
    "server.parts": "protocols",
    **dict.fromkeys(
        (
            "hgs_core.render.triton.draw",
            "hgs_core.render.triton.kernels.compositing",
            "hgs_core.render.triton.kernels.compositing_backward",
            "hgs_core.render.triton.kernels.compositing_forward",
            "hgs_core.render.triton.kernels.constants",
            "hgs_core.render.triton.kernels.contributions",
            "hgs_core.render.triton.kernels.projection",
            "hgs_core.render.triton.kernels.projection_backward",
            "hgs_core.render.triton.kernels.projection_forward",
            "hgs_core.render.triton.kernels.segments",
            "hgs_core.render.triton.kernels.tile_lists",
            "hgs_core.train.triton.kernels.rmsprop",
            "hgs_core.train.triton.kernels.loss",
        ),
        "launched by the tests of what calls it, against float64",
    ),
}
"""The modules that no file of tests is named for, and why: the only ones."""


def test_tests_mirror_the_packages() -> None:
    """tests/<package path>/test_<module>.py is there for every module but those of the table, and for none of them."""
    alone = set()
    for name, path in NAMES.items():
        mirror = REPOSITORY / "tests" / path.relative_to(REPOSITORY).with_name(f"test_{path.name}")
        if not path.name.startswith("__") and not mirror.exists():
            alone.add(name)
    assert sorted(alone - set(WITHOUT_TESTS_OF_THEIR_NAME)) == [], "without a file of tests of their name"
    assert sorted(set(WITHOUT_TESTS_OF_THEIR_NAME) - alone) == [], "mirrored or gone: take them from the table"


MIRRORS = ("native", "triton", "kernels", "cli", "routes")
"""The folders of modules named for an operation, a command or a resource of another room."""


def test_no_two_modules_share_a_name() -> None:
    """An editor's tab shows the name alone."""
    seen: dict[str, list[str]] = {}
    for path in MODULES:
        if not path.stem.startswith("__") and path.parent.name not in MIRRORS:
            seen.setdefault(path.stem, []).append(str(path.relative_to(REPOSITORY)))
    assert {name: paths for name, paths in seen.items() if len(paths) > 1} == {}
