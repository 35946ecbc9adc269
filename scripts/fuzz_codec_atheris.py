"""Let atheris (libFuzzer) look for chunks that the decoder does not refuse as it must, led by the code they reach.

    pip install atheris
    .venv/bin/python scripts/fuzz_codec_atheris.py -max_total_time=600 CORPUS

CORPUS is a folder that libFuzzer fills; the chunks of tests/vectors are its seeds. Length and checksum of every input
are made right first, so that the fault behind them is met. atheris needs Clang's libFuzzer; HGS does not install it.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path
from types import FunctionType

try:
    import atheris
except ImportError:
    sys.exit("fuzz_codec_atheris.py: atheris is not installed; pip install atheris, or use scripts/fuzz_codec.py")

from fuzz_codec import HEADER, LENGTH_AT, VECTORS, sealed, try_decoder


def one_input(data: bytes) -> None:
    if len(data) >= HEADER + 4:
        changed = bytearray(data)
        struct.pack_into("<I", changed, LENGTH_AT, len(changed))
        data = sealed(bytes(changed))
    try_decoder(data)


def instrument(package: str) -> None:
    """Instrument every function of an imported package for coverage.

    `atheris.instrument_imports` does not: its counters stay at zero where a package is installed in editable mode.
    """
    for name, module in list(sys.modules.items()):
        if not f"{name}.".startswith(f"{package}."):
            continue
        owners = [module, *(item for item in vars(module).values() if isinstance(item, type))]
        functions = [item for owner in owners for item in vars(owner).values() if isinstance(item, FunctionType)]
        for function in functions:
            if function.__module__ == name:
                atheris.instrument_func(function)


def main() -> None:
    folders = [Path(argument) for argument in sys.argv[1:] if not argument.startswith("-")]
    for folder in folders[:1]:
        folder.mkdir(parents=True, exist_ok=True)
        for seed in VECTORS.glob("*.chunk"):
            (folder / seed.name).write_bytes(seed.read_bytes())
    instrument("hgs_core.codec")
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
