"""The console as an application: its routes, its page, and what guards both.

Record of refusals by role: person and attempt, rate-limited so that a flood does not fill it.
"""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles

from opensuction.console.access import ConsoleContext, Names, session_cookie
from opensuction.console.guard import origin, problem
from opensuction.console.guard.body import Ranges
from opensuction.console.guard.guard import Guard
from opensuction.console.guard.limits import USUAL, Buckets, Limits, Rates
from opensuction.console.guard.problem import MEDIA_TYPE, ProblemBody, documented
from opensuction.console.live.button_press import Asking
from opensuction.console.live.hub import Broadcast, LastCycle
from opensuction.console.route import (
    history,
    identification,
    machine,
    protocol,
    request,
    session,
    signals,
)
from opensuction.kernel.errors import InputError
from opensuction.records.entry import Action
from opensuction.records.records import Records
from opensuction.report import sheet

EVERY_S = 10.0
"""The same person's same try is put on record at most so often,"""
ALL_HZ, ALL_MOST = 0.1, 30.0
"""and all of them together so often, and so many at once."""
LOG = logging.getLogger("opensuction.console")
WHAT = "refused"


class DeniedAccessLog:
    """Of one console."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._own = Buckets(1.0 / EVERY_S, 1.0)
        self._all = Buckets(ALL_HZ, ALL_MOST)

    def note(self, who: str | None, what: str, why: str) -> None:
        """Somebody tried what the role does not allow. who: None of somebody unknown."""
        name = who or "somebody"
        LOG.warning("refused: %s asks for %s: %s", name, what, why)
        if self._own.take(f"{name} {what}") or self._all.take("all"):
            return
        try:
            self._records.act(Action(name, WHAT, f"{what}: {why}"))
        except InputError as error:  # whoever asked is refused all the same
            LOG.error("a refusal was not put on record: %s", error)


PREFIX, VERSION = "/api/v1", "1"
ROUTERS = (
    session.router,
    machine.router,
    request.router,
    session.accounts_router,
    history.router,
    protocol.router,
    identification.teaching_router,
    identification.router,
    signals.router,
)
PAGE = Path(str(files("opensuction.console"))) / "page"
VENDOR = Path(str(files("opensuction.report"))) / "vendor"
TEMPLATE = Path(str(files("opensuction.report"))) / "template"
LOOP = ("plot_parts", "loop_plot")
BY_THE_GUARD = (400, 403, 408, 413, 421, 422, 429, 500)
"""What any route may answer, whatever it is: the guard does, or what came was of another shape."""


def create_app(site: ConsoleContext, limits: Limits = USUAL) -> FastAPI:
    """The application of a site. limits: how much of everything is let through."""
    rates = Rates(limits)
    app = FastAPI(
        title="opensuction console",
        version=VERSION,
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=_live,
        # Whatever the environment says: nothing of what is done here is told to anybody else.
        telemetry={"tracing": False, "metrics": False, "logs": False, "auto_configure": False},
        redirect_slashes=False,
    )
    app.state.site = site
    app.state.names, app.state.rates = Names(), rates
    app.state.refused = DeniedAccessLog(site.records)
    _begin(app)
    problem.add(app)
    for router in ROUTERS:
        app.include_router(router, prefix=PREFIX, responses=documented(*BY_THE_GUARD))
    _add_page(app)
    app.openapi = lambda: _describe(app)  # type: ignore[method-assign]
    app.add_middleware(Ranges)
    app.add_middleware(
        Guard,
        limits=limits,
        rates=rates,
        hosts=origin.hosts_of(*site.origin),
        cookie=partial(session_cookie, site.folder),
    )
    return app


def _begin(app: FastAPI) -> None:
    """Create the parts that belong to one event loop."""
    site: ConsoleContext = app.state.site
    app.state.broadcast = Broadcast(site.hub)
    app.state.asking = Asking(site.folder, site.hub)


@asynccontextmanager
async def _live(app: FastAPI) -> AsyncIterator[None]:
    """While it is served."""
    site: ConsoleContext = app.state.site
    _begin(app)
    last_cycle = LastCycle(site.hub, site.records, site.about)
    last_cycle.begin()
    try:
        yield
    finally:
        last_cycle.end()
        app.state.asking.close()


def _describe(app: FastAPI) -> dict[str, Any]:
    """The interface in words of OpenAPI; each refusal is a problem."""
    if app.openapi_schema is None:
        found = get_openapi(
            title=app.title,
            version=app.version,
            summary="What the bedside console's page uses, and other programs may read.",
            routes=app.routes,
        )
        schemas = found.setdefault("components", {}).setdefault("schemas", {})
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        body = ProblemBody.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas.update(body.pop("$defs", {}))
        schemas["ProblemBody"] = body
        _make_problems(found)
        app.openapi_schema = found
    return app.openapi_schema


def _make_problems(found: dict[str, Any]) -> None:
    """FastAPI describes refusals as plain JSON; here they are problems."""
    for methods in found["paths"].values():
        for route in methods.values():
            for status, answer in route["responses"].items():
                if status.isdigit() and int(status) >= 400:
                    schema = {"schema": {"$ref": "#/components/schemas/ProblemBody"}}
                    answer["content"] = {MEDIA_TYPE: schema}


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

    @app.get("/vendor/plot_parts.js", include_in_schema=False)
    def plot_parts() -> Response:
        # What a report's plots share; the same for those of the page.
        script = sheet.read("template", "plot_parts.js")
        text = f'import uPlot from "./uPlot.js";\n{script}\nexport default parts;\n'
        return Response(text, media_type="text/javascript")

    @app.get("/vendor/uPlot.css", include_in_schema=False)
    def uplot_style() -> FileResponse:
        return FileResponse(VENDOR / "uPlot.min.css", media_type="text/css")

    @app.get("/vendor/loop_plot.js", include_in_schema=False)
    def loop_plot() -> Response:
        # The loop of a report, as a module.
        scripts = [(TEMPLATE / f"{name}.js").read_text(encoding="utf-8") for name in LOOP]
        text = "\n".join(
            ['import uPlot from "./uPlot.js";', *scripts, "export default loopPlot;\n"]
        )
        return Response(text, media_type="text/javascript")

    app.include_router(request.page)
    app.mount("/", StaticFiles(directory=PAGE), name="page")
