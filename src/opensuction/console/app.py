"""The console as an application: its routes, its page, and what guards both."""

from importlib.resources import files
from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles

from opensuction.console.guard import handler
from opensuction.console.route import (
    account,
    history,
    identification,
    machine,
    protocol,
    request,
    session,
    signals,
    teaching,
)
from opensuction.console.site import Site

PREFIX, VERSION = "/api/v1", "1"
ROUTES = (
    session,
    machine,
    request,
    account,
    history,
    protocol,
    teaching,
    identification,
    signals,
)
PAGE = Path(str(files("opensuction.console"))) / "page"
VENDOR = Path(str(files("opensuction.report"))) / "vendor"


def create_app(site: Site) -> FastAPI:
    """The application of a site."""
    app = FastAPI(
        title="opensuction console",
        version=VERSION,
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,
        redoc_url=None,
    )
    app.state.site = site
    handler.add(app)
    for module in ROUTES:
        app.include_router(module.router, prefix=PREFIX)
    _add_page(app)
    return app


def _add_page(app: FastAPI) -> None:
    """Files of the page; none of them knows anything of a machine."""

    @app.get("/", include_in_schema=False)
    def index() -> FileResponse:
        return FileResponse(PAGE / "index.html")

    @app.get("/vendor/uPlot.js", include_in_schema=False)
    def uplot() -> Response:
        # The same file that a report holds, as a module: nothing is kept twice.
        script = (VENDOR / "uPlot.iife.min.js").read_text(encoding="utf-8")
        return Response(f"{script}\nexport default uPlot;\n", media_type="text/javascript")

    @app.get("/vendor/uPlot.css", include_in_schema=False)
    def uplot_style() -> FileResponse:
        return FileResponse(VENDOR / "uPlot.min.css", media_type="text/css")

    app.mount("/", StaticFiles(directory=PAGE), name="page")
