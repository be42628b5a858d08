"""Tables of the registry. A change here is a new file in ``migrations/versions``, and a new revision in the
reader of the command (``crates/hysteron-registry``)."""

from __future__ import annotations

from sqlalchemy import (
    Boolean,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)

METADATA = MetaData()

devices = Table(
    "devices",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("name", Text, nullable=False, unique=True),
    Column("serial", Text, nullable=False, server_default=""),
)

calibrations = Table(
    "calibrations",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("device_id", Integer, ForeignKey("devices.id"), nullable=False),
    Column("key", String(64), nullable=False),
    Column("record_sha256", String(64)),
    Column("paths", Text, nullable=False),  # JSON: list of texts
    Column("date", String(32), nullable=False),  # ISO 8601, UTC
    Column("operator", Text, nullable=False, server_default=""),
    Column("notes", Text, nullable=False, server_default=""),
    Column("program", Text, nullable=False),
    Column("options", Text, nullable=False),  # JSON, canonical
    Column("status", String(8), nullable=False),  # ok, failed
    Column("reason", Text, nullable=False, server_default=""),
    Column("kind", Text),
    Column("model", Text),  # a model file
    Column("scores", Text, nullable=False, server_default="[]"),  # JSON
    Column("findings", Text, nullable=False, server_default="[]"),  # JSON
    Column("rmse", Double),
    Column("fit_percent", Double),
    Column("input_unit", Text, nullable=False, server_default=""),
    Column("unit", Text, nullable=False, server_default=""),
    Column("seconds", Double),
    Column("finished", String(32), nullable=False),  # ISO 8601, UTC
    Column("report", Text, nullable=False, server_default=""),
    # Since the second schema:
    Column("cause", String(8), nullable=False, server_default=""),  # of a failure: record, machine
    Column("curves", Text),  # JSON: the loop, reduced
    UniqueConstraint("device_id", "key", name="one_row_a_device_and_key"),
)
Index("calibrations_by_date", calibrations.c.device_id, calibrations.c.date)

parameters = Table(
    "parameters",
    METADATA,
    Column("calibration_id", Integer, ForeignKey("calibrations.id", ondelete="CASCADE"), primary_key=True),
    Column("position", Integer, primary_key=True),
    Column("block", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("value", Double),
    Column("std_error", Double),
    Column("unit", Text, nullable=False),
    Column("held", Boolean, nullable=False),
)
Index("parameters_by_name", parameters.c.name)
