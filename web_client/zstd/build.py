"""Compile zstd.wasm, the viewer's decompressor, from the released source of zstd.

    python web_client/zstd/build.py           # writes zstd.wasm and zstd's LICENSE beside this file
    python web_client/zstd/build.py --check   # fails unless they are what the source gives

Source and compiler come from PyPI in pinned versions: zstandard carries zstd 1.5.7 in one file, ziglang is clang with
the headers of a C library; wasm-opt comes from npm. The result is kept in the repository: building the viewer needs no
compiler of 100 MB.
"""

import argparse
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
ZSTD = "zstandard==0.25.0 --hash=sha256:7713e1179d162cf5c7906da876ec2ccb9c3a9dcbdffef0cc7f70c3667a205f0b"
ZIG = "ziglang==0.17.1"
BINARYEN = "binaryen@132.0.0"

# Left out is what makes large frames faster. Chunks have small ones, and decode no slower (`npm run bench`).
SMALL = [
    "-Oz",
    "-flto",
    "-DHUF_FORCE_DECOMPRESS_X1",
    "-DZSTD_FORCE_DECOMPRESS_SEQUENCES_SHORT",
    "-DZSTD_NO_INLINE",
    "-DZSTD_STRIP_ERROR_STRINGS",
]
TARGET = ["--target=wasm32-wasi", "-mbulk-memory", "-nostdlib"]
LINK = ["--no-entry", "--gc-sections", "--strip-all", "-z", "stack-size=65536", "--export=__heap_base"]


def download(requirement: str, folder: Path, *options: str) -> Path:
    """The archive of a package."""
    requirements = folder / "requirements.txt"
    requirements.write_text(requirement)
    before = set(folder.iterdir())
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q", "download", "--no-deps", *options]
    subprocess.run([*pip, "-r", requirements, "-d", folder], check=True)
    (archive,) = set(folder.iterdir()) - before
    return archive


def build(folder: Path) -> dict[str, bytes]:
    """The files that belong beside this one, made in an empty folder."""
    with tarfile.open(download(ZSTD, folder, "--no-binary", "zstandard")) as archive:
        archive.extractall(folder, filter="data")
    with zipfile.ZipFile(download(ZIG, folder)) as archive:
        archive.extractall(folder)
    zig = folder / "ziglang" / "zig"
    zig.chmod(0o755)
    (source,) = folder.glob("zstandard-*/zstd")
    headers = [folder / "ziglang" / "lib" / "libc" / "include" / name for name in ("wasm-wasi-musl", "generic-musl")]
    included = [f"-I{source}", *(f"-isystem{path}" for path in headers)]
    options = [*TARGET, *SMALL, "-DNDEBUG", "-DZSTD_DISABLE_ASM=1", "-w", f"-Wl,{','.join(LINK)}"]
    command = [str(zig), "cc", *options, *included, str(HERE / "decoder.c"), "-o", str(folder / "zstd.wasm")]
    subprocess.run(command, check=True)
    wasm_opt = ["npx", "--yes", f"--package={BINARYEN}", "wasm-opt", "-O3", "--enable-bulk-memory", "--enable-sign-ext"]
    subprocess.run([*wasm_opt, "zstd.wasm", "-o", "zstd.wasm"], cwd=folder, check=True)
    return {"zstd.wasm": (folder / "zstd.wasm").read_bytes(), "LICENSE": (source / "LICENSE").read_bytes()}


def main() -> None:
    """Build, and write or compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail unless the files are up to date")
    check = parser.parse_args().check
    with tempfile.TemporaryDirectory() as folder:
        files = build(Path(folder))
    for name, content in files.items():
        if not check:
            (HERE / name).write_bytes(content)
        elif (HERE / name).read_bytes() != content:
            sys.exit(
                f"{HERE / name} is not what {ZSTD.split()[0]}, {ZIG} and {BINARYEN} make of decoder.c: run build.py"
            )


if __name__ == "__main__":
    main()
