from __future__ import annotations

import json
from pathlib import Path

from hgs_core.base.progress import silent
from hgs_core.evaluate.run import evaluate_run
from hgs_core.evaluate.score_table import SCORE_COLUMNS, score_lines
from hgs_core.runs.run_folder import RunFolder


def test_every_column_is_a_field_of_eval_json(finished: Path) -> None:
    evaluate_run(finished, silent, cameras=["2"])
    assert set(SCORE_COLUMNS) < set(json.loads(RunFolder(finished).evaluation.read_text()))


def test_a_line_has_the_column_and_the_value_or_a_dash() -> None:
    lines = score_lines({"psnr": 27.5, "lpips": None, "cameras": ["a", "b"], "magnified": {"2": 30.0}})
    values = [line.split(maxsplit=1) for line in lines]
    assert values == [["psnr", "27.5000"], ["lpips", "-"], ["cameras", "a, b"], ["magnified", "2 30.0000"]]
