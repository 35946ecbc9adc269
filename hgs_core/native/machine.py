"""The machine of a measurement."""

from __future__ import annotations

import os
import platform
from pathlib import Path

import numpy as np
import torch

from hgs_core.base.version import software_version
from hgs_core.native import library

__all__ = ["machine_facts"]


def machine_facts() -> dict[str, str | int | float | None]:
    """Return the facts for comparing figures: processor, cores, its load, kernels and versions."""
    return {
        "cpu": _cpu_model(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load": round(os.getloadavg()[0], 2),  # processes that wanted to run, the mean of the last minute
        "system": f"{platform.system()} {platform.machine()}",
        "instruction_set": library.instruction_set(),
        "python": platform.python_version(),
        "torch": torch.__version__,
        "numpy": np.__version__,
        "hgs": software_version(),
    }


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown"
