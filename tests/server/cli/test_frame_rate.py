from __future__ import annotations

from fractions import Fraction

import pytest

from hgs_core.base.errors import InputError
from server.cli.frame_rate import frame_rate


@pytest.mark.parametrize(("text", "rate"), [("25", 25), ("0.5", Fraction(1, 2)), ("30000/1001", Fraction(30000, 1001))])
def test_a_rate_is_a_number_or_a_fraction(text: str, rate: Fraction) -> None:
    assert frame_rate(text) == rate


@pytest.mark.parametrize("text", ["0", "0.0001", "-1", "1/0", "nan", "1001", ""])
def test_what_is_no_rate_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"--fps: .* is no rate; give a number above 0, at most 1000"):
        frame_rate(text)
