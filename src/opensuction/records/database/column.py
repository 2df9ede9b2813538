"""Building blocks of all tables: names of constraints, bounds, types of columns."""

from sqlalchemy import BigInteger, CheckConstraint, Integer, MetaData

LONGEST_NAME = 64
LONGEST_TEXT = 4000
HASH_DIGITS = 64
"""Of SHA-256 in hexadecimal."""

METADATA = MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ix": "ix_%(table_name)s_%(column_0_name)s",
    }
)
SEQUENCE = BigInteger().with_variant(Integer, "sqlite")
"""SQLite counts by itself in columns of the plain kind only."""


def bound(name: str, longest: int, shortest: int = 1) -> CheckConstraint:
    """Constraint on the number of characters in a column."""
    return CheckConstraint(f"length({name}) BETWEEN {shortest} AND {longest}", name=name)


def one_of(name: str, values: tuple[str, ...] | tuple[bool, ...]) -> CheckConstraint:
    """Constraint on the values of a column."""
    return CheckConstraint(f"{name} IN ({', '.join(map(repr, values))})", name=name)
