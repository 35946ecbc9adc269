from __future__ import annotations

import json
import math

from server.http.encodable import encodable


def test_what_no_answer_could_carry_is_replaced_at_any_depth() -> None:
    value = {"a": [math.nan, -math.inf, 1.5, None, True], "\ud800": {"b": ("half \udfff", "ünï 😀")}}
    result = encodable(value)
    assert result == {"a": [None, None, 1.5, None, True], "\ufffd": {"b": ["half \ufffd", "ünï 😀"]}}
    json.dumps(result, ensure_ascii=False, allow_nan=False).encode()
