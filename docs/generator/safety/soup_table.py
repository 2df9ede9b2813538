"""Software of unknown provenance: every part with its version, its failure and its anomalies."""

import re
import tomllib
from pathlib import Path
from typing import Any

from docs.generator.document import table
from opensuction.kernel.errors import InputError

ROOT = Path(__file__).resolve().parents[3]
SOUP = Path(__file__).parent / "soup.toml"
PINNED = re.compile(r"^([a-z0-9][a-z0-9._-]*)==([^\s;\\]+)", re.MULTILINE)
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
GITHUB = re.compile(r"^([\w.-]+/[\w.-]+)#(\d+)$")
ADVISORY = re.compile(r"^GHSA(?:-[0-9a-z]{4}){3}$")
EXTRAS = ("genetic", "matlab", "parquet", "postgresql", "sklearn")
"""Extras that a user may install; `dev` is for those who change the code."""


def soup() -> dict[str, Any]:
    """Rows of the packages and of the platform, as the file holds them."""
    return tomllib.loads(SOUP.read_text(encoding="utf-8"))


def pinned() -> dict[str, list[str]]:
    """Versions of every package in requirements.lock; more than one where Python's decides."""
    found: dict[str, list[str]] = {}
    for name, version in PINNED.findall((ROOT / "requirements.lock").read_text(encoding="utf-8")):
        found.setdefault(name, []).append(version)
    return found


def named() -> dict[str, str]:
    """What pyproject.toml asks for at run time, by name: the extra, or nothing."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = dict.fromkeys(map(_name, project["dependencies"]), "")
    for extra in EXTRAS:
        asked |= dict.fromkeys(map(_name, project["optional-dependencies"][extra]), extra)
    return asked


def _name(requirement: str) -> str:
    found = NAME.match(requirement)
    assert found is not None, requirement
    return found[0].lower().replace("_", "-")


def check() -> None:
    """Raises InputError where a dependency has no row, or one that was written for another version.

    The message says what to do: look at the new version's anomalies, then change the row.
    """
    rows, lock = {row["name"]: row for row in soup()["package"]}, pinned()
    for name, extra in named().items():
        if name not in rows:
            raise InputError(f"{SOUP.name}: {name} of pyproject.toml has no row; add one")
        if rows[name].get("extra", "") != extra or "parent" in rows[name]:
            raise InputError(f"{SOUP.name}: {name}: pyproject.toml has it as extra '{extra}'")
    for name, row in rows.items():
        if name not in named() and row.get("parent") not in rows:
            raise InputError(f"{SOUP.name}: {name}: nothing in the file brings it; name its parent")
        if row["reviewed"] != lock.get(name):
            versions = ", ".join(lock.get(name, ["none"]))
            raise InputError(
                f"{SOUP.name}: {name}: reviewed {', '.join(row['reviewed'])}, requirements.lock "
                f"has {versions}; look at the anomalies of that version and change the row"
            )


def _link(issue: str) -> str:
    """A public issue or advisory. Raises InputError for what is neither."""
    if found := GITHUB.match(issue):
        return f"[{issue}](https://github.com/{found[1]}/issues/{found[2]})"
    if ADVISORY.match(issue):
        return f"[{issue}](https://github.com/advisories/{issue})"
    raise InputError(f"{SOUP.name}: '{issue}' is no issue; write owner/name#number or GHSA-...")


def _origin(row: dict[str, Any]) -> str:
    if "parent" in row:
        return f"by {row['parent']}"
    return f"extra `{row['extra']}`" if "extra" in row else "direct"


def _named(row: dict[str, Any]) -> str:
    """A package with the versions that were looked at, and what brings it."""
    return f"`{row['name']}` {', '.join(row['reviewed'])} ({_origin(row)})"


def _texts(row: dict[str, Any]) -> tuple[str, str, str]:
    return row["used_for"], row["failure"], row["guard"]


def _anomalies(kinds: list[dict[str, Any]]) -> list[str]:
    rows = [
        (row["name"], _link(one["issue"]), one["what"], one["touches"], one["guard"] or "-")
        for row in kinds
        for one in row.get("anomaly", ())
    ]
    return table(("part", "issue", "what", "touches what is used here", "guard"), rows)


def markdown() -> str:
    """Parts, then the anomalies of each that were looked at."""
    check()
    data = soup()
    columns = ("used for", "if it fails", "who would notice, what guards")
    packages = [(_named(row), *_texts(row)) for row in data["package"]]
    platform = [(f"{row['name']} {row['version']}", *_texts(row)) for row in data["platform"]]
    silent = [f"`{row['name']}`" for row in data["package"] if "anomaly" not in row]
    return "\n".join(
        [
            "",
            f"Reviewed on {data['reviewed_on']:%Y-%m-%d}.",
            "",
            "## Packages",
            "",
            *table(("package", *columns), packages),
            "",
            "## Platform",
            "",
            *table(("part", *columns), platform),
            "",
            "## Known anomalies",
            "",
            *_anomalies([*data["package"], *data["platform"]]),
            "",
            f"None that matters was found, or none was looked for beyond a search, of "
            f"{', '.join(silent)}.",
            "",
            "",
        ]
    )
