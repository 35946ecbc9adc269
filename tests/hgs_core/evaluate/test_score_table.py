from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hgs_core.base.progress import silent
from hgs_core.evaluate.run import evaluate_run
from hgs_core.evaluate.score_table import SCORE_COLUMNS, score_lines
from hgs_core.runs.run_folder import RunFolder


def test_every_column_is_a_field_of_eval_json(finished: Path) -> None:
    evaluate_run(finished, silent, cameras=["2"])
    assert set(SCORE_COLUMNS) < set(json.loads(RunFolder(finished).evaluation.read_text()))


def test_moving_pixels_stand_beside_the_whole_and_raw_scores_first() -> None:
    lines = printed(psnr=27.5, psnr_dynamic=25.0, psnr_rig=28.5, psnr_dynamic_rig=26.0, lens_falloff=[-0.1, 0.0])
    assert lines[:2] == ["whole moving", "psnr 27.5000 25.0000"]
    assert lines.index("psnr_rig 28.5000 26.0000") > lines.index("lpips - -")


def test_a_run_that_learned_no_lens_has_one_line_of_words_for_the_rig() -> None:
    lines = [line for line in printed(psnr=27.5, psnr_rig=27.5, ssim_rig=0.9, lens_falloff=None) if "_rig" in line]
    assert lines == ["psnr_rig, ssim_rig, lpips_rig as above: the training learned no lens falloff"]


def test_lpips_is_printed_with_its_network() -> None:
    lines = printed(lpips=0.25, lpips_rig=0.125, lpips_network="AlexNet", lens_falloff=[0.0, 0.0])
    assert {"lpips (AlexNet) 0.2500 -", "lpips_rig (AlexNet) 0.1250 -"} < set(lines)


def test_lists_and_tables_are_written_in_words() -> None:
    lines = printed(cameras=["a", "b"], magnified={"2": 30.0}, cameras_trained_on=[])
    assert {"cameras a, b", "magnified 2 30.0000", "cameras_trained_on -"} < set(lines)


def printed(**scores: Any) -> list[str]:
    """Return the lines of a table that lacks all other scores, with single blanks."""
    return [" ".join(line.split()) for line in score_lines({**dict.fromkeys(SCORE_COLUMNS), **scores})]
