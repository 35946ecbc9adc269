from __future__ import annotations

import pytest

from server.protocol.stream_endings import meaning, passes


@pytest.mark.parametrize("code", [1000, 1001, 1006, 1011, 1012, 1013, 4008, "internal", "hello-timeout"])
def test_a_client_comes_back_after_what_may_pass(code: int | str) -> None:
    assert passes(code)


@pytest.mark.parametrize("code", [1003, 1009, 4000, 4001, 4003, 4004, 4009, 4999, "access-ended", "of tomorrow"])
def test_a_client_does_not_come_back_to_be_refused_again(code: int | str) -> None:
    assert not passes(code)


def test_a_revoked_key_is_called_so() -> None:
    assert meaning("access-ended") == meaning(4003) == "the key or link that opened the stream is no longer valid"


def test_what_is_not_known_has_no_meaning() -> None:
    assert (meaning(4999), meaning("of tomorrow")) == ("", "")
