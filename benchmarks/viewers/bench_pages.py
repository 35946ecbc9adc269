"""The bench's page with our viewer and others in it: built from web_client/bench/viewers, served on this machine."""

from __future__ import annotations

import functools
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["build_pages", "served"]

WEB_CLIENT = Path(__file__).resolve().parents[2] / "web_client"


def build_pages(out: Path, web_client: Path = WEB_CLIENT) -> None:
    """Install the other viewers where that is not done, and build the page into `out`.

    Raises:
        InputError: there is no checkout to build from, or npm or the build fails; it says which.
    """
    folder = web_client / "bench" / "viewers"
    if not (folder / "package.json").is_file():
        raise InputError("benchmarks.viewers", f"{folder} is not there", "run it from a checkout of HGS")
    if shutil.which("npm") is None:
        raise InputError("benchmarks.viewers", "needs npm", "install Node 20 or newer, or run scripts/install")
    if not (web_client / "node_modules").is_dir():
        _run(["npm", "ci", "--no-audit", "--no-fund", "--loglevel=error"], web_client)
    if not (folder / "node_modules").is_dir():
        _run(["npm", "ci", "--no-audit", "--no-fund", "--loglevel=error"], folder)
    vite = ["npx", "vite", "build", "--config", str(folder / "vite.config.ts"), "--logLevel", "error"]
    _run([*vite, "--outDir", str(out), "--emptyOutDir"], web_client)


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        reason = (done.stderr or done.stdout).strip().splitlines()
        raise InputError(folder, f"{' '.join(command[:3])} failed: {reason[-1] if reason else done.returncode}")


class _Files(SimpleHTTPRequestHandler):
    """Files that may share memory between threads, as some of the viewers want to."""

    def end_headers(self) -> None:
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        self.send_header("Cache-Control", "no-store")
        super().end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on the loopback interface; yields its address, with a slash at the end."""
    httpd = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Files, directory=str(folder)))
    thread = threading.Thread(target=httpd.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{httpd.server_address[1]}/"
    finally:
        httpd.shutdown()
        httpd.server_close()
        thread.join()
