"""Compiles every kernel that the backend launches for real GPUs, without one: python -m ... TARGET[,TARGET].

The backend's own Python runs on CPU tensors; in place of a launch, the kernel is compiled for the types and options of
that launch. Nothing is computed, so counting is made to find one tile per splat.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import os
import sys
from typing import Any

import torch
import triton
from triton.backends.compiler import GPUTarget
from triton.compiler import ASTSource
from triton.runtime.jit import JITFunction, mangle_type

from hgs_core.render.triton.contribution import contributions_triton
from hgs_core.render.triton.rasterize import rasterize_triton
from hgs_core.render.types import Gradients, ScreenStatistics, View
from hgs_core.scene.camera import Camera
from hgs_core.train.triton.loss import l1_dssim
from hgs_core.train.triton.rmsprop import rmsprop_step
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

OPTIONS = ("num_warps", "num_stages", "enable_fp_fusion")


def compiled(kernel: JITFunction[Any], capabilities: list[int], args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
    """Compile one launch and print its name and how large it has become; once per distinct launch."""
    options = {name: kwargs.pop(name) for name in OPTIONS if name in kwargs}
    bound = inspect.signature(kernel.fn).bind(*args, **kwargs).arguments
    signature, constants = {}, {}
    for parameter in kernel.params:
        value = bound[parameter.name]
        if parameter.is_constexpr or value is None:
            signature[parameter.name], constants[parameter.name] = "constexpr", value
        else:
            signature[parameter.name] = mangle_type(value)
    for capability in capabilities:
        launch = json.dumps([kernel.__name__, capability, signature, constants, options], default=str)
        if launch in DONE:
            continue
        DONE.add(launch)
        source = ASTSource(fn=kernel, signature=signature, constexprs=constants)
        binary = triton.compile(source, target=GPUTarget("cuda", capability, 32), options=options).asm["cubin"]
        print(json.dumps({"kernel": kernel.__name__, "capability": capability, "bytes": len(binary)}))


DONE: set[str] = set()


def compile_launches(capabilities: list[int]) -> None:
    """From here on, compile where a kernel would be launched."""

    def launch(self: JITFunction[Any], *args: Any, grid: Any, warmup: bool, **kwargs: Any) -> None:
        named = inspect.signature(self.fn).bind_partial(*args).arguments
        compiled(self, capabilities, args, dict(kwargs))
        if self.__name__ == "count_tiles":
            named["counts"].fill_(1)
            named["tally"][1:] = torch.tensor([named["statics"], named["count"] - named["statics"]])

    JITFunction.run = launch
    os.environ["TRITON_INTERPRET"] = "1"  # CPU tensors are taken then; the kernels are there already


def render(over: Camera, coefficients: int = 4, **options: Any) -> None:
    """Go through all of rendering and its derivative, both sets, and contributions."""
    sets: tuple[Gradients, ...] = ("all", "static", "dynamic", "none")
    for gradients in sets:
        static = static_splats(8, dtype=torch.float32).map(torch.Tensor.requires_grad_)
        dynamic = dynamic_splats(8, dtype=torch.float32, coefficients=coefficients).map(torch.Tensor.requires_grad_)
        view = View(over, 0.4, gradients=gradients, statistics=ScreenStatistics.zeros(16), **options)
        picture = rasterize_triton(static, dynamic, view)
        if gradients != "none":
            sum(image.sum() for image in picture if image is not None).backward()
    contributions_triton(static, dynamic, dataclasses.replace(view, statistics=None))


def learn() -> None:
    """Loss and optimiser."""
    l1_dssim(torch.zeros(3, 20, 24), torch.zeros(3, 20, 24), 0.2)
    arrays = [torch.zeros(9, 3) for _ in range(3)]
    for factors, rows, decays in ((None, None, None), (torch.ones(9), torch.arange(9), torch.ones(9))):
        rmsprop_step(*arrays, 0.01, 0.001, beta=0.999, epsilon=1e-15, factors=factors, rows=rows, decays=decays)


if __name__ == "__main__":
    compile_launches([int(text) for text in sys.argv[1].split(",")])
    torch.set_num_threads(1)
    learn()
    tiles = (2, 3)
    render(camera(40, 24))
    render(camera(40, 24), depth=True, antialiased=True, tile_mask=torch.ones(tiles, dtype=torch.bool).numpy())
    render(camera(40, 24), coefficients=6)
    render(camera(4000, 4000))  # its tiles need 32 bits
