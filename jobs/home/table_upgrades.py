"""Tables of earlier forms brought up to the present one, in place."""

from __future__ import annotations

import sqlalchemy as sa

__all__ = ["add_what_is_missing", "rename_columns"]

_RENAMED = (("hgs_job", "stage_ends", "ends"),)  # table, column up to form 1, column since
"""Every renaming so far, in order. The columns decide, not the number: an interrupted upgrade is repeated."""


def rename_columns(engine: sa.Engine) -> None:
    """Give columns of earlier forms their present names."""
    with engine.begin() as connection:
        for table, old, new in _RENAMED:
            present = _columns(connection, table) if sa.inspect(connection).has_table(table) else set()
            if old in present and new not in present:
                connection.execute(sa.text(f"ALTER TABLE {table} RENAME COLUMN {old} TO {new}"))


def add_what_is_missing(engine: sa.Engine, metadata: sa.MetaData) -> None:
    """Add the columns and indexes that a table of an earlier form lacks; each has a default, or may be NULL."""
    with engine.begin() as connection:
        for table in metadata.sorted_tables:
            present = _columns(connection, table.name)
            for column in table.columns:
                if column.name not in present:
                    definition = sa.schema.CreateColumn(column).compile(dialect=engine.dialect)
                    connection.execute(sa.text(f"ALTER TABLE {table.name} ADD COLUMN {definition}"))
            for index in table.indexes:
                index.create(connection, checkfirst=True)


def _columns(connection: sa.Connection, table: str) -> set[str]:
    return {column["name"] for column in sa.inspect(connection).get_columns(table)}
