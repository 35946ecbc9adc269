from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable, require_storable


@pytest.mark.parametrize(("text", "storable"), [("", True), ("ünï 😀\n", True), ("a\0", False), ("\ud800", False)])
def test_text_with_nul_or_half_a_surrogate_pair_cannot_be_stored(text: str, storable: bool) -> None:
    assert is_storable(text) is storable


@pytest.mark.parametrize("text", ["a\0", "\udfff", "four"])
def test_a_refusal_names_the_field_and_can_be_printed(text: str) -> None:
    with pytest.raises(InputError, match="title: ") as refused:
        require_storable("title", text, 3)
    str(refused.value).encode()
