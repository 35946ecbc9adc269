"""These tests run on the CUDA device if there is one, else in Triton's interpreter."""

from __future__ import annotations

from tests.interpreted_triton import INSTALLED, prepare

if INSTALLED:
    prepare()
else:
    collect_ignore_glob = ["test_*.py"]
