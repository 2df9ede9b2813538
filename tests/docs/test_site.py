"""The site is built without a warning, and no page of it needs a network to be shown."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video)\b[^>]*\bsrc=["']([^"']+)"""
    r"""|<link\b[^>]*\bhref=["']([^"']+)"""
    r"""|url\(["']?([^"')]+)|@import\s+["']([^"']+)"""
)
"""What a browser fetches by itself; not what a reader may follow."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    words = ("--fail-on-warning", "--keep-going", "--quiet", "--builder", "html")
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *words, "docs", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


def loaded(text: str) -> set[str]:
    return {next(part for part in found if part) for found in LOADED.findall(text)}


@pytest.mark.examples
def test_nothing_is_loaded_from_outside(site: Path) -> None:
    outside = {
        f"{path.relative_to(site)}: {target}"
        for path in (*site.rglob("*.html"), *site.rglob("*.css"))
        for target in loaded(path.read_text(encoding="utf-8"))
        if re.match(r"(?:https?:)?//", target)
    }
    assert not outside


@pytest.mark.examples
def test_every_page_is_in_the_site(site: Path) -> None:
    pages = {
        path.relative_to(ROOT / "docs").with_suffix("") for path in (ROOT / "docs").rglob("*.md")
    }
    shown = {path.relative_to(site).with_suffix("") for path in site.rglob("*.html")}
    assert pages <= shown


@pytest.mark.examples
def test_a_tag_leads_to_its_source(site: Path) -> None:
    page = (site / "reference" / "parameters.html").read_text(encoding="utf-8")
    assert 'href="../sources.html#aarc-2022"' in page


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ('<script async src="https://a.org/b.js">', "https://a.org/b.js"),
        ('<link rel="stylesheet" href="//a.org/c.css">', "//a.org/c.css"),
        ("@font-face { src: url('https://a.org/f.woff') }", "https://a.org/f.woff"),
        ('@import "https://a.org/d.css";', "https://a.org/d.css"),
    ],
)
def test_what_would_be_loaded_is_seen(text: str, target: str) -> None:
    assert loaded(text) == {target}


def test_what_is_only_linked_is_not_loaded() -> None:
    assert not loaded('<a href="https://doi.org/10.1109/TBME.2015.2491327">the paper</a>')
