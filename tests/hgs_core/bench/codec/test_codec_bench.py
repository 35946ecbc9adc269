"""Measurements of a small still cloud, and refused sources."""

from __future__ import annotations

import dataclasses
import gzip
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, silent
from hgs_core.bench.codec import codec_bench as codec
from hgs_core.bench.codec.codec_bench import CodecReport, bench_codec
from hgs_core.codec import EncodeSettings, SetUtility, Utility
from hgs_core.fit.coarseness import Fitted
from hgs_core.fit.encoding_loss import Decibels
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.interchange import export_scene
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from tests.synthetic import ring_of_cameras, write_capture

HEARD: list[Progress] = []
SEEN_BY = tuple(ring_of_cameras(3, 64, 48))
VIEWS = EncodeViews("", SEEN_BY, dict(enumerate(SEEN_BY)), np.zeros(1), None)


def found_in_no_time(scene: HybridScene[np.ndarray], views: object, utility: Utility, name: str, *_: object) -> Fitted:
    """Stands for the search: half of the splats, at a coarseness of 2."""
    half = SetUtility(utility.static.shown[:100], utility.static.missed[:100])
    fewer = dataclasses.replace(scene, static=scene.static.take(slice(100)))
    return Fitted(fewer, Utility(half, utility.dynamic), EncodeSettings(coarseness=2.0, prune=0.0), Decibels(0.0, None))


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> CodecReport:
    rng = np.random.default_rng(0)
    means, scales, quats, logits, rgb = (
        rng.normal(mean, deviation, shape).astype(np.float32)
        for mean, deviation, shape in (
            (0, 1, (200, 3)),
            (-2.5, 0.3, (200, 3)),
            (0, 1, (200, 4)),
            (1, 1, 200),
            (0.5, 0.1, (200, 3)),
        )
    )
    scene = HybridScene(StaticSplats(means, scales, quats, logits, rgb), (Segment(0.0, 0.0, DynamicSplats.empty()),))
    path = tmp_path_factory.mktemp("codec") / "cloud.ply"
    export_scene(scene, path, cameras=[])
    with pytest.MonkeyPatch.context() as patch:  # the search for a coarseness has tests of its own
        patch.setattr(codec, "views_around", lambda *_: VIEWS)
        patch.setattr(codec, "fit", lambda *given, **more: found_in_no_time(*given))
        return bench_codec(path, HEARD.append, budgets=("low",), sweep=(0.5, 4.0))


def test_coarser_encodings_have_fewer_bytes_and_lose_more(report: CodecReport) -> None:
    fine, coarse = report.sweep
    assert [point.coarseness for point in report.sweep] == [0.5, 4.0]
    assert fine.bytes_static > coarse.bytes_static
    assert fine.loss < coarse.loss
    assert (fine.name, fine.bytes_dynamic, fine.loss_held_out) == ("", 0, None)


def test_a_budget_is_named_and_encodes_what_the_search_found(report: CodecReport) -> None:
    (budget,) = report.budgets
    assert (budget.name, budget.coarseness, budget.splats_static, report.splats_static) == ("low", 2.0, 100, 200)
    assert (report.source, report.splats_dynamic) == ("cloud.ply", 0)


def test_other_formats_have_the_same_splats(report: CodecReport) -> None:
    """An uncompressed SPZ has 16 bytes and 19 or 20 a splat, random bits of which no gzip saves much."""
    assert set(report.bytes_spz) == {"spz 2", "spz 3", "spz 4"}
    for version, size in ((2, 19), (3, 20)):
        raw = 16 + 200 * size
        assert 0.7 * raw < report.bytes_spz[f"spz {version}"] < raw + len(gzip.compress(b""))
    assert set(report.errors) == {"spz 2", "spz 3", "spz 4", "low"}
    assert report.bytes_splatv > 1024 * 64  # rows of 1,024 splats of 64 bytes


def test_a_part_of_the_bytes_loses_less_in_order_than_all_that_is_missing_otherwise(report: CodecReport) -> None:
    assert report.prefix_loss > 0
    assert set(report.decode_rates) == {"static"}
    assert report.decode_rates["static"] > 0


def test_progress_counts_measuring_encoding_and_comparing(report: CodecReport) -> None:
    assert [(one.done, one.total) for one in HEARD] == [(n, 5) for n in range(1, 6)]
    assert {one.stage for one in HEARD} == {"codec"}


def test_a_source_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a run"):
        bench_codec(tmp_path / "nothing", silent, budgets=())
    write_capture(tmp_path / "capture", cameras=2, frames=1, width=16, height=12)
    create_run(tmp_path / "run", tmp_path / "capture", RunConfig.for_preset("preview"))
    with pytest.raises(InputError, match="run: is not trained yet; finish it with hgs train"):
        bench_codec(tmp_path / "run", silent, budgets=())
