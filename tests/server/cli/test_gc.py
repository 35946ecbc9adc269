from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from server.cli import main


def test_nothing_is_changed_until_it_is_said(n3dv: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with JobClient(Home.at(home)) as client:
        job_id = client.submit(JobRequest(n3dv, RunConfig()))
        client.cancel(job_id)
        assert main(["gc", "--keep-jobs", "0"]) == 0
        told = capsys.readouterr().out
        assert job_id in told
        assert "nothing was changed" in told
        assert client.home.run(job_id).is_dir()
        assert main(["gc", "--keep-jobs", "0", "--delete", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["jobs"] == [job_id]
        assert not client.home.run(job_id).exists()


@pytest.mark.parametrize("option", ["--keep-jobs", "--keep-days", "--keep-bytes", "--every"])
def test_what_is_no_number_is_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gc", option, "many"]) == 2
    assert option in capsys.readouterr().err


class TestCheck:
    """`hgs gc --check`."""

    @pytest.fixture
    def run(self, scene_folder: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> Path:
        assert main(["publish", str(scene_folder), "--id", "studio"]) == 0
        capsys.readouterr()
        return scene_folder

    def test_a_sound_store(self, run: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["gc", "--check"]) == 0
        assert capsys.readouterr().out.startswith("1 scenes name ")

    @pytest.mark.parametrize("text", [None, b"something else"])
    def test_a_hole_is_told_and_the_cure_works(
        self, run: Path, home: Path, text: bytes | None, capsys: pytest.CaptureFixture[str]
    ) -> None:
        chunk = next((home / "store" / "chunks").iterdir())
        chunk.unlink() if text is None else chunk.write_bytes(text)
        assert main(["gc", "--check"]) == 1
        told = capsys.readouterr().out
        assert f"{'damaged' if text else 'missing'}: chunks/{chunk.name} of studio" in told
        assert "hgs publish RUN --id SCENE" in told
        assert main(["gc", "--check", "--json"]) == 1
        assert json.loads(capsys.readouterr().out)["faults"][0]["scenes"] == ["studio"]
        chunk.unlink(missing_ok=True)
        open_store(Home.at(home)).remove_scene("studio")
        assert main(["publish", str(run), "--id", "studio"]) == 0
        assert main(["gc", "--check"]) == 0

    @pytest.mark.parametrize("option", [["--delete"], ["--every", "1h"]])
    def test_it_changes_nothing(self, home: Path, option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["gc", "--check", *option]) == 2
        assert "--check: changes nothing" in capsys.readouterr().err
