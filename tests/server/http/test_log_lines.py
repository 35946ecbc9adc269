from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from typing import Any

import pytest

from server.http.log_lines import RepeatFilter


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def log() -> Iterator[tuple[logging.Logger, io.StringIO, Clock]]:
    clock, written = Clock(), io.StringIO()
    handler = logging.StreamHandler(written)
    handler.addFilter(RepeatFilter(clock))
    logger = logging.getLogger("test.repeats")
    logger.propagate = False
    logger.addHandler(handler)
    yield logger, written, clock
    logger.removeHandler(handler)


def lines(written: io.StringIO) -> list[str]:
    return written.getvalue().splitlines()


def test_five_lines_of_a_kind_are_written_and_the_others_counted(log: Any) -> None:
    logger, written, clock = log
    for k in range(1000):
        logger.warning("scene %d broke", k)
    assert lines(written) == [f"scene {k} broke" for k in range(5)]
    clock.now = 61.0
    logger.warning("scene %d broke", 1000)
    assert lines(written)[5:] == ["scene 1000 broke (995 more like this since the last)"]


def test_same_line_is_written_once(log: Any) -> None:
    logger, written, _ = log
    for _ in range(1000):
        logger.warning("the disk is %s", "full")
    assert lines(written) == ["the disk is full"]


def test_other_kinds_are_written(log: Any) -> None:
    logger, written, _ = log
    for _ in range(1000):
        logger.warning("one")
    logger.warning("another")
    assert lines(written)[-1] == "another"


def test_traceback_is_written_once_for_each_place(log: Any) -> None:
    logger, written, _ = log
    for k in range(100):
        try:
            if k % 2:
                raise OSError("here")
            raise OSError("there")
        except OSError:
            logger.exception("it broke")
    assert written.getvalue().count("Traceback") == 2


def test_memory_of_kinds_is_bounded() -> None:
    repeats = RepeatFilter(Clock())
    for k in range(10_000):
        assert repeats.filter(logging.LogRecord("name", logging.WARNING, "file", 1, f"text {k}", (), None))
    assert len(repeats._kinds) == 256
