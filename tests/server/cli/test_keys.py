"""`hgs keys`, against the server that the keys are for."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from jobs.home.home import Home
from jobs.records.keys import KeyTable, key_matches
from server.cli import main
from server.cli.keys import seconds


def table(home: Path) -> KeyTable:
    return KeyTable(Home.at(home))


def test_a_key_is_shown_once_listed_and_revoked(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "add", "anna", "--scope", "submit", "--scope", "publish", "--for", "30d"]) == 0
    text = capsys.readouterr().out.strip()
    assert main(["keys", "add", "otto"]) == 0
    capsys.readouterr()
    with closing(table(home)) as opened:
        anna, otto = opened.all()
        assert key_matches(anna, text)
        assert anna.expires == pytest.approx(anna.created + 30 * 86400, abs=5)
        assert sorted(otto.scopes) == ["view"]
        assert main(["keys", "ls"]) == 0
        shown = capsys.readouterr().out
        assert "anna" in shown
        assert "publish submit" in shown
        assert text.split("_", 2)[2] not in shown
        assert main(["keys", "ls", "--json"]) == 0
        assert [key["name"] for key in json.loads(capsys.readouterr().out)] == ["anna", "otto"]
        assert main(["keys", "revoke", "anna"]) == 0
        assert [key.name for key in opened.all()] == ["otto"]


def test_a_key_or_scene_that_is_not_there_is_refused(refused: Callable[..., str]) -> None:
    assert "key anna: there is no such key; hgs keys ls shows those there are" in refused("keys", "revoke", "anna")
    assert "scene studio: no such scene in the store" in refused("keys", "link", "studio")
    assert "--for: '1y' is no length of time" in refused("keys", "add", "anna", "--for", "1y")


@pytest.mark.parametrize(
    ("text", "value"), [("90s", 90), ("45m", 2700), ("12h", 43200), ("7d", 604800), ("0.5h", 1800)]
)
def test_lengths_of_time(text: str, value: float) -> None:
    assert seconds(text) == value
