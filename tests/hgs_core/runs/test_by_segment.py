"""Segments that are made by themselves, in any order: the same bits, and a scene that grows."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.codec.format.growth import continues
from hgs_core.runs.by_segment import assemble, finish, made, make_segment, segment_count
from hgs_core.runs.creation import create_run
from hgs_core.runs.encoding import encode
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import initialise, train
from hgs_core.scene.files import load_scene
from tests.synthetic import write_capture

CONFIG = RunConfig.from_json(
    {
        "capture": {"hold_out": ["2"]},
        "points": {"static": 200, "dynamic": 40, "interval": 0.1},
        "train": {
            "iterations": 20,
            "checkpoint_every": 10,
            "segment_frames": 2,
            "density": {"every": 40, "max_static": 250, "max_dynamic": 60},
        },
        "encode": {"by_segment": True},
    }
)


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that is ready to be trained."""
    folder = tmp_path_factory.mktemp("by_segment")
    write_capture(folder / "capture")
    create_run(folder / "run", folder / "capture", CONFIG)
    initialise(folder / "run", silent)
    return folder / "run"


@pytest.fixture(scope="module")
def in_one_process(begun: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = shutil.copytree(begun, tmp_path_factory.mktemp("one") / "run")
    train(run, silent)
    encode(run, silent)
    return run


def chunks_of(run: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (run / "scene" / "chunks").iterdir()}


def timeless(manifest: Path) -> dict[str, object]:
    """A manifest without its times, which differ between two trainings."""
    document: dict[str, object] = json.loads(manifest.read_text())
    training = document["training"]
    assert isinstance(training, dict)
    del training["seconds"]
    return document


def test_segments_in_any_order_make_the_same_bits(begun: Path, in_one_process: Path, tmp_path: Path) -> None:
    run = shutil.copytree(begun, tmp_path / "run")
    assert segment_count(run) == 3
    versions = []
    for number in (0, 2, 1):
        if number == 1:  # interrupted, and gone on with
            with pytest.raises(StageStopped):
                make_segment(run, number, stop_half_way)
        make_segment(run, number, silent)
        versions.append((assemble(run), json.loads((run / "scene" / "manifest.json").read_text())))
    assert [count for count, _ in versions] == [1, 1, 3]
    assert versions[1] == versions[0]
    assert [document["live"] for _, document in versions] == [1, 1, 3]
    finish(run, silent)
    last = json.loads((run / "scene" / "manifest.json").read_text())
    assert "live" not in last
    assert continues(versions[2][1], versions[0][1])
    assert continues(last, versions[2][1])
    assert chunks_of(run) == chunks_of(in_one_process)
    assert timeless(run / "scene" / "manifest.json") == timeless(in_one_process / "scene" / "manifest.json")
    assert (run / "scene.npz").read_bytes() == (in_one_process / "scene.npz").read_bytes()


def test_a_scene_grows_without_another_look_at_the_segments_it_has(in_one_process: Path, tmp_path: Path) -> None:
    run = shutil.copytree(in_one_process, tmp_path / "run")
    shutil.rmtree(run / "scene")
    (run / "segments" / "2").rename(tmp_path / "2")
    assert assemble(run) == 2
    (run / "segments" / "0" / "manifest.json").write_text("not looked at")
    (tmp_path / "2").rename(run / "segments" / "2")
    assert assemble(run) == 3
    document = json.loads((run / "scene" / "manifest.json").read_text())
    whole = json.loads((in_one_process / "scene" / "manifest.json").read_text())
    assert document.pop("live") == 3
    assert document | {"training": whole["training"]} == whole
    assert chunks_of(run) == chunks_of(in_one_process)


def stop_half_way(progress: Progress) -> None:
    if progress.done >= progress.total // 2:
        raise StageStopped


def test_the_scene_is_whole_and_shows_what_was_trained(in_one_process: Path) -> None:
    manifest, trained = load_manifest(in_one_process / "scene"), load_scene(in_one_process / "scene.npz")
    decoded = decode_scene(in_one_process / "scene")
    assert manifest.live is None
    assert [(s.start, s.end) for s in manifest.segments] == [(s.start, s.end) for s in trained.segments]
    assert 0 < len(decoded.static) <= len(trained.static)
    counts = [(len(a.dynamic), len(b.dynamic)) for a, b in zip(decoded.segments, trained.segments, strict=True)]
    assert all(coded <= kept for coded, kept in counts)
    assert sum(coded for coded, _ in counts) > 0
    assert manifest.training["iterations"] == 60
    assert manifest.training["encoding_loss"] <= 0.1  # the first segment's


def test_the_first_segment_finds_the_limits_of_the_captured_space(in_one_process: Path) -> None:
    first, second = (load_manifest(in_one_process / "segments" / str(number)).captured_space for number in (0, 1))
    assert first is not None
    assert first.seen is not None
    assert second is not None
    assert second.seen is None
    assert load_manifest(in_one_process / "scene").captured_space == first


def test_nothing_is_made_twice(in_one_process: Path) -> None:
    folder = RunFolder(in_one_process)
    before = {path: path.stat().st_mtime_ns for path in in_one_process.rglob("*") if path.is_file()}
    assert made(in_one_process, 2)
    make_segment(in_one_process, 1, silent)
    train(in_one_process, silent)
    encode(in_one_process, silent)
    assert folder.train_summary.exists()
    assert {path: path.stat().st_mtime_ns for path in in_one_process.rglob("*") if path.is_file()} == before
