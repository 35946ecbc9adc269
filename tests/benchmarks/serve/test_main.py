from __future__ import annotations

import json
from typing import Any

import pytest

from benchmarks.serve import __main__ as program


def test_server_is_measured(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    async def bench(viewers: int, seconds: float, **options: Any) -> dict[str, Any]:
        return {"viewers": viewers, "seconds": seconds} | options

    monkeypatch.setattr(program, "bench_serve", bench)
    monkeypatch.setattr(program, "serve_text", str)
    assert program.main(["--viewers", "3", "--seconds", "2", "--processes", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "viewers": 3,
        "seconds": 2.0,
        "folder": None,
        "minutes": 1.0,
        "processes": 2,
        "bad_clients": False,
    }


@pytest.mark.parametrize("option", ["--viewers", "--processes", "--minutes", "--seconds"])
def test_bad_arguments_are_named(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main([option, "0"]) == 2
    assert option in capsys.readouterr().err
