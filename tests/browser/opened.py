"""A page opened from disk in a real browser, and what it complained of and asked for."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, Page

INKED = """id => {
    const canvas = document.querySelector(`#${id} canvas`);
    const box = canvas.getBoundingClientRect();
    const pixels = new Uint32Array(
        canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
    return [box.width, box.height, new Set(pixels).size];
}"""
"""Size of a plot on the page and the number of different colours in it."""

SCHEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")


class Opened(NamedTuple):
    page: "Page"
    complaints: list[str]
    requests: list[str]

    def elsewhere(self) -> list[str]:
        """What was asked for that is not in the file itself."""
        return [url for url in self.requests if not url.startswith(("file:", "data:"))]


def opened(
    context: "BrowserContext",
    folder: Path,
    html: str,
    drawn: str,
    size: tuple[int, int] = (1400, 900),
    scheme: Literal["light", "dark"] = "light",
) -> Opened:
    """Write a page, open it and wait for its last plot.

    drawn: that plot's identifier; size: width and height of the window, px; scheme: of its colours.
    """
    file = folder / "report.html"
    file.write_text(html, encoding="utf-8")
    tab = context.new_page()
    tab.set_viewport_size({"width": size[0], "height": size[1]})
    tab.emulate_media(color_scheme=scheme)
    page = Opened(tab, [], [])
    tab.on("console", lambda message: page.complaints.append(message.text))
    tab.on("pageerror", lambda error: page.complaints.append(str(error)))
    tab.on("request", lambda request: page.requests.append(request.url))
    tab.goto(file.as_uri())
    tab.wait_for_selector(f"#{drawn} canvas")
    return page
