"""A version of tests: it fails when it has done half of its work."""

from alembic import op

revision = "9001"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add something, then do what no database does."""
    op.execute("CREATE TABLE site (name TEXT NOT NULL PRIMARY KEY)")
    op.execute("ALTER TABLE machine ADD COLUMN site TEXT")
    op.execute("INSERT INTO nowhere VALUES (1)")
