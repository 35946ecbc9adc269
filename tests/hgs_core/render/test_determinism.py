"""The compiled backend gives the same bits for any number of threads, and every time."""

from __future__ import annotations

import pytest
import torch

from hgs_core.native import library
from hgs_core.render import FixedView, contributions
from hgs_core.render.types import View
from tests.hgs_core.render.comparison import differentiate
from tests.hgs_core.render.hard_cases import CASES
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

pytestmark = pytest.mark.skipif(not library.instruction_set(), reason="hgs was built without its C++ kernels")


def bits_of(view: View) -> bytes:
    """Pictures, gradients, statistics, contributions and a frame of a fixed view."""
    static, dynamic = static_splats(600, dtype=torch.float32), dynamic_splats(400, dtype=torch.float32)
    result = differentiate("cpu", torch.float32, static, dynamic, view)
    weighed = contributions(static, dynamic, view.camera, view.time, backend="cpu", antialiased=view.antialiased)
    fixed = FixedView(static, view.camera, antialiased=view.antialiased, backend="cpu")
    fixed.frame(dynamic, 0.9)
    frame = fixed.frame(dynamic, view.time)
    tensors = (*result.pictures().values(), *result.gradients().values(), frame.rgb, frame.alpha)
    arrays = (*(t.numpy() for t in tensors), result.statistics.pull_sum, result.statistics.count, *weighed)
    return b"".join(array.tobytes() for array in arrays)


@pytest.mark.parametrize("antialiased", [False, True])
def test_any_number_of_threads_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch, antialiased: bool) -> None:
    view = View(camera(120, 88), 0.4, antialiased=antialiased, depth=True)
    results = set()
    for threads in (1, 2, 3, 7, 2):
        monkeypatch.setenv("HGS_THREADS", str(threads))
        results.add(bits_of(view))
    assert len(results) == 1


@pytest.mark.parametrize("name", ["everything_at_once", "equal_depths", "ten_thousand_layers"])
def test_hard_scenes_give_the_same_bits(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    results = set()
    for threads in (1, 2, 3, 7, 2):
        monkeypatch.setenv("HGS_THREADS", str(threads))
        case = CASES[name]()
        result = differentiate("cpu", torch.float32, case.static, case.dynamic, case.view)
        tensors = (*result.pictures().values(), *result.gradients().values())
        results.add(b"".join(tensor.numpy().tobytes() for tensor in tensors))
    assert len(results) == 1
