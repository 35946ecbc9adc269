"""The one limit for links of requests and of the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from server.access.link_lifetime import LONGEST_LINK_DAYS, LONGEST_LINK_SECONDS
from server.cli import main
from server.routes.links import Wish


def test_a_request_is_refused_a_longer_one() -> None:
    assert Wish(scene="studio", seconds=LONGEST_LINK_SECONDS).seconds == LONGEST_LINK_DAYS * 24 * 3600
    with pytest.raises(ValidationError, match="seconds"):
        Wish(scene="studio", seconds=LONGEST_LINK_SECONDS + 1)


def test_the_command_line_is_refused_a_longer_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HGS_HOME", str(tmp_path))
    assert main(["keys", "link", "studio", "--for", f"{LONGEST_LINK_DAYS + 1}d"]) == 2
    assert f"--for: 367d is too long; give {LONGEST_LINK_DAYS}d at most" in capsys.readouterr().err
    assert main(["keys", "link", "studio", "--for", f"{LONGEST_LINK_DAYS}d"]) == 2
    assert "no such scene" in capsys.readouterr().err
