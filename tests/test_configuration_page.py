"""The settings and commands of docs/configuration.md, compared with the code."""

from __future__ import annotations

import argparse
import ast
import re

from server.cli.program import command_line
from tests.conftest import REPOSITORY

PAGE = (REPOSITORY / "docs" / "configuration.md").read_text()
PACKAGES = ("hgs_core", "jobs", "server")
VARIABLE = re.compile(r"HGS_[A-Z0-9_]*[A-Z0-9]")


def first_cells(heading: str) -> list[str]:
    """Return the first cells of the tables of one section."""
    section = re.split(r"^## ", PAGE, flags=re.MULTILINE)
    [text] = [part for part in section if part.startswith(f"{heading}\n")]
    return re.findall(r"^\| (`.+?) \|", text, re.MULTILINE)


def names_on_page(*, compose: bool) -> list[str]:
    own = "docker-compose.yml"
    headings = [own] if compose else [name for name in re.findall(r"^## (.+)$", PAGE, re.MULTILINE) if name != own]
    return [name for heading in headings for cell in first_cells(heading) for name in VARIABLE.findall(cell)]


def names_in_code() -> set[str]:
    """Return the string literals of the packages that are names of variables and nothing else."""
    return {
        node.value
        for package in PACKAGES
        for path in (REPOSITORY / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and VARIABLE.fullmatch(node.value)
    }


def test_each_variable_of_the_code_is_on_the_page_once_and_the_reverse() -> None:
    assert sorted(names_on_page(compose=False)) == sorted(names_in_code())


def test_variables_of_compose_are_those_that_the_code_does_not_read() -> None:
    used = set(re.findall(r"\$\{(HGS_[A-Z0-9_]+)", (REPOSITORY / "docker-compose.yml").read_text()))
    assert sorted(names_on_page(compose=True)) == sorted(used - names_in_code())


def test_commands_are_those_of_the_program() -> None:
    [commands] = [action for action in command_line()._actions if isinstance(action, argparse._SubParsersAction)]
    assert [cell.strip("`") for cell in first_cells("Commands")] == list(commands.choices)
