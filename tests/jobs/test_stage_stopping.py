"""Every stage of a job, of the real pipeline, stopped by SIGTERM and SIGINT: it says so, saves, and goes on."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.stages import create_run
from jobs.home.home import Home
from jobs.process.stage_outcome import ExitStatus
from tests.synthetic import write_capture

REPORTS = {
    "initialise": ("check", "frames", "masks", "points"),
    "train": ("train",),
    "encode": ("encode",),
    "publish": ("publish",),
}

# Runs the stages in one process, which signals itself when it sends the first report of a name.
STOPS_ITSELF = """
import json, os, signal, sys
from pathlib import Path
from jobs import stage
run, result, reports = sys.argv[1], Path(sys.argv[2]), json.loads(sys.argv[3])
send, asked, told = stage._send, [], []

def signalled(report, message):
    if asked and message.get("stage") == asked[0][0]:
        os.kill(os.getpid(), asked.pop()[1])
    send(report, message)

stage._send = signalled
for name, parts in reports.items():
    for part in parts:
        for number in (signal.SIGTERM, signal.SIGINT):
            asked.append((part, number))
            status = stage.main([name, run])
            paths = [path for path in Path(run).rglob("*") if path.is_file()]
            files = {str(path.relative_to(run)): path.stat().st_mtime_ns for path in paths}
            told.append({"part": part, "status": status, "asked": len(asked), "files": files})
    told.append({"part": name, "status": stage.main([name, run])})
result.write_text(json.dumps(told))
"""


@pytest.mark.slow
def test_every_stage_can_be_stopped_and_goes_on(home: Home, tmp_path: Path) -> None:
    write_capture(tmp_path / "capture")
    run = home.run("job")
    changes = {"capture.hold_out": ["2"], "capture.trust_poses": True, "train.iterations": 60}
    create_run(run, tmp_path / "capture", RunConfig.for_preset("preview").changed(changes))
    environment = {**os.environ, **home.environment(), "HGS_PIPELINE": "hgs_core.runs.stages"}
    with subprocess.Popen(
        [sys.executable, "-c", STOPS_ITSELF, str(run), str(tmp_path / "told.json"), json.dumps(REPORTS)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        text=True,
    ) as process:
        assert process.stdin is not None  # stays open: where it closes, the worker is gone
        assert process.stdout is not None
        assert process.stderr is not None
        errors = process.stderr.read()
    assert process.returncode == 0, errors
    told = json.loads((tmp_path / "told.json").read_text())
    expected = []
    for name, parts in REPORTS.items():
        expected += [(part, ExitStatus.STOPPED) for part in parts for _ in range(2)] + [(name, ExitStatus.DONE)]
    assert [(one["part"], one["status"]) for one in told] == expected
    assert not any(one.get("asked") for one in told)
    assert errors.count("was asked to stop, and has saved what it needs to go on") == 2 * sum(
        map(len, REPORTS.values())
    )
    for words in ("Traceback", "Aborted", "stack trace"):
        assert words not in errors
    files = [one["files"] for one in told if "files" in one]
    for name in ("check.json", "masks/0.masks", "points/near.json", "train.json", "scene.npz"):
        assert len({one.get(name) for one in files} - {None}) == 1, f"{name} was made again"
    assert (run / "scene" / "manifest.json").exists()
    assert not list(run.glob(".*.tmp"))
