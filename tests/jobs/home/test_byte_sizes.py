from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from jobs.home.byte_sizes import bytes_of


@pytest.mark.parametrize(("text", "number"), [("0", 0), ("20", 20), ("2.5k", 2500), ("3TB", 3e12), ("7 M", None)])
def test_sizes(text: str, number: float | None) -> None:
    if number is None:
        with pytest.raises(InputError, match="--keep-bytes"):
            bytes_of(text, "--keep-bytes")
    else:
        assert bytes_of(text, "--keep-bytes") == number
