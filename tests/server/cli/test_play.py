from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from server.cli import main
from server.cli.server_client import ServerClient
from server.client import viewing
from server.client.viewing import Watched

WATCHED = Watched(0.5, 1000, 1, 0.25, 5000, 0, ())


@pytest.mark.parametrize(
    ("url", "stream"),
    [
        ("http://here:8000/view/studio", "ws://here:8000/v1/scenes/studio/stream"),
        ("https://here/hgs/view/studio/?t=3", "wss://here/hgs/v1/scenes/studio/stream"),
        ("http://here/view/a?link=x.y&t=3", "ws://here/v1/scenes/a/stream?link=x.y"),
        ("ws://here/v1/scenes/a/stream", "ws://here/v1/scenes/a/stream"),
        ("https://here/my%20scenes/studio/", "https://here/my%20scenes/studio/"),
        ("http://here/manifest.json", "http://here/manifest.json"),
        ("http://here/a/index.hgs#t=1", "http://here/a/index.hgs"),
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
    assert asked == [(stream, 2.0, "")]
    server = [stream.partition("/v1/")[0].replace("ws", "http")] if stream.startswith("ws") else []
    assert greeted == [(one, "GET", "/v1/health") for one in server]
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


def test_the_key_of_the_environment_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    async def play(*arguments: Any) -> Watched:
        asked.append(arguments)
        return WATCHED

    monkeypatch.setattr(viewing, "play", play)
    monkeypatch.setattr(ServerClient, "request", lambda client, *question: None)
    monkeypatch.setenv("HGS_KEY", "hgs_a_b")
    assert main(["play", "http://here/view/a", "--stats"]) == 0
    assert asked[0][2] == "hgs_a_b"


def test_what_a_proxy_lacks_is_said_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async def play(*_: Any) -> Watched:
        return replace(WATCHED, over_http=True)

    monkeypatch.setattr(viewing, "play", play)
    monkeypatch.setattr(ServerClient, "request", lambda client, *question: None)
    assert main(["play", "http://here/view/a", "--stats"]) == 0
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("hgs: this site does not pass WebSockets; the scene is loaded over HTTP instead.")
    assert main(["play", "http://here/a/", "--stats"]) == 0
    assert capsys.readouterr().err == ""
