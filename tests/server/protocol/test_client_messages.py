from __future__ import annotations

import contextlib

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.protocol.client_messages import decode
from server.protocol.messages import (
    MAX_HAVE,
    MAX_MESSAGE_BYTES,
    MAX_PARTS,
    ClientMessage,
    Credit,
    Hello,
    Pause,
    Ping,
    Play,
    ProtocolError,
    Seek,
    encode,
)

UINT = st.integers(0, 2**63)


TIME = st.floats(allow_nan=False, allow_infinity=False)


RATE = st.floats(0, 16)


CHUNK = st.binary(min_size=32, max_size=32)


CLIENT_MESSAGES = st.one_of(
    st.builds(
        Hello,
        protocol=st.just(1),
        credits=UINT,
        have=st.frozensets(CHUNK, max_size=5),
        parts=st.dictionaries(CHUNK, UINT, max_size=5),
        manifest_id=st.none() | CHUNK,
        time=st.none() | TIME,
        rate=RATE,
    ),
    st.builds(Credit, UINT),
    st.builds(Seek, TIME),
    st.builds(Play, TIME, RATE),
    st.builds(Pause, TIME),
    st.builds(Ping, UINT),
)


@given(CLIENT_MESSAGES)
def test_decode_reads_what_encode_wrote(message: ClientMessage) -> None:
    assert decode(encode(message)) == message


@given(st.binary(max_size=200))
def test_any_bytes_decode_or_are_refused(data: bytes) -> None:
    with contextlib.suppress(ProtocolError):
        decode(data)


@given(CLIENT_MESSAGES, st.integers(0, 10_000))
def test_truncated_messages_are_malformed(message: ClientMessage, cut: int) -> None:
    data = encode(message)
    with pytest.raises(ProtocolError) as caught:
        decode(data[: cut % len(data)])
    assert caught.value.closing.error == "malformed"


@pytest.mark.parametrize(
    ("fields", "word"),
    [
        ({}, "type"),
        ({"type": "dance"}, "dance"),
        ({"type": ["hello"]}, "type"),
        ({"type": "hello", "credits": 1}, "protocol is missing"),
        ({"type": "hello", "protocol": 1}, "credits is missing"),
        ({"type": "hello", "protocol": 1, "credits": -1}, "credits"),
        ({"type": "hello", "protocol": 1, "credits": True}, "credits"),
        ({"type": "hello", "protocol": 1, "credits": 1.5}, "credits"),
        ({"type": "hello", "protocol": 1, "credits": 1, "have": [b"short"]}, "32 bytes"),
        ({"type": "hello", "protocol": 1, "credits": 1, "have": ["0" * 64]}, "32 bytes"),
        ({"type": "hello", "protocol": 1, "credits": 1, "have": b"0" * 32}, "list"),
        ({"type": "hello", "protocol": 1, "credits": 1, "rate": 17}, "rate"),
        ({"type": "hello", "protocol": 1, "credits": 1, "time": None}, "time"),
        ({"type": "credit"}, "bytes is missing"),
        ({"type": "credit", "bytes": "many"}, "bytes"),
        ({"type": "seek", "time": float("nan")}, "finite"),
        ({"type": "seek", "time": float("inf")}, "finite"),
        ({"type": "play", "time": 1.0}, "rate is missing"),
        ({"type": "play", "time": 1.0, "rate": -1.0}, "rate"),
        ({"type": "pause", "time": "now"}, "time"),
        ({"type": "ping", "id": None}, "id"),
    ],
)
def test_bad_fields_are_named(fields: dict[str, object], word: str) -> None:
    with pytest.raises(ProtocolError, match=word) as caught:
        decode(msgpack.packb(fields))
    assert (caught.value.closing.code, caught.value.closing.error) == (4000, "malformed")


@pytest.mark.parametrize("value", [[], "hello", 3, None, {1: 2}])
def test_only_maps_with_string_keys_are_messages(value: object) -> None:
    with pytest.raises(ProtocolError):
        decode(msgpack.packb(value))


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(ProtocolError):
        decode(b"\x91" * 100_000)


def test_another_version_is_unsupported_whatever_its_fields() -> None:
    with pytest.raises(ProtocolError) as caught:
        decode(msgpack.packb({"type": "hello", "protocol": 4, "credits": "lots"}))
    assert (caught.value.closing.code, caught.value.closing.error) == (4001, "protocol-unsupported")


def test_unknown_fields_are_ignored() -> None:
    assert decode(msgpack.packb({"type": "seek", "time": 1, "colour": "red"})) == Seek(1.0)


def test_hello_of_a_client_that_keeps_nothing_may_leave_out_all_lists() -> None:
    assert decode(msgpack.packb({"type": "hello", "protocol": 1, "credits": 5})) == Hello(1, 5)


@pytest.mark.parametrize(
    "fields",
    [
        {"parts": None},
        {"parts": {bytes(32): 1}},
        {"parts": [bytes(32)]},
        {"parts": [[bytes(31), 1]]},
        {"parts": [["0" * 64, 1]]},
        {"parts": [[bytes(32), -1]]},
        {"parts": [[bytes(32), 1.5]]},
        {"parts": [[bytes(32), True]]},
        {"parts": [[bytes(32), 1, 2]]},
        {"parts": [[bytes(32), 1]] * (MAX_PARTS + 1)},
        {"manifest_id": None},
        {"manifest_id": "0" * 64},
        {"manifest_id": bytes(31)},
    ],
)
def test_what_a_client_keeps_is_checked(fields: dict[str, object]) -> None:
    with pytest.raises(ProtocolError, match=f"hello.{next(iter(fields))}") as caught:
        decode(msgpack.packb({"type": "hello", "protocol": 1, "credits": 0} | fields))
    assert (caught.value.closing.code, caught.value.closing.error) == (4000, "malformed")


def test_message_at_the_limit_holds_full_lists() -> None:
    full = frozenset(k.to_bytes(32, "big") for k in range(MAX_HAVE))
    parts = {k.to_bytes(32, "big"): 1 << 31 for k in range(MAX_PARTS)}
    data = encode(Hello(protocol=1, credits=0, have=full, parts=parts, manifest_id=bytes(32)))
    assert len(data) <= MAX_MESSAGE_BYTES
    decoded = decode(data)
    assert isinstance(decoded, Hello)
    assert len(decoded.have) == MAX_HAVE


def test_longer_have_lists_are_refused() -> None:
    long = [k.to_bytes(32, "big") for k in range(MAX_HAVE + 1)]
    with pytest.raises(ProtocolError, match="at most 16384"):
        decode(msgpack.packb({"type": "hello", "protocol": 1, "credits": 0, "have": long}))


def test_messages_above_the_limit_are_refused() -> None:
    with pytest.raises(ProtocolError) as caught:
        decode(b"\xc4" + bytes(MAX_MESSAGE_BYTES))
    assert caught.value.closing.code == 1009
