"""SAM 2 with a tiny model of random weights: its answers are noise, but all calls of real weights are made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.decompose.sam import Sam2Refiner, _merged


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    transformers = pytest.importorskip("transformers", reason="the extra sam (transformers) is not installed")
    import torch
    from transformers.models.sam2.configuration_sam2 import Sam2HieraDetConfig, Sam2VisionConfig

    torch.manual_seed(0)
    size, width = 128, 128
    backbone = Sam2HieraDetConfig(
        hidden_size=8,
        num_attention_heads=1,
        image_size=[size, size],
        blocks_per_stage=[1, 1, 2, 1],
        embed_dim_per_stage=[8, 16, 32, 64],
        num_attention_heads_per_stage=[1, 1, 1, 1],
        window_size_per_stage=[4, 2, 4, 2],
        global_attention_blocks=[3],
        window_positional_embedding_background_size=[2, 2],
    )
    vision = Sam2VisionConfig(
        backbone_config=backbone,
        backbone_channel_list=[64, 32, 16, 8],
        fpn_hidden_size=width,
        backbone_feature_sizes=[[size // 4] * 2, [size // 8] * 2, [size // 16] * 2],
    )
    config = transformers.Sam2VideoConfig(
        vision_config=vision,
        prompt_encoder_config={"hidden_size": width, "image_size": size},
        mask_decoder_config={"hidden_size": width, "mlp_dim": 32, "num_attention_heads": 2, "iou_head_hidden_dim": 32},
        image_size=size,
        memory_attention_hidden_size=width,
        memory_attention_num_layers=1,
        memory_attention_feed_forward_hidden_size=32,
        memory_attention_rope_feat_sizes=[size // 16] * 2,
        memory_encoder_hidden_size=width,
        memory_encoder_output_channels=64,
        mask_downsampler_embed_dim=width,
        memory_fuser_embed_dim=width,
        memory_fuser_intermediate_dim=32,
    )
    folder = tmp_path_factory.mktemp("sam2")
    transformers.Sam2VideoModel(config).save_pretrained(folder)
    return folder


def test_a_video_is_refined_window_by_window(weights: Path) -> None:
    pictures = list(np.random.default_rng(0).integers(0, 255, (19, 48, 64, 3)).astype(np.uint8))
    masks = []
    for frame in range(19):
        mask = np.zeros((48, 64), bool)
        mask[10:30, frame : frame + 16] = True
        masks.append(mask)
    refiner = Sam2Refiner(weights)
    objects = refiner._objects(pictures[:16], masks[:16])
    assert [len(found) for found in objects] == [1] * 16
    assert objects[0][0].shape == (48, 64)
    refined = refiner.refine(pictures, masks)
    assert [mask.shape for mask in refined] == [(48, 64)] * 19
    assert refined[0].dtype == np.bool_


def test_where_nothing_moves_the_model_is_not_asked(weights: Path) -> None:
    still = [np.zeros((48, 64), bool)] * 3
    refined = Sam2Refiner(weights).refine([np.zeros((48, 64, 3), np.uint8)] * 3, still)
    assert not any(mask.any() for mask in refined)


def test_folders_without_weights_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("transformers", reason="the extra sam (transformers) is not installed")
    with pytest.raises(InputError, match="does not exist"):
        Sam2Refiner(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"no config\.json"):
        Sam2Refiner(tmp_path)
    (tmp_path / "config.json").write_text("{}")
    with pytest.raises(InputError, match="holds no SAM 2 weights"):
        Sam2Refiner(tmp_path)


def test_an_object_gives_the_mask_its_border_and_leaves_the_shadow() -> None:
    mask = np.zeros((40, 60), bool)
    mask[8:32, 8:32] = True  # an object with a ragged margin
    mask[20:30, 45:58] = True  # its shadow, apart from it
    found = np.zeros_like(mask)
    found[10:30, 10:30] = True
    wall = np.zeros_like(mask)
    wall[:, 40:] = True  # mostly still: not believed
    merged = _merged(mask, [found, wall])
    assert merged[10:30, 10:30].all()
    assert not merged[8:10, 8:32].any()
    np.testing.assert_array_equal(merged[:, 40:], mask[:, 40:])
