from __future__ import annotations

from pathlib import Path

import pytest

from server.cli import main
from tests.hgs_core.report.finished_run import write_finished_run


def test_report_writes_a_page_into_the_run_and_prints_its_path(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = write_finished_run(tmp_path)
    assert main(["report", str(run)]) == 0
    assert capsys.readouterr().out.split() == [str(run / "report.html")]
    assert (run / "report.html").read_text().startswith("<!DOCTYPE html>")


def test_report_writes_to_the_file_that_is_named_and_compares(tmp_path: Path) -> None:
    run, other = write_finished_run(tmp_path), write_finished_run(tmp_path, "other")
    page = tmp_path / "pages" / "page.html"
    assert main(["report", str(run), "--out", str(page), "--against", str(other)]) == 0
    assert '<th scope="row">other</th>' in page.read_text()


@pytest.mark.parametrize("order", [["gone"], ["run", "--against", "gone"]])
def test_a_folder_that_is_no_run_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], order: list[str]
) -> None:
    write_finished_run(tmp_path)
    arguments = [word if word.startswith("--") else str(tmp_path / word) for word in order]
    assert main(["report", *arguments]) == 2
    assert f"hgs: {tmp_path / 'gone'}: is not a run" in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.html"))
