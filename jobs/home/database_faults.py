"""Passing faults of the job database: writes are repeated until it is back."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any, TypeVar

import sqlalchemy as sa

from jobs.home.passing_faults import one_line, passing_fault

__all__ = ["DATABASE_FAULTS", "persist"]

DATABASE_FAULTS = (sa.exc.DBAPIError, sa.exc.TimeoutError)  # the latter: no connection was free for half a minute

log = logging.getLogger(__name__)

Result = TypeVar("Result")


async def persist(write: Callable[..., Result], *arguments: Any) -> Result:
    """Call `write` in a thread, again and again until the database (or the store) takes it."""
    wait = 1.0
    while True:
        try:
            return await asyncio.to_thread(write, *arguments)
        except Exception as error:
            if not isinstance(error, DATABASE_FAULTS) and passing_fault(error) is None:
                raise
            log.warning("will try again in %g s: %s", wait, one_line(error))
        await asyncio.sleep(wait)
        wait = min(2 * wait, 30.0)
