"""The process that opens captures, as the server starts it."""

from __future__ import annotations

import dataclasses
import socket
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes, StageCount
from jobs.process.landlock import landlock_version
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_outlines import describe_capture
from server.captures.capture_readers import CaptureReaders, ReaderEndedError, answered
from tests.server.hostile_captures import HOSTILE, write_still
from tests.synthetic import write_capture

needs_sandbox = pytest.mark.skipif(landlock_version() < 4, reason="the kernel has no Landlock that refuses TCP")


@pytest.fixture
def home(tmp_path: Path) -> Home:
    return Home.at(tmp_path / "home")


def describe(home: Home, *captures: Path, seconds: int = 60) -> list[dict[str, Any]]:
    """Have captures described, in folders that may all be read."""
    folders = [str(capture.parent) for capture in captures]
    request = {"folders": folders, "uploaded": None, "captures": [str(one) for one in captures], "seconds": seconds}
    return list(CaptureReaders(home).read("describe", request, 600))


def hostile(tmp_path: Path, name: str) -> Path:
    """Write one of the captures that do harm, and return its folder."""
    folder = tmp_path / "captures" / "hostile"
    folder.mkdir(parents=True)
    HOSTILE[name](folder)
    return folder


def test_a_run_is_begun_as_the_pipeline_does(home: Home, tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=2)
    run, config = tmp_path / "run", RunConfig.from_json({"capture": {"hold_out": ["2"]}, "seed": 7})
    run.mkdir()
    request = {
        "run": str(run),
        "capture": str(tmp_path / "capture"),
        "config": config.to_json(),
        "audio": "none",
        "seconds": 60,
    }
    (answer,) = CaptureReaders(home).read("create", request, 600)
    spec = RunFolder(run).read_spec()
    assert RunConfig.from_json(answer["found"]["config"]) == spec.config == config
    assert (spec.capture, spec.given.audio, spec.prepared) == (tmp_path / "capture", "none", True)


def test_captures_are_described_one_by_one_whatever_is_wrong_with_some(home: Home, tmp_path: Path) -> None:
    well, nested, empty = tmp_path / "well", hostile(tmp_path, "lists 100,000 deep"), tmp_path / "empty"
    for folder in (well, empty):
        folder.mkdir()
    write_still(well)
    told = describe(home, nested, well, empty)
    assert told[0]["refused"][:2] == [
        str(nested / "transforms.json"),
        "its lists or tables are nested too deep to be read",
    ]
    assert told[1]["found"]["cameras"] == ["north", "east", "south", "west"]
    assert "the folder is empty" in told[2]["refused"][1]


def test_a_link_out_of_the_folders_is_refused_as_the_server_does(home: Home, tmp_path: Path) -> None:
    capture = tmp_path / "captures" / "a"
    capture.mkdir(parents=True)
    write_still(capture)
    (capture / "west.png").unlink()
    (capture / "west.png").symlink_to("/etc/hostname")
    (told,) = describe(home, capture)
    assert (told["problem"]["status"], told["problem"]["code"]) == (403, "capture-outside")


HUNGRY = """
def create_run(run, capture, config, given):
    (capture / "transforms.json").read_bytes()
    {harm}
"""


def create_with(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harm: str, seconds: int) -> dict[str, Any]:
    """Have a run begun by a pipeline that does harm once it has read a file: tables that could are not read at all."""
    for name in ("code", "capture", "run"):
        (tmp_path / name).mkdir()
    (tmp_path / "code" / "hungry_pipeline.py").write_text(HUNGRY.format(harm=harm))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "code"))
    write_still(tmp_path / "capture")
    request = {
        "run": str(tmp_path / "run"),
        "capture": str(tmp_path / "capture"),
        "config": RunConfig().to_json(),
        "audio": "none",
        "seconds": seconds,
    }
    readers = CaptureReaders(dataclasses.replace(home, pipeline="hungry_pipeline"))
    (answer,) = readers.read("create", request, 600)
    return answer


