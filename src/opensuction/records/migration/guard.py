"""The triggers that a database of the newest version must have."""

from opensuction.records.database import schema

EVERYWHERE = ("audit_follows", "audit_moves_head", "audit_head_follows", "cycle_follows")
OF_SQLITE = ("audit_head_no_insert", "audit_head_no_delete")
OF_POSTGRESQL = ("audit_head_kept",)
KEEPING = {"sqlite": ("no_replace", "no_update", "no_delete"), "postgresql": ("kept",)}
"""After the name of each table whose rows are never changed or removed."""


def name_triggers(dialect: str) -> frozenset[str]:
    """Their names; dialect: sqlite or postgresql."""
    keeping = {f"{table.name}_{end}" for table in schema.KEPT for end in KEEPING[dialect]}
    own = OF_SQLITE if dialect == "sqlite" else OF_POSTGRESQL
    return frozenset(keeping.union(EVERYWHERE, own))
