from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.old_names import with_new_names


def test_old_names_are_replaced_in_place() -> None:
    assert list(with_new_names({"a": 1, "cycles": 2, "cycle": 3, "b": 4}).items()) == [
        ("a", 1),
        ("iterations", 2),
        ("iteration", 3),
        ("b", 4),
    ]


def test_both_names_at_once_are_refused() -> None:
    with pytest.raises(InputError, match=r"^file\.cycle: is the old name of iteration, .*; give iteration alone$"):
        with_new_names({"cycle": 1, "iteration": 1}, "file")
