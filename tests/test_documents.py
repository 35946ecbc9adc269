"""Links and pages of the documents that `mkdocs build --strict` does not see."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

DOCS = REPOSITORY / "docs"
EXPERIMENTS = sorted((DOCS / "experiments").glob("20*.md"))


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md"])
def test_links_of_the_top_pages_lead_to_files(name: str) -> None:
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", (REPOSITORY / name).read_text())
    assert targets
    assert [target for target in targets if not (REPOSITORY / target).exists()] == []


@pytest.mark.parametrize("path", EXPERIMENTS, ids=lambda path: path.stem)
def test_an_experiment_asks_a_question_is_listed_and_runs_what_exists(path: Path) -> None:
    text = path.read_text()
    title = text.splitlines()[0]
    assert title.startswith("# ")
    assert title.endswith("?")
    assert f"]({path.name})" in (DOCS / "experiments" / "index.md").read_text()
    modules = re.findall(r"python -m (scripts[\w.]+)", text)
    assert [name for name in modules if not (REPOSITORY / f"{name.replace('.', '/')}.py").is_file()] == []


def test_the_moving_picture_is_small_and_moves() -> None:
    from PIL import Image

    path = DOCS / "images" / "viewer.webp"
    assert path.stat().st_size <= 3_000_000
    with Image.open(path) as picture:
        assert getattr(picture, "n_frames", 1) > 1
