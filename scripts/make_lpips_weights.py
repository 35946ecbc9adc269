"""The weights of LPIPS (AlexNet) as the file that `hgs eval --lpips` reads; run it where `pip install lpips` was run.

python scripts/make_lpips_weights.py alexnet.npz
"""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import numpy as np
import torch


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    network = importlib.import_module("lpips").LPIPS(net="alex")
    convolutions = [layer for layer in network.net.modules() if isinstance(layer, torch.nn.Conv2d)]
    arrays: dict[str, np.ndarray] = {}
    for i, (layer, linear) in enumerate(zip(convolutions, network.lins, strict=True)):
        arrays[f"AlexNet_0.Conv_{i}.kernel"] = layer.weight.detach().permute(2, 3, 1, 0).numpy()
        if layer.bias is not None:
            arrays[f"AlexNet_0.Conv_{i}.bias"] = layer.bias.detach().numpy()
        arrays[f"NetLinLayer_{i}.Conv_0.kernel"] = linear.model[-1].weight.detach().permute(2, 3, 1, 0).numpy()
    np.savez(options.out, **arrays)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
