"""First schema: devices, calibrations, parameters."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "devices",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("name", sa.Text, nullable=False, unique=True),
        sa.Column("serial", sa.Text, nullable=False, server_default=""),
    )
    op.create_table(
        "calibrations",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("device_id", sa.Integer, sa.ForeignKey("devices.id"), nullable=False),
        sa.Column("key", sa.String(64), nullable=False),
        sa.Column("record_sha256", sa.String(64)),
        sa.Column("paths", sa.Text, nullable=False),
        sa.Column("date", sa.String(32), nullable=False),
        sa.Column("operator", sa.Text, nullable=False, server_default=""),
        sa.Column("notes", sa.Text, nullable=False, server_default=""),
        sa.Column("program", sa.Text, nullable=False),
        sa.Column("options", sa.Text, nullable=False),
        sa.Column("status", sa.String(8), nullable=False),
        sa.Column("reason", sa.Text, nullable=False, server_default=""),
        sa.Column("kind", sa.Text),
        sa.Column("model", sa.Text),
        sa.Column("scores", sa.Text, nullable=False, server_default="[]"),
        sa.Column("findings", sa.Text, nullable=False, server_default="[]"),
        sa.Column("rmse", sa.Double),
        sa.Column("fit_percent", sa.Double),
        sa.Column("input_unit", sa.Text, nullable=False, server_default=""),
        sa.Column("unit", sa.Text, nullable=False, server_default=""),
        sa.Column("seconds", sa.Double),
        sa.Column("finished", sa.String(32), nullable=False),
        sa.Column("report", sa.Text, nullable=False, server_default=""),
        sa.UniqueConstraint("device_id", "key", name="one_row_a_device_and_key"),
    )
    op.create_index("calibrations_by_date", "calibrations", ["device_id", "date"])
    op.create_table(
        "parameters",
        sa.Column(
            "calibration_id",
            sa.Integer,
            sa.ForeignKey("calibrations.id", ondelete="CASCADE"),
            primary_key=True,
        ),
        sa.Column("position", sa.Integer, primary_key=True),
        sa.Column("block", sa.Text, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("value", sa.Double),
        sa.Column("std_error", sa.Double),
        sa.Column("unit", sa.Text, nullable=False),
        sa.Column("held", sa.Boolean, nullable=False),
    )
    op.create_index("parameters_by_name", "parameters", ["name"])
