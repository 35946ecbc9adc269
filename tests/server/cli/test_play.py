from __future__ import annotations

import json
from typing import Any

import pytest

from server import viewing
from server.cli import main
from server.cli.server_client import ServerClient
from server.viewing import Watched

WATCHED = Watched(0.5, 1000, 1, 0.25, 5000, 0, ())


@pytest.mark.parametrize(
    ("url", "stream"),
    [
        ("http://here:8000/view/studio", "ws://here:8000/v1/scenes/studio/stream"),
        ("https://here/hgs/view/studio/?t=3", "wss://here/hgs/v1/scenes/studio/stream"),
        ("ws://here/v1/scenes/a/stream", "ws://here/v1/scenes/a/stream"),
    ],
)
def test_scene_is_played_from_its_page_or_its_stream(
    url: str, stream: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []

    async def play(*arguments: Any) -> Watched:
        asked.append(arguments)
        return WATCHED

    monkeypatch.setattr(viewing, "play", play)
    greeted: list[Any] = []
    monkeypatch.setattr(ServerClient, "request", lambda client, *question: greeted.append((client.url, *question)))
    assert main(["play", url, "--stats", "--seconds", "2", "--json"]) == 0
    assert asked == [(stream, 2.0)]
    assert greeted == [(stream.partition("/v1/")[0].replace("ws", "http"), "GET", "/v1/health")]
    assert json.loads(capsys.readouterr().out) == WATCHED.to_json()
    assert main(["play", url, "--stats"]) == 0
    assert "plays after 0.50 s" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (["ftp://here/view/a", "--stats"], "is not the address of a scene"),
        (["http://here/", "--stats"], "is not the address of a scene"),
        (["http://here/view/a"], "--stats"),
        (["http://here/view/a", "--stats", "--seconds", "0"], "--seconds"),
    ],
)
def test_bad_arguments_are_named(wrong: list[str], word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["play", *wrong]) == 2
    assert word in capsys.readouterr().err
