"""Faults of a command's surroundings (files, disks, database, store), as one line for people."""

from __future__ import annotations

import sys

from hgs_core.base.errors import InputError
from hgs_core.base.system_errors import as_input_error

__all__ = ["outer_fault"]

_LONGEST = 300  # characters of what a library says


def outer_fault(error: Exception) -> InputError | None:
    """Return the line for a fault that lies outside of the program; None for one of the program itself.

    Libraries are asked for their exceptions only where they are loaded: a command that needs no database loads none.
    """
    if isinstance(error, InputError):
        return error
    if isinstance(error, OSError):
        return as_input_error(error)
    if _is_of("sqlalchemy.exc", "SQLAlchemyError", error):
        cause = getattr(error, "orig", None) or error
        return InputError(
            "the database of jobs", _first_line(cause), "check that HGS_HOME can be written, and HGS_DATABASE_URL"
        )
    if _is_of("obstore.exceptions", "BaseError", error):
        return InputError(
            "the store of scenes", _first_line(error), "check HGS_STORE_URL, and that HGS_HOME can be written"
        )
    return None


def _is_of(module: str, name: str, error: Exception) -> bool:
    loaded = sys.modules.get(module)
    return loaded is not None and isinstance(error, getattr(loaded, name))


def _first_line(error: object) -> str:
    line = " ".join(str(error).partition("\n\n")[0].split()) or type(error).__name__
    return line if len(line) <= _LONGEST else f"{line[:_LONGEST]}..."
