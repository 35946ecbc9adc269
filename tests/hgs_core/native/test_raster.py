"""The rasterizer's promises that a comparison with the reference does not show: bits, threads, processes, limits."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import threading
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.native import library
from hgs_core.native.raster import Raster
from hgs_core.native.structs import DYNAMIC_SHAPES, STATIC_SHAPES
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.tolerances import assert_close

Floats = npt.NDArray[np.float32]


def scene(statics: int = 300, dynamics: int = 200) -> tuple[StaticSplats[Any], DynamicSplats[Any]]:
    return (
        static_splats(statics).map(lambda a: a.numpy().astype(np.float32)),
        dynamic_splats(dynamics).map(lambda a: a.numpy().astype(np.float32)),
    )


def everything(threads: int, view: Camera) -> bytes:
    """Picture, gradients and statistics of one scene, as bytes."""
    static, dynamic = scene()
    raster = Raster(static, dynamic, view, 0.3, background=(0.1, 0.2, 0.3), threads=threads)
    r = np.random.default_rng(2)
    grad_rgb = r.normal(size=raster.rgb.shape).astype(np.float32)
    grad_alpha = r.normal(size=raster.alpha.shape).astype(np.float32)
    into_static = {name: np.empty_like(array) for name, array in static.items()}
    into_dynamic = {name: np.empty_like(array) for name, array in dynamic.items()}
    n = len(static) + len(dynamic)
    statistics = (np.zeros(n, np.float32), np.zeros(n, np.int32))
    raster.backward(grad_rgb, grad_alpha, into_static, into_dynamic, statistics)
    results = [raster.rgb, raster.alpha, *into_static.values(), *into_dynamic.values(), *statistics]
    return b"".join(array.tobytes() for array in results)


def test_same_bits_for_any_number_of_threads() -> None:
    view = camera(120, 88)
    assert len({everything(threads, view) for threads in (1, 2, 3, 7)}) == 1


def test_every_instruction_set_computes_the_same_function() -> None:
    code = (
        "import sys; from tests.hgs_core.native.test_raster import camera, everything\n"
        "sys.stdout.buffer.write(everything(2, camera(75, 41)))"
    )
    root = Path(__file__).parents[3]
    results = []
    for name in library.supported():
        environment = {**os.environ, "HGS_NATIVE_ISA": name, "PYTHONPATH": str(root)}
        run = subprocess.run([sys.executable, "-c", code], env=environment, cwd=root, capture_output=True, check=True)
        results.append(np.frombuffer(run.stdout, np.float32))
    for result in results[1:]:
        assert_close(result, results[0])


def test_same_bits_from_several_python_threads_at_once() -> None:
    views = [camera(120, 88), camera(75, 40), camera(40, 24)]
    alone = [everything(2, view) for view in views]
    together: list[bytes | None] = [None] * 9

    def work(i: int) -> None:
        together[i] = everything(2, views[i % 3])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(9)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone * 3


def test_a_forked_process_gets_threads_of_its_own() -> None:
    view = camera(64, 64)
    expected = everything(3, view)
    child = os.fork()
    if child == 0:
        os._exit(0 if everything(3, view) == expected else 1)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0


def test_the_caller_keeps_its_denormals() -> None:
    everything(2, camera())
    smallest = np.array([1e-42], np.float32)
    assert (smallest * np.float32(1.0))[0] != 0.0


def test_a_workspace_is_used_again_after_a_larger_picture() -> None:
    small = everything(2, camera(40, 24))
    everything(2, camera(200, 100))
    assert everything(2, camera(40, 24)) == small


def test_no_more_workspaces_are_kept_than_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    kept: deque[int] = deque()
    monkeypatch.setattr("hgs_core.native.raster._free_workspaces", kept)
    monkeypatch.setenv("HGS_THREADS", "2")
    drawn = [Raster(*scene(5, 5), camera(40, 24), threads=1) for _ in range(4)]
    for one in drawn:
        one.release()
    assert len(kept) == 2


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(("kind", "field"), [(0, f) for f in STATIC_SHAPES] + [(1, f) for f in DYNAMIC_SHAPES])
def test_what_is_not_finite_is_refused_and_nothing_of_it_stays(kind: int, field: str, value: float) -> None:
    sets = scene(50, 50)
    sets[1].time_centers[7], sets[1].opacity_logits[7] = 0.3, 4.0  # alive
    expected = Raster(*sets, camera(), 0.3, threads=2).rgb
    broken = [splats.map(np.copy) for splats in sets]
    getattr(broken[kind], field)[7] = value
    with pytest.raises(FloatingPointError, match="not finite"):
        Raster(broken[0], broken[1], camera(), 0.3, threads=2)
    np.testing.assert_array_equal(Raster(*sets, camera(), 0.3, threads=2).rgb, expected)


@pytest.mark.parametrize("field", [*STATIC_SHAPES])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_extreme_splat_harms_no_other(field: str, sign: int) -> None:
    static, _ = scene(50)
    extreme = static.map(np.copy)
    getattr(extreme, field)[7] = sign * (1e18 if field == "rgb" else 1e30)
    raster = Raster(extreme, None, camera(), threads=1)
    assert np.isfinite(raster.rgb).all()
    assert (raster.alpha >= 0).all()
    assert (raster.alpha <= 1).all()


def test_a_colour_beyond_the_limit_is_refused() -> None:
    sets = scene(50, 50)
    sets[1].time_centers[7], sets[1].opacity_logits[7] = 0.3, 4.0  # alive
    for splats in sets:
        splats.rgb[7, 2] = -1.0001e18
        with pytest.raises(FloatingPointError, match="beyond 1e18"):
            Raster(*sets, camera(), 0.3)
        splats.rgb[7, 2] = 0


def test_no_splats() -> None:
    view = camera()
    for static, dynamic in ((None, None), scene(0, 0)):
        raster = Raster(static, dynamic, view, background=(0.25, 0.5, 0.75))
        assert (raster.alpha == 0).all()
        assert (raster.rgb == np.array([0.25, 0.5, 0.75], np.float32)[:, None, None]).all()
        raster.backward(np.ones_like(raster.rgb), None, {}, {})


def test_more_tile_entries_than_can_be_counted_are_refused() -> None:
    count = 1 << 19
    view = dataclasses.replace(camera(), width=65535, height=16)  # 2^12 tiles
    static = StaticSplats(
        means=np.tile(np.array([0, 0, 1], np.float32), (count, 1)),
        log_scales=np.full((count, 3), 10, np.float32),
        quats=np.zeros((count, 4), np.float32),
        opacity_logits=np.zeros(count, np.float32),
        rgb=np.zeros((count, 3), np.float32),
    )
    with pytest.raises(RuntimeError, match="more than 2\\^31"):
        Raster(static, None, view)


def test_pictures_too_large_for_the_boxes_of_splats_are_refused() -> None:
    with pytest.raises(ValueError, match="65535 pixels"):
        Raster(None, None, dataclasses.replace(camera(), width=65536, height=1))


def test_drawing_again_gives_the_bits_of_a_new_rendering() -> None:
    static, dynamic = scene()
    for threads in (1, 3):
        raster = Raster(static, dynamic, camera(120, 88), 0.1, threads=threads, antialiased=True, keep_statics=True)
        for time, depth in ((0.3, False), (0.9, True)):
            raster.redraw(dynamic, time, depth)
            fresh = Raster(static, dynamic, camera(120, 88), time, threads=threads, antialiased=True, depth=depth)
            np.testing.assert_array_equal(raster.rgb, fresh.rgb)
            if depth:
                np.testing.assert_array_equal(raster.depth, fresh.depth)
            else:
                assert raster.depth is None
        raster.redraw(None, 0.0)
        np.testing.assert_array_equal(raster.rgb, Raster(static, None, camera(120, 88), antialiased=True).rgb)


def test_drawing_again_may_leave_out_other_tiles() -> None:
    static, dynamic = scene()
    r = np.random.default_rng(0)
    first, later = (r.uniform(size=(6, 8)) < 0.4 for _ in range(2))
    raster = Raster(static, dynamic, camera(120, 88), 0.1, tile_mask=first, keep_statics=True)
    fresh = Raster(static, dynamic, camera(120, 88), 0.1, tile_mask=first)
    assert_close(raster.rgb, fresh.rgb, "picture")
    gradient = r.normal(size=(3, 88, 120)).astype(np.float32)
    for mask in (later, None):
        fresh = Raster(static, dynamic, camera(120, 88), 0.6, tile_mask=mask)
        raster.redraw(dynamic, 0.6, tile_mask=mask)
        assert_close(raster.rgb, fresh.rgb, "picture")  # boxes that no mask has cut are summed in another order
        assert_close(raster.alpha, fresh.alpha, "picture")
        found = []
        for drawn in (raster, fresh):
            grads = {name: np.empty_like(array) for name, array in dynamic.items()}
            drawn.backward(gradient, None, None, grads)
            found.append(grads)
        for name in found[0]:
            assert_close(found[0][name], found[1][name], "gradients")


def test_statics_that_were_not_kept_are_not_drawn_again() -> None:
    static, dynamic = scene()
    raster = Raster(static, dynamic, camera(120, 88), 0.1)
    with pytest.raises(RuntimeError, match="not kept"):
        raster.redraw(dynamic, 0.2)


def test_contributions_add_up_to_the_coverage() -> None:
    raster = Raster(*scene(), camera(120, 88), 0.3)
    total, peak = raster.contributions()
    assert total.shape == peak.shape == (500,)
    np.testing.assert_allclose(total.sum(dtype=np.float64), raster.alpha.sum(dtype=np.float64), rtol=1e-5)
    assert (peak <= total).all()
    assert peak.max() < 1


def test_contributions_are_the_same_without_a_picture() -> None:
    static, dynamic = scene()
    opaque = dataclasses.replace(static, opacity_logits=np.full(len(static), 6, np.float32))  # lists end early
    drawn, listed = (
        Raster(opaque, dynamic, camera(120, 88), 0.1, keep_statics=True, draw=draw) for draw in (True, False)
    )
    assert np.array_equal(drawn.contributions(), listed.contributions())
    for raster, draw in ((drawn, True), (listed, False)):
        raster.redraw(dynamic, 0.3, draw=draw)
    assert np.array_equal(drawn.contributions(), listed.contributions())
    assert not hasattr(listed, "rgb")
    with pytest.raises(RuntimeError, match="drew nothing"):
        listed.backward(np.zeros((3, 88, 120), np.float32), None, None, None)


def test_a_rendering_that_drew_nothing_has_no_measurements() -> None:
    with pytest.raises(RuntimeError, match="drew nothing"):
        Raster(*scene(5, 5), camera(), draw=False).measurements()


def test_the_measurements_count_what_was_drawn() -> None:
    static, dynamic = scene()
    found = Raster(static, dynamic, camera(120, 88), 0.3).measurements()
    assert 0 < found.visible_static <= len(static)
    assert 0 < found.visible_dynamic < len(dynamic)
    assert found.tile_entries >= found.visible_static
    assert found.evaluations > found.tile_entries
    assert min(found.project, found.bin, found.composite) > 0
    assert found.composite_backward == 0


def test_a_mask_costs_as_much_as_what_it_names() -> None:
    """Though the lists are those of tiles of 32 x 32 pixels, of which a mask may name a quarter."""
    static, dynamic = scene()
    view = camera(32, 32)
    parts = [np.arange(4).reshape(2, 2) == i for i in range(4)]
    found = [Raster(static, dynamic, view, 0.3, tile_mask=mask).measurements() for mask in (None, *parts)]
    assert min(part.evaluations for part in found[1:]) > 0
    assert sum(part.evaluations for part in found[1:]) == found[0].evaluations


def test_refuses_arrays_it_would_misread() -> None:
    static, dynamic = scene(5, 5)
    with pytest.raises(ValueError, match="quats must be a contiguous float32 array of shape"):
        Raster(dataclasses.replace(static, quats=static.quats[:, :3]), None, camera())
    with pytest.raises(ValueError, match="motion must be"):
        Raster(None, dataclasses.replace(dynamic, motion=dynamic.motion.astype(np.float64)), camera())
    with pytest.raises(ValueError, match=r"motion must be .* of shape \(5, 4, 3\), got float32 \(5, 5, 3\)"):
        Raster(None, dataclasses.replace(dynamic, motion=np.zeros((5, 5, 3), np.float32)), camera())
    with pytest.raises(ValueError, match="tile_mask must be"):
        Raster(static, None, camera(40, 24), tile_mask=np.ones((2, 2), np.bool_))


def test_backward_after_release_is_refused() -> None:
    static, _ = scene(5)
    raster = Raster(static, None, camera())
    raster.release()
    with pytest.raises(RuntimeError, match="after release"):
        raster.backward(np.ones_like(raster.rgb), None, {}, None)


def test_row_shapes_name_every_field() -> None:
    assert [*STATIC_SHAPES] == [field.name for field in dataclasses.fields(StaticSplats)]
    assert [*DYNAMIC_SHAPES] == [field.name for field in dataclasses.fields(DynamicSplats)]
