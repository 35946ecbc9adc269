"""`hgs bench`: raster and train on scenes too small to say anything about speed, codec with a stand-in.

What is measured is tested in tests/hgs_core/bench.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.bench.codec import codec_bench as codec
from hgs_core.native import library
from server.cli import main
from tests.synthetic import write_capture

TINY = ["--sizes", "60@32x24", "--threads", "1", "--seconds", "0.001", "--backends", "reference"]


def test_json_takes_the_place_of_the_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "raster", *TINY, "--json"]) == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert (point["splats"], point["width"], point["height"], point["backend"]) == (60, 32, 24, "reference")


def test_json_file_is_written_beside_the_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "raster.json"
    assert main(["bench", "raster", *TINY, "--json", str(file)]) == 0
    assert json.loads(file.read_text())["settings"]["threads"] == [1]
    output = capsys.readouterr()
    assert "60@32x24" in output.out
    assert "1/1" in output.err


@pytest.mark.skipif(not library.available(), reason="hgs was built without its C++ kernels")
def test_both_backends_are_measured_where_there_are_kernels(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "raster", *TINY[:-2], "--json", "-"]) == 0
    assert [p["backend"] for p in json.loads(capsys.readouterr().out)["points"]] == ["cpu", "reference"]


def test_a_training_is_timed_and_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_capture(tmp_path, frames=2, width=32, height=24)
    small = [
        "train.iterations=4",
        "points.static=60",
        "points.dynamic=20",
        "train.density.max_static=80",
        "train.density.max_dynamic=30",
    ]
    assert main(["bench", "train", str(tmp_path), "--hold-out", "2", "--set", *small, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["device"], report["config"]["train"]["iterations"]) == ("cpu", 4)
    assert report["psnr"] > 0
    assert 0 < report["minutes"] <= report["minutes_in_all"]


def test_a_training_needs_a_camera_to_score_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "train", str(tmp_path)]) == 2
    assert "--hold-out" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (["--sizes", "many"], "--sizes"),
        (["--threads", "0"], "--threads"),
        (["--backends", "gpu"], "--backends"),
        (["--truth", "1k@64x48"], "--truth"),
        (["--seconds", "soon"], "--seconds"),
        (["--seconds", "inf"], "--seconds"),
        (["--dynamic", "2"], "--dynamic"),
        (["--seed", "1.5"], "--seed"),
        (["--json", "/nowhere/raster.json"], "/nowhere/raster.json"),
    ],
)
def test_bad_arguments_are_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], word: str) -> None:
    assert main(["bench", "raster", *wrong]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("hgs: ")
    assert word in output.err
    assert output.err.count("\n") == 1


def test_cpu_backend_without_kernels_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(library, "available", lambda: False)
    assert main(["bench", "raster", "--backends", "cpu"]) == 2
    assert "install a C++17 compiler" in capsys.readouterr().err


def test_truth_can_be_left_out(capsys: pytest.CaptureFixture[str]) -> None:
    if library.available():
        assert main(["bench", "raster", *TINY[:-2], "--truth", "none", "--json"]) == 0
        (point,) = json.loads(capsys.readouterr().out)["points"]
        assert (point["backend"], point["errors"]) == ("cpu", None)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """The requests of `hgs bench codec`, answered with an empty report."""
    found: list[dict[str, Any]] = []

    def bench_codec(source: Path, progress: object, **options: Any) -> codec.CodecReport:
        found.append({"source": source, **options})
        machine = {"cpu": "Fast One", "cores": 4, "load": 0.5}
        return codec.CodecReport(machine, "studio", 12, 0, (), (), 0.0, 0.0, {}, 65_536, {}, {})

    monkeypatch.setattr(codec, "bench_codec", bench_codec)
    return found


@pytest.mark.parametrize(
    ("arguments", "sweep"),
    [([], codec.SWEEP), (["--sweep", "0.5,4"], (0.5, 4.0)), (["--sweep", "none"], ())],
    ids=["default", "list", "none"],
)
def test_the_codec_is_measured_with_the_budgets_and_the_sweep(
    asked: list[dict[str, Any]], arguments: list[str], sweep: tuple[float, ...]
) -> None:
    assert main(["bench", "codec", "studio", *arguments]) == 0
    assert asked == [{"source": Path("studio"), "budgets": ("default", "low"), "sweep": sweep}]


@pytest.mark.usefixtures("asked")
def test_the_codec_s_report_is_a_table_and_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "codec", "studio", "--json", str(tmp_path / "codec.json")]) == 0
    assert "studio: 12 static and 0 dynamic splats" in capsys.readouterr().out
    assert json.loads((tmp_path / "codec.json").read_text())["splats_static"] == 12


def test_a_bad_sweep_is_refused(asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "codec", "studio", "--sweep", "fine"]) == 2
    assert "--sweep: 'fine' is not a number" in capsys.readouterr().err
    assert asked == []


def test_a_source_that_is_none_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "codec", str(tmp_path / "nothing")]) == 2
    assert "is not a run" in capsys.readouterr().err
