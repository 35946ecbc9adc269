"""Sums over slots against numpy's; the gradients are compared in test_rasterize.py."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.render.triton.differentiate import reduced
from tests.interpreted_triton import DEVICE
from tests.tolerances import assert_close

COUNTS = (3, 0, 40, 1, 17, 0)  # slots of each row: none, fewer and more than a program reads at a time


@pytest.mark.parametrize(("width", "maxima"), [(10, 0), (2, 1)])
def test_slots_are_summed_by_row(width: int, maxima: int) -> None:
    slots = np.random.default_rng(0).uniform(size=(sum(COUNTS), width)).astype(np.float32)
    first = np.cumsum((0, *COUNTS[:-1]))
    totals = (
        reduced(
            torch.from_numpy(slots).to(DEVICE),
            torch.from_numpy(first).to(DEVICE),
            torch.tensor(COUNTS, dtype=torch.int32, device=DEVICE),
            maxima,
        )
        .cpu()
        .numpy()
    )
    rows = [slots[start : start + count].astype(np.float64) for start, count in zip(first, COUNTS, strict=True)]
    sums = np.array([row.sum(0) for row in rows])
    assert_close(totals[:, : width - maxima], sums[:, : width - maxima])
    peaks = np.array([row.max(0, initial=0.0) for row in rows])
    assert_close(totals[:, width - maxima :], peaks[:, width - maxima :])


def test_no_rows_have_no_sums() -> None:
    none = torch.zeros(0, dtype=torch.int64, device=DEVICE)
    assert reduced(torch.zeros((0, 10), device=DEVICE), none, none.int()).shape == (0, 10)
