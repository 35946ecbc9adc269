"""The database tables of jobs, labels and workers."""

from __future__ import annotations

import sqlalchemy as sa

__all__ = ["job_labels", "job_rows", "metadata", "worker_rows"]

metadata = sa.MetaData()

job_rows = sa.Table(
    "hgs_job",
    metadata,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("title", sa.Text, nullable=False),
    sa.Column("capture", sa.Text, nullable=False, index=True),
    sa.Column("config", sa.JSON, nullable=False),
    sa.Column("state", sa.String(16), nullable=False, index=True),
    sa.Column("attempt", sa.Integer, nullable=False),
    sa.Column("epoch", sa.Integer, nullable=False, server_default="0"),
    sa.Column("stage", sa.String(32), nullable=False),
    sa.Column("done", sa.BigInteger, nullable=False),
    sa.Column("total", sa.BigInteger, nullable=False),
    sa.Column("figures", sa.JSON, nullable=False),
    sa.Column("error", sa.Text, nullable=False),
    sa.Column("scene_id", sa.String(64), nullable=False),
    sa.Column("waiting", sa.Text, nullable=False, server_default=""),
    sa.Column("cause", sa.String(16), nullable=False, server_default=""),
    sa.Column("created", sa.Float(53), nullable=False, index=True),
    sa.Column("updated", sa.Float(53), nullable=False),
    sa.Column("labels", sa.JSON, nullable=False, server_default="[]"),
    sa.Column("priority", sa.Integer, nullable=False, server_default="0"),
    sa.Column("time_limit", sa.Float(53), nullable=False, server_default="0"),
    sa.Column("ends", sa.Float(53), nullable=False, server_default="0"),
    sa.Column("webhook", sa.Text, nullable=False, server_default=""),
    sa.Column("audio", sa.Text, nullable=False, server_default=""),
    sa.Column("request_key", sa.String(255)),  # NULL: the client gave none
    sa.Column("request_digest", sa.String(64), nullable=False, server_default=""),
    # Rows are wide, by their configs: lists are sorted, and titles looked through, in this alone.
    sa.Index("ix_hgs_job_list", "state", "created", "id", "title"),
    sa.Index("ix_hgs_job_request_key", "request_key", unique=True),
)

job_labels = sa.Table(
    "hgs_job_label",
    metadata,
    sa.Column("label", sa.String(64), primary_key=True),
    sa.Column("job_id", sa.String(64), primary_key=True, index=True),
)

worker_rows = sa.Table(
    "hgs_worker",
    metadata,
    sa.Column("id", sa.String(128), primary_key=True),
    sa.Column("host", sa.Text, nullable=False),
    sa.Column("pid", sa.Integer, nullable=False),
    sa.Column("device", sa.Text, nullable=False),
    sa.Column("job_id", sa.String(64), nullable=False),
    sa.Column("idle_because", sa.Text, nullable=False),
    sa.Column("started", sa.Float(53), nullable=False),
    sa.Column("seen", sa.Float(53), nullable=False),
)
