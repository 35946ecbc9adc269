from __future__ import annotations

import pytest

from scripts.fuzz_server import main


def test_neither_requests_nor_frames_are_the_servers_fault(capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["--requests", "400", "--frames", "2000"])
    printed = capsys.readouterr().out
    assert status == 0, printed
    assert "400 requests" in printed
    assert "2000 frames" in printed
