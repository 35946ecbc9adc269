"""The server against tests/vectors/messages.json, which the viewer is tested against as well."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import msgpack
import pytest

from scripts.make_message_vectors import document
from server.protocol import messages as protocol
from server.protocol.client_messages import decode
from server.protocol.messages import ClientMessage, Hello, ProtocolError, ServerMessage
from server.protocol.stream_endings import Closing, meaning, passes

FILE = Path(__file__).resolve().parents[1] / "vectors" / "messages.json"
VECTORS: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
SERVER_MESSAGES: dict[str, type[ServerMessage]] = {kind.type: kind for kind in ServerMessage.__args__}


def _named(cases: list[dict[str, Any]]) -> Any:
    return pytest.mark.parametrize("case", cases, ids=[case["name"] for case in cases])


def _value(value: Any) -> Any:
    if isinstance(value, dict) and value.keys() == {"hex"}:
        return bytes.fromhex(value["hex"])
    if isinstance(value, dict):
        return {name: _value(item) for name, item in value.items()}
    return [_value(item) for item in value] if isinstance(value, list) else value


def _fields(message: ClientMessage) -> dict[str, Any]:
    """The message as the protocol's table has it, with defaults, but without false."""
    fields = {"type": message.type} | dataclasses.asdict(message)
    if isinstance(message, Hello):
        fields["have"] = sorted(message.have)
        fields["parts"] = [[chunk, kept] for chunk, kept in message.parts.items()]
        fields["pages"] = [[page, bits] for page, bits in message.pages.items()] or None
    return {name: value for name, value in fields.items() if value is not None and value is not False}


@_named(VECTORS["client"])
def test_a_message_of_the_client_is_read(case: dict[str, Any]) -> None:
    assert _fields(decode(bytes.fromhex(case["bytes"]))) == _value(case["message"])


@_named(VECTORS["server"])
def test_a_message_of_the_server_has_these_bytes(case: dict[str, Any]) -> None:
    fields = _value(case["message"])
    message = SERVER_MESSAGES[fields.pop("type")](**fields)
    assert protocol.encode(message).hex() == case["bytes"]


@_named(VECTORS["refused_by_server"])
def test_a_message_that_breaks_the_protocol_is_refused(case: dict[str, Any]) -> None:
    with pytest.raises(ProtocolError):
        decode(bytes.fromhex(case["bytes"]))


def test_every_type_of_message_has_a_vector() -> None:
    for side, types in (("client", ClientMessage.__args__), ("server", ServerMessage.__args__)):
        assert {case["message"]["type"] for case in VECTORS[side]} == {kind.type for kind in types}


def test_the_bytes_are_those_of_the_values() -> None:
    for case in [*VECTORS["client"], *VECTORS["server"]]:
        assert msgpack.unpackb(bytes.fromhex(case["bytes"])) == _value(case["message"])


def test_the_file_is_what_the_script_writes() -> None:
    assert document() == VECTORS


@pytest.mark.parametrize("case", VECTORS["closing"], ids=lambda case: f"{case['code']}-{case['error']}")
def test_every_way_in_which_a_stream_is_closed_passes_or_has_a_meaning(case: dict[str, Any]) -> None:
    codes = [code for code in (case["code"], case["error"]) if code is not None]
    assert [passes(code) for code in codes] == len(codes) * [case["retry"]]
    assert bool(meaning(codes[-1])) is not case["retry"]


def test_the_vectors_list_every_way_of_closing() -> None:
    """The viewer is tested against them; 1006 is a connection that broke without a close."""
    listed = {(case["code"], case["error"], case["retry"]) for case in VECTORS["closing"]}
    assert listed == {(one.code, one.error or None, one.passes) for one in Closing} | {(1006, None, True)}


def test_modules_that_close_streams_name_no_bare_code() -> None:
    files = [file for file in Path(protocol.__file__).parents[1].rglob("*.py") if file.stem != "stream_endings"]
    closing = {file: code for file in files if "Closing." in (code := _code(file.read_text(encoding="utf-8")))}
    assert len(closing) > 4
    codes = "|".join(str(one.code) for one in Closing)
    assert [file for file, code in closing.items() if re.search(rf"\b({codes})\b", code)] == []


def _code(source: str) -> str:
    """Return the source without comments and docstrings."""
    return re.sub(r'""".*?"""|#[^\n]*', "", source, flags=re.DOTALL)


def test_the_document_lists_the_same_ways() -> None:
    text = (Path(__file__).resolve().parents[2] / "docs" / "stream.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d{4}) \| (?:`([a-z-]+)`)? *\|", text.partition("## Closing")[2], re.MULTILINE)
    assert {(int(code), error or None) for code, error in rows} == {
        (case["code"], case["error"]) for case in VECTORS["closing"]
    } | {(1000, None)}
