"""Every command with a place to write to that cannot be written: one line that names it, status 2, before long work."""

from __future__ import annotations

import importlib
import resource
import shlex
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.cli import main
from tests.test_configuration_page import command_names

# What writes to a place that the command line names: {out} is that place.
NAMED = """
train {capture} --out {out}
check {capture} --json {out}
sync {videos} --out {out}
masks {capture} --out {out}
report {run} --out {out}
edit {run} --out {out} --trim=0,0.1
edit {run} --out {free} --trim=0,0.1 --json {out}
publish {run} --to {out}
import {splats} --out {out}
import {splats} --out {free} --json {out}
export {run} --to {out}.ply
export {run} --to {out}
export {run} --to {free}.ply --json {out}
render {run} --out {out}.mp4
render {run} --out {out}
play http://127.0.0.1:9/view/x --stats --patience 0 --json {out}
ablate {capture} --out {out} --hold-out 1
ablate {capture} --out {free} --hold-out 1 --json {out}
bench raster --json {out}
bench codec {run} --json {out}
bench train {capture} --json {out}
bench stream --json {out}
""".strip().splitlines()

# What writes beside what it reads.
BESIDE = ("cameras {videos}", "sync {videos}", "encode {run}", "eval {run}", "report {run}")

# What writes to the home.
AT_HOME = """
publish {run}
submit {capture}
serve --port 0 --workers 0
worker
gc
jobs ls
jobs show x
jobs workers
keys ls
keys add x
backup {free}
restore {capture}
""".strip().splitlines()

PLACES = {"below a file": "file/x", "a name that is too long": "n" * 300, "a path that is too long": "n/" * 2100}


@pytest.fixture
def places(capture: Path, splats: Path, run: Path, n3dv: Path, tmp_path: Path) -> dict[str, Path]:
    (tmp_path / "file").touch()
    (n3dv / "poses_bounds.npy").unlink()
    return {"capture": capture, "splats": splats, "run": run, "videos": n3dv, "free": tmp_path / "free"}


@pytest.fixture(autouse=True)
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail where a command begins its work before it has looked at where to write."""

    def work(*arguments: object, **options: object) -> None:
        raise AssertionError("the work has begun")

    replaced = (
        "hgs_core.decompose.masks.motion_masks",
        "hgs_core.calibrate.find_cameras.find_cameras",
        "hgs_core.check.capture_check.check_capture",
        "hgs_core.evaluate.run.evaluate_run",
        "hgs_core.runs.encoding.encode_again",
        "hgs_core.ablate.ablation.ablate",
        "hgs_core.runs.edited.edit_run",
        "hgs_core.runs.imported.import_run",
        "hgs_core.report.write.write_report",
        "hgs_core.bench.raster.raster_bench.bench_raster",
        "hgs_core.bench.codec.codec_bench.bench_codec",
        "hgs_core.bench.training_bench.bench_training",
        "hgs_core.runs.stages.train_scene",
    )
    for place in replaced:  # first: a module that is loaded after the replacement of another would keep that
        importlib.import_module(place.rpartition(".")[0])
    for place in replaced:
        monkeypatch.setattr(place, work)


@pytest.fixture
def full_disk(places: dict[str, Path]) -> Iterator[None]:
    """No file may grow from now on, as on a disk without a free block."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def refusal(line: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(shlex.split(line)) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("hgs: "), told.err
    assert told.err.count("\n") == 1, told.err
    return told.err


def files(*folders: Path) -> list[Path]:
    return sorted(path for folder in folders for path in folder.rglob("*") if path.name != "run.lock")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("line", NAMED)
def test_a_named_place_that_cannot_be_had(
    line: str, place: str, places: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, before = tmp_path / PLACES[place], files(tmp_path, places["run"])
    assert str(out)[:200] in refusal(line.format(**places, out=out), capsys)
    assert files(tmp_path, places["run"]) == before


@pytest.mark.skipif(not Path("/sys").is_dir(), reason="Linux")
@pytest.mark.parametrize("line", [line for line in NAMED if "--json {out}" not in line])
def test_a_file_system_that_takes_no_files(
    line: str, places: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert "/sys/x" in refusal(line.format(**places, out="/sys/x"), capsys)


@pytest.mark.usefixtures("full_disk")
@pytest.mark.parametrize("line", [*NAMED, *BESIDE])
def test_a_full_disk(line: str, places: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = files(tmp_path, places["run"])
    assert "file too large" in refusal(line.format(**places, out=tmp_path / "out"), capsys)
    assert files(tmp_path, places["run"]) == before


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("line", AT_HOME)
def test_a_home_that_cannot_be_had(
    line: str,
    place: str,
    places: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("HGS_HOME", str(tmp_path / PLACES[place]))
    before = files(tmp_path)
    refusal(line.format(**places), capsys)
    assert files(tmp_path) == before


@pytest.mark.usefixtures("full_disk")
@pytest.mark.parametrize("line", AT_HOME)
def test_a_home_on_a_full_disk(line: str, places: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(shlex.split(line.format(**places))) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert [one.startswith("hgs: ") for one in told.err.splitlines() if "\r" not in one and one][-1]
    assert "Traceback" not in told.err


def test_no_command_is_forgotten() -> None:
    assert {line.split()[0] for line in (*NAMED, *BESIDE, *AT_HOME)} == set(command_names())
