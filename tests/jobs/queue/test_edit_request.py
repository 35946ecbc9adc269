from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from jobs.queue.edit_request import EditRequest


@pytest.mark.parametrize("title", ["two\nlines", "x" * 201, "half \ud800"])
def test_a_title_that_lists_cannot_show_is_refused(title: str) -> None:
    assert EditRequest("studio", b"", "One line").title == "One line"
    with pytest.raises(InputError, match="title"):
        EditRequest("studio", b"", title)
