"""Every drawable set can be encoded: import and encoder keep to the same limits."""

from __future__ import annotations

import numpy as np

from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import prepare_static
from hgs_core.interchange.drawable import drawable
from hgs_core.scene.splat_limits import LARGEST_COLOUR, LARGEST_COORDINATE, LARGEST_LOG_SCALE
from tests.hgs_core.interchange.scenes import CAMERA, statics


def test_what_import_lets_through_the_encoder_takes() -> None:
    given = statics(60)
    given.opacity_logits[:] = 5.0
    given.means[:6, 0] = np.float32([LARGEST_COORDINATE, -LARGEST_COORDINATE, 1e29, 1.01e30, 3e38, -3e38])
    given.log_scales[6:9, 0] = [LARGEST_LOG_SCALE, 1e3, -1e3]
    given.rgb[9:12, 0] = [LARGEST_COLOUR, 99, -99]
    static, _, _ = drawable(given, [])
    assert len(static) == 55  # float32 has no 1e30, but something larger
    assert np.abs(static.log_scales).max() == LARGEST_LOG_SCALE
    assert len(prepare_static(static, [CAMERA], None, EncodeSettings())) == len(static)
