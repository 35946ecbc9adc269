from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from jobs.queue.edit_request import EditRequest


@pytest.mark.parametrize("title", ["two\nlines", "x" * 201, "half \ud800"])
def test_a_title_that_lists_cannot_show_is_refused(title: str) -> None:
    assert EditRequest("studio", b"", "One line").title == "One line"
    with pytest.raises(InputError, match="title"):
        EditRequest("studio", b"", title)


def test_a_malformed_key_is_refused() -> None:
    with pytest.raises(InputError, match="is no idempotency key"):
        EditRequest("studio", b"", key="a b")


def test_the_digest_is_of_all_that_is_asked_for() -> None:
    asked = [EditRequest("a", b"x"), EditRequest("b", b"x"), EditRequest("a", b"y"), EditRequest("a", b"x", "Title")]
    assert len({one.digest for one in asked}) == len(asked)
    assert EditRequest("a", b"x", key="k").digest == asked[0].digest
