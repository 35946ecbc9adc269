"""The number of the tables' form, by which older software knows that it must leave a database alone."""

from __future__ import annotations

import sqlalchemy as sa

from hgs_core.base.errors import InputError
from hgs_core.base.version import software_version
from jobs.home.home import Home

__all__ = ["SCHEMA", "note_schema", "require_known_schema"]

# Raise it whenever rows mean something else, a column is gone or renamed, or a worker of the version before could not
# go on with them; renamings stand in table_upgrades.py. A column that older software may leave at its default needs no
# new number: it is added.
SCHEMA = 2

_metadata = sa.MetaData()
_schema = sa.Table("hgs_schema", _metadata, sa.Column("number", sa.Integer, primary_key=True))  # one row


def require_known_schema(home: Home, engine: sa.Engine) -> None:
    """Refuse a database with tables of later software, before any change to it.

    Raises:
        InputError: says how to go on.
    """
    if not sa.inspect(engine).has_table(_schema.name):
        return
    with engine.connect() as connection:
        number = connection.execute(sa.select(sa.func.max(_schema.c.number))).scalar_one()
    if number is not None and number > SCHEMA:
        where = sa.make_url(home.database_url).render_as_string(hide_password=True)
        problem = f"has tables of the form {number}, and HGS {software_version()} knows them up to {SCHEMA}"
        cure = "install the version of HGS that the server had last, or give the HGS_HOME of a backup made before that"
        raise InputError(f"the job database {where}", problem, cure)


def note_schema(engine: sa.Engine) -> None:
    """Write this software's number into the database, once its tables are those of this software."""
    _metadata.create_all(engine)
    with engine.begin() as connection:
        if connection.execute(sa.select(_schema.c.number)).scalars().all() != [SCHEMA]:
            connection.execute(sa.delete(_schema))
            connection.execute(sa.insert(_schema).values(number=SCHEMA))
