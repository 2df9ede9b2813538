"""Statements of one table, each composed once: that takes longer than to carry one out."""

from functools import cache
from typing import Any

from sqlalchemy import Delete, Insert, Select, Table, bindparam, delete, select


@cache
def insert_into(table: Table) -> Insert:
    """Inserts a row, whose values are given as it is carried out; columns not named are empty."""
    return table.insert()


@cache
def select_by(table: Table, *keys: str) -> Select[Any]:
    """Selects rows by some columns, whose values are given as it is carried out."""
    return select(table).where(*(table.c[key] == bindparam(key) for key in keys))


@cache
def delete_by(table: Table, *keys: str) -> Delete:
    """Deletes rows by some columns, whose values are given as it is carried out."""
    return delete(table).where(*(table.c[key] == bindparam(key) for key in keys))
