"""Whole ablations of a tiny capture: every row trains, and nothing is done twice."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hgs_core.ablate.ablation import ablate
from hgs_core.ablate.ablation_rows import ROWS
from hgs_core.ablate.plan import Ablation
from hgs_core.ablate.summary import FIGURES
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import mask_file
from hgs_core.points.kept_points import segment_points
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.files import load_scene
from tests.hgs_core.ablate.conftest import CONFIG, MakeAblation
from tests.hgs_core.evaluate.conftest import save
from tests.tolerances import assert_close


@pytest.fixture(scope="module")
def everything(make_ablation: MakeAblation, tmp_path_factory: pytest.TempPathFactory) -> tuple[Ablation, Any]:
    """All rows with one seed, and their result."""
    ablation = make_ablation(tmp_path_factory.mktemp("everything") / "out")
    return ablation, ablate(ablation, silent)


def refuse(progress: Progress) -> None:
    raise AssertionError(progress)


def files(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def test_every_row_trains(everything: tuple[Ablation, Any]) -> None:
    ablation, result = everything
    assert [row["name"] for row in result["rows"]] == list(ROWS)
    for row in ROWS.values():
        run = ablation.run(row, 0).folder
        assert json.loads(run.train_summary.read_text())["iterations"] == CONFIG.train.iterations
        assert run.read_spec().config == row.config(CONFIG, 0)


def test_the_figures_are_those_of_the_runs(everything: tuple[Ablation, Any]) -> None:
    ablation, result = everything
    for row in result["rows"]:
        scores = json.loads(ablation.run(ROWS[row["name"]], 0).folder.evaluation.read_text())
        assert row["mean"] == {name: scores[name] for name in FIGURES}
        assert row["runs"] == [{"seed": 0} | row["mean"]]
    assert json.loads((ablation.out / "ablation.json").read_text()) == result


def test_a_finished_ablation_repeats_nothing(everything: tuple[Ablation, Any]) -> None:
    ablation, result = everything
    before = files(ablation.out)
    assert ablate(ablation, refuse) == result
    changed = {path.name for path, time in files(ablation.out).items() if before.get(path) != time}
    assert changed == {"ablation.json", "run.lock"}


def test_rows_that_start_from_the_same_share_it(everything: tuple[Ablation, Any]) -> None:
    ablation, _ = everything
    full = ablation.run(ROWS["full"], 0).folder
    for row in ROWS.values():
        run = ablation.run(row, 0).folder
        own_points = row.masks is not None or any(field.startswith("points.") for field in row.fields)
        assert run.near_planes.samefile(full.near_planes) != own_points, row.name
        assert mask_file(run.masks, 0).samefile(mask_file(full.masks, 0)) != (row.masks is not None), row.name


def test_rows_are_what_they_say(everything: tuple[Ablation, Any]) -> None:
    ablation, result = everything
    by_name = {row["name"]: row for row in result["rows"]}
    assert by_name["all-dynamic"]["mean"]["splats_static"] == by_name["all-static"]["mean"]["splats_dynamic"] == 0
    assert by_name["order-2"]["changes"] == {"train.motion_order": 2}
    shares = [by_name[name]["moving"] for name in ("masks-eroded", "full", "masks-dilated", "masks-95")]
    assert shares == sorted(set(shares))
    moments = {
        name: len(np.unique(segment_points(ablation.run(ROWS[name], 0).folder.points, 0).times))
        for name in ("full", "no-interleaved-init")
    }
    assert moments["no-interleaved-init"] == 1


def test_statics_stored_as_dynamics_look_the_same(everything: tuple[Ablation, Any]) -> None:
    ablation, result = everything
    full, derived = (
        next(row["mean"] for row in result["rows"] if row["name"] == name) for name in ("full", "no-parameter-sharing")
    )
    assert (derived["splats_static"], derived["bytes_static"]) == (0, 0)
    assert derived["bytes_dynamic"] > full["bytes_dynamic"]
    assert derived["train_seconds"] == full["train_seconds"]
    # Before encoding, which trains further and drops what shows too little, at the coarseness that suits each of them.
    before, after = (
        load_scene(ablation.run(ROWS[name], 0).folder.trained) for name in ("full", "no-parameter-sharing")
    )
    assert len(after.static) == 0
    assert len(after.segments[0].dynamic) == len(before.static) + len(before.segments[0].dynamic)
    camera = open_capture(ablation.capture).cameras[0]
    for moment in (0.0, 0.6):
        pictures = [
            rasterize(s.static, s.segments[0].dynamic, camera, moment, gradients="none", antialiased=True).rgb
            for s in (before.map(torch.from_numpy), after.map(torch.from_numpy))
        ]
        assert_close(pictures[1], pictures[0].double())


def test_an_interrupted_ablation_goes_on_where_it_stopped(make_ablation: MakeAblation, tmp_path: Path) -> None:
    ablation = make_ablation(tmp_path / "out", ["order-1"], seeds=(0, 1))
    stages: list[str] = []

    def stop_in_the_third(progress: Progress) -> None:
        stages.append(progress.stage)
        if progress.stage == "full 1 train":
            raise StageStopped

    with pytest.raises(StageStopped):
        ablate(ablation, stop_in_the_third)
    assert json.loads((tmp_path / "out" / "ablation.json").read_text())["rows"][1]["runs"][0]["seed"] == 0
    again: list[str] = []
    result = ablate(ablation, lambda progress: again.append(progress.stage))
    assert {stage.split()[0] + " " + stage.split()[1] for stage in again} == {"full 1", "order-1 1"}
    assert "full 1 points" not in again
    assert "order-1 1 points" not in again
    assert [[run["seed"] for run in row["runs"]] for row in result["rows"]] == [[0, 1], [0, 1]]
    masks = [mask_file(run.folder.masks, 0) for run in ablation.runs()]
    assert all(file.samefile(masks[0]) for file in masks)


def test_scores_that_somebody_replaced_are_measured_again(make_ablation: MakeAblation, tmp_path: Path) -> None:
    ablation = make_ablation(tmp_path / "out", [])
    result = ablate(ablation, silent)
    file = tmp_path / "out" / "full" / "seed-0" / "eval.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"cameras": ["0"], "psnr": 99.0}))
    stages: list[str] = []
    assert ablate(ablation, lambda progress: stages.append(progress.stage)) == result
    assert set(stages) == {"full 0 evaluate"}


def test_given_masks_score_what_moves(make_ablation: MakeAblation, tmp_path: Path) -> None:
    for frame in range(4):
        mask = np.zeros((36, 48), np.uint8)
        mask[:, : 10 + frame] = 255
        save(mask, tmp_path / "masks" / "1" / f"{frame:04d}.png")
    ablation = make_ablation(tmp_path / "out", [], score_masks=tmp_path / "masks")
    result = ablate(ablation, silent)
    assert result["rows"][0]["mean"]["psnr_dynamic"] is not None
    assert result["score_masks"] == str((tmp_path / "masks").resolve())
    with pytest.raises(InputError, match="another truth or other masks"):
        ablate(make_ablation(tmp_path / "out", []), silent)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"seeds": ()}, "--seeds"),
        ({"seeds": (1, 1)}, "--seeds"),
        ({"config": CONFIG.changed({"capture.hold_out": []})}, "--hold-out"),
        ({"config": CONFIG.changed({"capture.hold_out": ["9"]})}, "9"),
        ({"truth": Path("/nowhere")}, "/nowhere"),
        ({"score_masks": Path("/nowhere")}, "/nowhere"),
        ({"capture": Path("/nowhere")}, "/nowhere"),
    ],
)
def test_what_would_stop_a_run_is_found_before_anything_is_written(
    make_ablation: MakeAblation, tmp_path: Path, change: dict[str, Any], problem: str
) -> None:
    with pytest.raises(InputError, match=problem):
        ablate(dataclasses.replace(make_ablation(tmp_path / "out"), **change), refuse)
    assert not (tmp_path / "out").exists()


def test_a_folder_with_other_files_is_not_touched(make_ablation: MakeAblation, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(InputError, match="is not an ablation"):
        ablate(make_ablation(tmp_path), refuse)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_damaged_result_says_what_to_do(make_ablation: MakeAblation, tmp_path: Path) -> None:
    (tmp_path / "ablation.json").write_text("{")
    with pytest.raises(InputError, match="made from the runs"):
        ablate(make_ablation(tmp_path), refuse)


def test_runs_of_another_config_are_not_mixed_in(everything: tuple[Ablation, Any]) -> None:
    ablation, _ = everything
    with pytest.raises(InputError, match="another capture or config"):
        ablate(dataclasses.replace(ablation, config=CONFIG.changed({"train.iterations": 6})), refuse)
