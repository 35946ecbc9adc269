from __future__ import annotations

import base64

import pytest

from server.access.signed_tokens import SignedToken, read_token, sign_token

SECRET = b"s" * 32
TOKEN = SignedToken("link", 1000, "0123456789ab", "studio")


def test_a_token_holds_until_the_second_it_names() -> None:
    text = sign_token(TOKEN, SECRET)
    assert read_token(text, SECRET, 999.999) == TOKEN
    assert read_token(text, SECRET, 1000.0) is None


def test_a_token_of_another_secret_is_none() -> None:
    assert read_token(sign_token(TOKEN, b"t" * 32), SECRET, 0.0) is None


def test_a_token_that_was_changed_is_none() -> None:
    fields, _, signature = sign_token(TOKEN, SECRET).partition(".")
    longer = base64.urlsafe_b64decode(fields + "==").replace(b"1000", b"9999")
    assert read_token(f"{base64.urlsafe_b64encode(longer).decode()}.{signature}", SECRET, 0.0) is None
    for i in range(len(fields)):
        changed = fields[:i] + ("A" if fields[i] != "A" else "B") + fields[i + 1 :]
        assert read_token(f"{changed}.{signature}", SECRET, 0.0) is None


@pytest.mark.parametrize("text", ["", ".", "a", "a.b.c", "é.é", "x" * 10_000, "W10.W10"])
def test_other_texts_are_none(text: str) -> None:
    assert read_token(text, SECRET, 0.0) is None
