from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.soak import collector
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home


class EnoughError(BaseException):
    """The end of a collector that never rests."""


def test_young_chunks_go_and_faults_of_the_store_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    home = Home.at(tmp_path)
    chunk = tmp_path / "store" / "chunks" / ("0" * 64)
    chunk.parent.mkdir(parents=True)
    chunk.write_bytes(b"x")
    collect, rounds = collector.collect_chunks, iter([OSError("S3 hangs"), None])

    def failing_first(*arguments: object, **options: object) -> object:
        if (error := next(rounds, EnoughError())) is not None:
            raise error
        return collect(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(collector, "collect_chunks", failing_first)
    with pytest.raises(EnoughError):
        collector.collect_for_ever(home, pause=0.0)
    assert list(open_store(home).list_chunks()) == []
    assert "S3 hangs" in capsys.readouterr().err
