"""Whether a failure was the record's or the machine's, and the loop of a fit for small pictures."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Add the columns; failures of before count as the machine's, and are calibrated again."""
    op.add_column("calibrations", sa.Column("cause", sa.String(8), nullable=False, server_default=""))
    op.add_column("calibrations", sa.Column("curves", sa.Text))
    op.execute("UPDATE calibrations SET cause = 'machine' WHERE status = 'failed'")
