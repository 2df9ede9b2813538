"""Settings of the documentation's site: `make docs` builds it into build/site."""

import logging
import os
import re
from functools import cache
from pathlib import Path
from typing import Any

from furo.navigation import get_navigation_tree
from sphinx.application import Sphinx

from docs.generator.notebook_page import UNCOMPILED, kept_page
from docs.generator.site_text import ROOT_PAGES, Navigation, moved, tag_links, tags, told_tests

os.environ[UNCOMPILED] = "1"  # autodoc reads functions, not their compiled form
# A style of code switches every library's messages on as it is loaded.
logging.getLogger("alembic").setLevel(logging.WARNING)

DOCS = Path(__file__).resolve().parent
TAGS = tags((DOCS / "sources.md").read_text(encoding="utf-8"))

project = "opensuction"
html_title = "opensuction"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown", ".ipynb": "markdown"}
exclude_patterns = ["examples", "generator"]
nitpicky = True
html_theme = "furo"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme_options = {
    "announcement": "Research software, not a medical device: not for use on people or animals. "
    "Every figure is in-silico.",
}
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
add_module_names = False
toc_object_entries = False


def complete(site: Sphinx, page: str, text: list[str]) -> None:
    """Show a file of the root in its place, let tests speak and tags lead to their sources.

    Of a notebook, what its cells give as well.
    """
    file = Path(site.env.doc2path(page))
    if file.suffix == ".ipynb":
        text[0] = kept_page(file)
    if page in ROOT_PAGES:
        text[0] = moved((DOCS.parent / ROOT_PAGES[page]).read_text(encoding="utf-8"), page)
    text[0] = told_tests(text[0]) + "\n\n" + tag_links(TAGS, page)


def tidy(*arguments: Any) -> None:
    """Docstrings without what Python says of fields, and with ``input_`` as no link."""
    lines: list[str] = arguments[-1]
    told = [line for line in lines if not line.startswith("Alias for field number")]
    lines[:] = [re.sub(r"(?<=\w)_(?!\w)", r"\\_", line) for line in told]


@cache
def navigation(builder: Any) -> Navigation:
    """The tree of all pages, as the theme has it beside the first one."""
    whole = {"collapse": False, "titles_only": True, "maxdepth": -1, "includehidden": True}
    tree = builder._get_local_toctree(builder.config.root_doc, **whole)
    return Navigation(get_navigation_tree(tree))


def withhold(_site: Sphinx, _page: str, _template: str, context: dict[str, Any], *_: Any) -> None:
    """Keep the theme from making the tree for each page anew."""
    context.pop("toctree", None)


def show(site: Sphinx, page: str, _template: str, context: dict[str, Any], *_: Any) -> None:
    """The tree beside a page, after the theme has made the rest."""
    address = site.builder.get_target_uri(page)
    context["furo_navigation_tree"] = navigation(site.builder).beside(address)


def setup(site: Sphinx) -> None:
    """Called by Sphinx."""
    site.connect("source-read", complete)
    site.connect("autodoc-process-docstring", tidy)
    site.connect("html-page-context", withhold, priority=400)  # the theme's is 500
    site.connect("html-page-context", show, priority=600)
