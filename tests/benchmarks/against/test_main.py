from __future__ import annotations

import pytest

from benchmarks.against.__main__ import main


def test_what_is_not_there_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["/nowhere"]) == 2
    assert "/nowhere" in capsys.readouterr().err
