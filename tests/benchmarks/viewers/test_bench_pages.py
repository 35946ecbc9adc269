"""The bench's page: its address, and the errors of its build."""

from __future__ import annotations

import urllib.request
from pathlib import Path

import pytest

from benchmarks.viewers.bench_pages import build_pages, served
from hgs_core.base.errors import InputError


def test_pages_are_served_so_that_viewers_may_share_memory(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("here")
    with served(tmp_path) as address, urllib.request.urlopen(address) as answer:
        assert answer.read() == b"here"
        assert answer.headers["Cross-Origin-Opener-Policy"] == "same-origin"
        assert answer.headers["Cross-Origin-Embedder-Policy"] == "require-corp"


def test_without_a_checkout_the_cure_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="run it from a checkout"):
        build_pages(tmp_path / "out", tmp_path)


def test_a_build_that_fails_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "bench" / "viewers"
    (folder / "node_modules").mkdir(parents=True)
    (tmp_path / "node_modules").mkdir()
    (folder / "package.json").write_text("{}")
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("npm", "npx"):
        (programs / name).write_text("#!/bin/sh\necho 'no such plugin' >&2\nexit 1\n")
        (programs / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    with pytest.raises(InputError, match="npx vite build failed: no such plugin"):
        build_pages(tmp_path / "out", tmp_path)
