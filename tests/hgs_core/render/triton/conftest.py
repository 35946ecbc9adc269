"""These tests run on the CUDA device if there is one, else in Triton's interpreter."""

from __future__ import annotations

from tests.hgs_core.render.comparison import BACKENDS
from tests.interpreted_triton import INSTALLED, prepare

if INSTALLED:
    prepare()
    from hgs_core.render.triton.rasterize import rasterize_triton

    BACKENDS["triton"] = rasterize_triton
else:
    collect_ignore_glob = ["test_[!d]*.py"]  # all but test_device.py
