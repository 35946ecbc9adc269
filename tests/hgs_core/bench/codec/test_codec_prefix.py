from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.bench.codec.codec_prefix import prefix_losses
from hgs_core.codec import EncodeSettings, encode_scene
from hgs_core.fit.encoding_loss import Loss
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.scene import HybridScene, Segment, StaticSplats
from tests.synthetic import ring_of_cameras, synthetic_scene


def test_a_quarter_of_the_bytes_shows_more_in_the_order_of_utility_than_in_any_other(tmp_path: Path) -> None:
    still, moving = synthetic_scene()
    rng = np.random.default_rng(0)
    fog = synthetic_scene(1)[0].map(lambda tensor: tensor.numpy())
    faint = StaticSplats(fog.means, fog.log_scales - 1.5, fog.quats, fog.opacity_logits - 3, fog.rgb)
    both = [
        np.concatenate(pair)
        for pair in zip((a.numpy() for _, a in still.items()), (a for _, a in faint.items()), strict=True)
    ]
    order = rng.permutation(len(both[0]))
    static = StaticSplats(*(array[order] for array in both))
    given = HybridScene(static, (Segment(0.0, 5 / 30, moving.map(lambda tensor: tensor.numpy())),))
    cameras, times = ring_of_cameras(4, 64, 48), np.arange(6) / 30
    utility = measure_utility(given, cameras, times)
    settings = EncodeSettings(static_chunk_splats=25, small_chunk_splats=10, prune=0)
    encode_scene(given, tmp_path, cameras=cameras, times=times, title="", settings=settings, utility=utility)
    views = EncodeViews("", tuple(cameras), dict(enumerate(cameras)), times, None)
    ordered, shuffled = prefix_losses(tmp_path, Loss(given, views, views.trained))
    assert 0 < ordered < shuffled - 1