def test_memory_is_limited_as_the_stage_is(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small = dataclasses.replace(home, limits=StageLimits(memory=StageBytes(250e6)))
    told = create_with(small, tmp_path, monkeypatch, "bytearray(1 << 30)", 60)
    with pytest.raises(InputError, match=r"transforms.json: needs more memory to read than a capture may use"):
        answered(told, tmp_path / "capture")


def test_the_field_of_a_refusal_reaches_the_server(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = "from hgs_core.base.errors import InputError; raise InputError('--audio a', 'is none', field='audio')"
    with pytest.raises(InputError, match="--audio a: is none") as refused:
        answered(create_with(home, tmp_path, monkeypatch, refusal, 60), tmp_path / "capture")
    assert refused.value.field == "audio"


def test_processor_time_is_limited(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ReaderEndedError, match="takes more processor time") as raised:
        create_with(home, tmp_path, monkeypatch, "while True: pass", 0)
    assert raised.value.of(tmp_path / "capture").where == str(tmp_path / "capture" / "transforms.json")


@needs_sandbox
@pytest.mark.parametrize("harm", ["open({file!r})", "open({file!r}, 'a')", "open({file!r} + '-new', 'w')"])
def test_the_servers_database_is_out_of_reach(
    home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harm: str
) -> None:
    home.folder.mkdir()
    database = home.folder / "jobs.sqlite"
    database.touch()
    told = create_with(home, tmp_path, monkeypatch, harm.format(file=str(database)), 60)
    assert told["unreadable"].startswith("cannot be read (PermissionError: ")


@needs_sandbox
def test_a_reader_opens_no_connection(home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        harm = f"import socket; socket.create_connection({listening.getsockname()!r})"
        told = create_with(home, tmp_path, monkeypatch, harm, 60)
    assert told["unreadable"].startswith("cannot be read (PermissionError: ")


def test_a_capture_is_described_in_the_sandbox_as_without(home: Home, tmp_path: Path) -> None:
    capture = tmp_path / "captures" / "a"
    write_capture(capture, frames=2)
    (told,) = describe(home, capture)
    assert told["found"] == describe_capture(capture, CaptureFolders((capture.parent,)))


def test_links_to_other_folders_of_captures_are_followed(home: Home, tmp_path: Path) -> None:
    capture, run, elsewhere = tmp_path / "capture", tmp_path / "run", tmp_path / "elsewhere"
    write_capture(capture, frames=2)
    for folder in (run, elsewhere):
        folder.mkdir()
    for file in [path for path in capture.rglob("*") if path.suffix in (".png", ".jpg", ".mp4")]:
        moved = elsewhere / file.relative_to(capture).as_posix().replace("/", "-")
        file.rename(moved)
        file.symlink_to(moved)
    request = {"run": str(run), "capture": str(capture), "config": RunConfig().to_json(), "seconds": 60}
    request |= {"audio": "none"}
    (answer,) = CaptureReaders(home).read("create", request, 600)
    assert "found" in answer


def test_the_file_that_a_library_opens_is_known(home: Home, tmp_path: Path) -> None:
    capture = hostile(tmp_path, "concat of itself")
    few = dataclasses.replace(home, limits=StageLimits(files=StageCount(64)))
    (told,) = describe(few, capture)
    with pytest.raises(InputError, match=r"cam0.mp4: "):
        answered(told, capture)


def test_pictures_of_cameras_come_one_by_one_and_a_refusal_is_the_last(home: Home, tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=2)
    request = {"folders": [str(tmp_path)], "uploaded": None, "capture": str(tmp_path / "capture"), "seconds": 60}
    told = list(CaptureReaders(home).read("pictures", request, 600))
    assert len(told) > 2
    assert all(one["found"]["picture"].startswith("data:image/jpeg;base64,") for one in told)
    (refused,) = CaptureReaders(home).read("pictures", request | {"capture": str(tmp_path)}, 600)
    assert "refused" in refused
