from __future__ import annotations

from pathlib import Path

from server.job_views.job_log import log_tail


def test_the_end_of_the_log_is_as_a_terminal_shows_it(tmp_path: Path) -> None:
    (tmp_path / "stage.log").write_bytes(b"first\n\x1b[31mred\x1b[0m\n 10 %\r 20 %\r\n")
    assert log_tail(tmp_path, 2) == {"lines": ["red", " 20 %"], "complete": False}
    assert log_tail(tmp_path, 3)["complete"]


def test_a_run_without_a_log_has_no_lines(tmp_path: Path) -> None:
    assert log_tail(tmp_path, 5) == {"lines": [], "complete": True}
