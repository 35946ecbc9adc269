"""The settings and commands of docs/configuration.md, compared with the code."""

from __future__ import annotations

import argparse
import ast
import re

from server.cli.program import command_line
from tests.conftest import REPOSITORY

PAGE = (REPOSITORY / "docs" / "configuration.md").read_text()
PACKAGES = ("hgs_core", "jobs", "server")
COMPOSE = "docker-compose.yml"
VARIABLE = re.compile(r"HGS_[A-Z0-9_]*[A-Z0-9]")


def first_cells(heading: str) -> list[str]:
    """Return the first cells of the tables of one section."""
    section = re.split(r"^## ", PAGE, flags=re.MULTILINE)
    [text] = [part for part in section if part.startswith(f"{heading}\n")]
    return re.findall(r"^\| (`.+?) \|", text, re.MULTILINE)


def variables(*headings: str) -> list[str]:
    """Return the names of the variables in the tables of some sections."""
    return [name for heading in headings for cell in first_cells(heading) for name in VARIABLE.findall(cell)]


def command_names() -> list[str]:
    """Return the names of the commands of `hgs`, in the order of its help."""
    [commands] = [action for action in command_line()._actions if isinstance(action, argparse._SubParsersAction)]
    return list(commands.choices)


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
    headings = [name for name in re.findall(r"^## (.+)$", PAGE, re.MULTILINE) if name != COMPOSE]
    assert sorted(variables(*headings)) == sorted(names_in_code())


def test_variables_of_compose_are_those_that_the_code_does_not_read() -> None:
    used = set(re.findall(r"\$\{(HGS_[A-Z0-9_]+)", (REPOSITORY / COMPOSE).read_text()))
    assert sorted(variables(COMPOSE)) == sorted(used - names_in_code())


def test_commands_are_those_of_the_program() -> None:
    assert [cell.strip("`") for cell in first_cells("Commands")] == command_names()
