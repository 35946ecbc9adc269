from __future__ import annotations

import errno

import sqlalchemy as sa
from obstore.exceptions import GenericError

from hgs_core.base.errors import InputError
from server.cli.outer_faults import outer_fault


def test_what_lies_outside_of_the_program_is_one_line() -> None:
    given = InputError("--out", "is taken")
    assert outer_fault(given) is given
    assert str(outer_fault(OSError(errno.EROFS, "Read-only file system", "/mnt/x"))).startswith("/mnt/x: read-only")
    database = sa.exc.OperationalError("SELECT 1", {}, Exception("unable to open database file"))
    assert "the database of jobs: unable to open database file" in str(outer_fault(database))
    assert "the store of scenes: no such bucket" in str(outer_fault(GenericError("no such bucket\n\nDebug source")))


def test_a_fault_of_the_program_is_none() -> None:
    assert outer_fault(ValueError("a bug")) is None
    assert outer_fault(KeyError("a bug")) is None
