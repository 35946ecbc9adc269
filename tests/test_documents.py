"""Links and pages of the documents that `mkdocs build --strict` does not see."""

from __future__ import annotations

import re

import pytest

from tests.conftest import REPOSITORY

DOCS = REPOSITORY / "docs"


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md"])
def test_links_of_the_top_pages_lead_to_files(name: str) -> None:
    targets = re.findall(r"\]\((?!https?://)([^)#]+)", (REPOSITORY / name).read_text())
    assert targets
    assert [target for target in targets if not (REPOSITORY / target).exists()] == []


def test_the_moving_picture_is_small_and_moves() -> None:
    from PIL import Image

    path = DOCS / "images" / "viewer.webp"
    assert path.stat().st_size <= 3_000_000
    with Image.open(path) as picture:
        assert getattr(picture, "n_frames", 1) > 1
