from __future__ import annotations

import pytest

from hgs_core.base.wording import counted


@pytest.mark.parametrize(
    ("count", "words"), [(0, "0 cameras"), (1, "1 camera"), (2, "2 cameras"), (12345, "12,345 cameras")]
)
def test_one_of_a_thing_is_in_the_singular(count: int, words: str) -> None:
    assert counted(count, "camera") == words


def test_a_plural_of_its_own() -> None:
    assert [counted(n, "entry", "entries") for n in (1, 2)] == ["1 entry", "2 entries"]
