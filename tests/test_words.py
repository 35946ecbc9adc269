"""Plain words: docstrings that name their subject, and comments that say something by themselves."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

ROOTS = ("benchmarks", "hgs_core", "jobs", "server", "scripts", "tests")
FILES = sorted(path for root in ROOTS for path in (REPOSITORY / root).rglob("*.py"))

CLAUSE = re.compile(r"\b(what|whatever|who|whom|whose|whoever)\b", re.IGNORECASE)
DANGLING = re.compile(
    r"#\s*(of|that|which|per|by|from|with|without|for|in|on|at|to|as|since|until|after|before|than|beside|under|over"
    r"|where|when|while|whose|who|what)\b",
    re.IGNORECASE,
)


def docstrings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines and texts of docstrings, those below variables included."""
    for node in ast.walk(ast.parse(path.read_text())):
        body = getattr(node, "body", ())
        for one in body if isinstance(body, list) else ():
            if isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant) and isinstance(one.value.value, str):
                yield one.lineno, one.value.value


def trailing_comments(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines and texts of comments behind code."""
    for token in tokenize.generate_tokens(io.StringIO(path.read_text()).readline):
        if token.type == tokenize.COMMENT and token.line[: token.start[1]].strip():
            yield token.start[0], token.string


def place(path: Path, line: int, text: str) -> str:
    return f"{path.relative_to(REPOSITORY)}:{line}: {text}"


@pytest.mark.parametrize("root", ROOTS)
def test_first_paragraphs_of_docstrings_name_their_subject(root: str) -> None:
    """A noun of docs/glossary.md, or a verb with an object: no interrogative clause."""
    found = [
        place(path, line, first)
        for path in FILES
        if path.is_relative_to(REPOSITORY / root)
        for line, text in docstrings(path)
        if CLAUSE.search(first := text.strip().partition("\n\n")[0])
    ]
    assert found == []


def test_trailing_comments_are_units_or_noun_phrases() -> None:
    """A noun that a comment's preposition waits for belongs into the name."""
    found = [
        place(path, line, text) for path in FILES for line, text in trailing_comments(path) if DANGLING.match(text)
    ]
    assert found == []


def test_the_formatter_decides() -> None:
    skip = "fmt: " + "skip"
    found = [path for path in FILES for line in path.read_text().splitlines() if skip in line]
    assert found == []
