"""A version of tests: a column more, and a table more."""

from alembic import op

revision = "9001"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """As a later version of the program might."""
    op.execute("ALTER TABLE machine ADD COLUMN site TEXT")
    op.execute("CREATE TABLE site (name TEXT NOT NULL PRIMARY KEY)")
