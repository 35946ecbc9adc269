from __future__ import annotations

from typing import Any

from hgs_core.ablate.ablation_table import table_text
from hgs_core.ablate.summary import FIGURES, summarise


def scores(**some: float | None) -> dict[str, Any]:
    """The eval.json of one run."""
    return dict.fromkeys(FIGURES, 1.0) | some


def test_the_table_has_a_line_for_every_row_and_says_what_its_marks_mean() -> None:
    figures = {0: scores(psnr=20.0, bytes_static=1_234_567), 1: scores(psnr=21.0, bytes_static=1_234_567)}
    near = {0: scores(psnr=20.3, psnr_dynamic=None), 1: scores(psnr=21.3, psnr_dynamic=None)}
    rows = [{**vars(row), "moving": 0.25} for row in summarise({"full": figures, "order-1": near})]
    head, _, full, order, _, note = table_text({"rows": rows}).splitlines()
    titles, *lines = ([cell.strip() for cell in line.strip("|").split("|")] for line in (head, full, order))
    first, second = (dict(zip(titles, line, strict=True)) for line in lines)
    assert (first["row"], first["seeds"], first["moving"], first["to full"]) == ("full", "0,1", "25.0%", "-")
    assert (first["PSNR"], first["MB static"]) == ("20.50 ±0.71", "1.235 ±0.000")
    assert (second["to full"], second["PSNR of what moves"]) == ("+0.30*", "-")
    assert note.startswith("*")


def test_figures_stand_under_their_titles_in_markdown() -> None:
    (full,) = summarise({"full": {0: scores(splats_static=1234.0)}})
    head, rule, row = table_text({"rows": [{**vars(full), "moving": 1.0}]}).splitlines()
    bars = [[i for i, letter in enumerate(line) if letter == "|"] for line in (head, rule, row)]
    assert bars[0] == bars[1] == bars[2]
    cells = [cell.strip() for cell in rule.strip("|").split("|")]
    assert [cell.endswith(":") for cell in cells] == [False] + [True] * (len(cells) - 1)  # names left, figures right
    assert "1,234" in row
