"""A machine that shows whatever a test wants to see: states that a real one seldom shows.

It serves the page's own files, and answers as the interface does. What it says is a plain dict that
a test changes while the page looks at it.
"""

import asyncio
import contextlib
import threading
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from importlib.resources import files
from typing import Any

import uvicorn
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import FileResponse, JSONResponse, Response
from starlette.requests import ClientDisconnect
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect

from opensuction.accounts.rule import right
from opensuction.accounts.rule.right import Role
from opensuction.console.route import machine as machine_route
from opensuction.console.route import request as request_route
from opensuction.report import wording
from opensuction.safety.condition import Condition
from opensuction.session.running import console_settings

PAGE = str(files("opensuction").joinpath("console", "page"))
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
Json = dict[str, Any]

PARKED: Json = {
    "number": 1,
    "tick": 1,
    "utc": "",  # as of when it is told
    "age_s": 0.01,
    "connected": True,
    "last_known": None,
    "processes": {
        name: {"age_s": 0.01, "expected": True} for name in ("control", "recorder", "supervisor")
    },
    "phase": "parked",
    "phase_left_s": None,
    "cause": None,
    "check_item": None,
    "check_title": None,
    "check_failed": None,
    "check_failure": None,
    "tip_mm": -100.0,
    "tip_low_mm": -101.0,
    "tip_high_mm": -99.0,
    "head_mm": 0.0,
    "carriage_mm": 0.0,
    "target_mm": 88.0,
    "reference_mm": -100.0,
    "moving": "still",
    "is_inside": False,
    "contact": False,
    "vacuum_mmhg": 0.4,
    "vacuum_setpoint_mmhg": 0.0,
    "valve_open": False,
    "cam_rad": 0.0,
    "pump_on": False,
    "mouth_clear": True,
    "secretions": None,
    "monitor": {
        "connected": True,
        "spo2_percent": 97.0,
        "heart_rate_per_min": 78.0,
        "airway_pressure_cmh2o": 12.0,
    },
    "alarms": [],
    "priority": "none",
    "audible": "none",
    "pause_left_s": 0.0,
    "silent_s": 0.0,
    "passes": 0,
    "passes_most": 3,
    "rest_left_s": 0.0,
    "assessment_due": False,
    "locked_out": False,
    "preoxygenation": "not-required",
    "oxygen_left_s": 0.0,
    "refusal": None,
    "catheter_left_s": 71000.0,
    "last_cycle": None,
    "late_share": 0.0,
    "skipped": 0,
}
MACHINE: Json = {
    "serial": "twin-1",
    "kind": "twin",
    "is_twin": True,
    "notice": "in-silico",
    "approach": "contact",
    "patient": {"pseudonym": "A-0417", "age": "adult"},
    "anatomy": {
        "tube_end_mm": 0.0,
        "boundary_mm": -80.0,
        "park_mm": -100.0,
        "park_head_mm": -120.0,
        "head_most_mm": 120.0,
        "target_mm": 88.0,
        "cap_mm": 105.0,
        "carina_mm": 98.0,
    },
    "phases": [
        {"phase": name.replace("_", "-"), **words._asdict()}
        for name, words in wording.PHASES.items()
    ],
    "protocol": {"name": "gentle", "vacuum_mmhg": 100.0, "suction_s": 15.0},
    "limits": {
        "vacuum_mmhg": 150.0,
        "spo2_percent": 90.0,
        "heart_rate_per_min": 50.0,
        "airway_pressure_cmh2o": [-5.0, 40.0],
    },
    "plan_sentence": "to 88 mm, 100 mmHg, at most 15 s suction",
    "software_version": "0.0",
    "next_cycle_at": None,
    "catheter": {"label": "1", "left_s": 71000.0},
}


def alarm(condition: Condition, **changes: Any) -> Json:
    """An alarm that is shown, in the words of the condition."""
    row = condition.row
    return {
        "name": condition.name.lower().replace("_", "-"),
        "priority": row.handling.priority.name.lower(),
        "sentence": row.sentence,
        "remedy": row.remedy,
        "acknowledged": False,
        "present": True,
        "latched": False,
        "escalated": False,
        **changes,
    }


def alarming(*alarms: Json, **changes: Any) -> Json:
    """What a state says beside its alarms, the first one the most urgent."""
    priority = alarms[0]["priority"] if alarms else "none"
    return {"alarms": list(alarms), "priority": priority, "audible": priority, **changes}


class FakeMachine:
    """State, people and what was asked for; read and changed by the test's own thread."""

    def __init__(self) -> None:
        self.state: Json = dict(PARKED)
        self.machine: Json = dict(MACHINE)
        self.person: Json | None = None
        self.asked: list[Json] = []
        self.headers: list[dict[str, str]] = []
        self.unattended: list[bool] = []
        """Of each look at the session: whether it says that nobody has asked for it."""
        self.answer: Json = {"verdict": "pressed", "refusal": None}
        self.problem: tuple[int, Json, dict[str, str]] | None = None
        """Every change is refused with it."""
        self.mute = False
        """The live connection is open and says nothing."""
        self.held: set[str] = set()
        """Buttons that are answered once they are no more among these."""
        self.arrived: list[str] = []
        """Buttons, as they came; `asked` has them as they were answered."""
        self.deaf = False
        """Requests for the machine are never answered."""
        self.down = False
        """Live connections are refused and closed."""
        self.ahead = timedelta()
        """Of the clock of the computer that the browser runs on."""
        self.told = 0
        """States that pages were sent."""

    def show(self, **changes: Any) -> None:
        self.state = {**PARKED, **changes}

    def sign_in(
        self,
        role: Role,
        *,
        name: str = "kim",
        administrator: bool = False,
        must_change: bool = False,
    ) -> None:
        rights = right.MUST_CHANGE if must_change else right.rights_of(role, administrator)
        self.person = {
            "name": name,
            "role": str(role),
            "is_administrator": administrator,
            "must_change_password": must_change,
            "rights": sorted(map(str, rights)),
            "csrf": name[0] * 16,
            "expires_at": (datetime.now(UTC) + timedelta(minutes=30)).isoformat(),
        }


NOBODY: Json = {"name": None, "rights": sorted(map(str, right.ANYBODY))}


def create_app(fake: FakeMachine) -> FastAPI:
    app = FastAPI(openapi_url=None)
    app.include_router(request_route.page)

    @app.middleware("http")
    async def guard(request: Request, call_next: Any) -> Response:
        response: Response = await call_next(request)
        response.headers["Content-Security-Policy"] = POLICY
        return response

    add_session(app, fake)
    add_machine(app, fake)
    add_people(app)
    # The routes above answer first: of the machine's own, the drawing and the signals are wanted.
    app.include_router(machine_route.router, prefix="/api/v1")

    @app.get("/")
    def index() -> FileResponse:
        return FileResponse(f"{PAGE}/index.html")

    app.mount("/", StaticFiles(directory=PAGE))
    return app


def add_session(app: FastAPI, fake: FakeMachine) -> None:
    @app.get("/api/v1/session")
    def session(request: Request) -> Json:
        fake.unattended.append("x-unattended" in request.headers)
        return fake.person or NOBODY

    @app.post("/api/v1/session", response_model=None)
    async def sign_in(request: Request) -> Response:
        told = await request.json()
        if fake.problem is not None:
            return refuse(fake)
        if told["password"] == "one-time":
            fake.sign_in(Role.CLINICIAN, must_change=True)
        else:
            fake.sign_in(Role(told["name"]), administrator=told["name"] == "engineer")
        return JSONResponse(fake.person)

    @app.put("/api/v1/session/password")
    def password() -> Json:
        fake.sign_in(Role.CLINICIAN)
        assert fake.person is not None
        return fake.person

    @app.delete("/api/v1/session", status_code=204)
    def sign_out() -> None:
        fake.person = None


def add_machine(app: FastAPI, fake: FakeMachine) -> None:
    @app.get("/api/v1/machine")
    def machine() -> Json:
        return fake.machine

    @app.post("/api/v1/requests", response_model=None)
    async def ask(request: Request) -> Response:
        if fake.deaf:
            await asyncio.sleep(3)
        if fake.problem is not None:
            return refuse(fake)
        try:
            asked = await request.json()
        except ClientDisconnect:
            return Response(status_code=204)
        fake.arrived.append(asked["ask"])
        while asked["ask"] in fake.held:
            await asyncio.sleep(0.01)
        fake.asked.append(asked)
        fake.headers.append(dict(request.headers))
        return JSONResponse({**fake.answer, "phase": fake.state["phase"], "took_ms": 3.0})

    @app.websocket("/api/v1/live")
    async def live(socket: WebSocket) -> None:
        if not fake.down:
            await socket.accept()
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await tell(socket, fake)


async def tell(socket: WebSocket, fake: FakeMachine) -> None:
    """A state as soon as it is shown and ten times a second, as long as the machine is up."""
    last, looks = None, 0
    while not fake.down:
        state, looks = fake.state, looks + 1
        if not fake.mute and (state is not last or looks % 5 == 0):
            utc = (datetime.now(UTC) + fake.ahead).isoformat(timespec="milliseconds")
            await socket.send_json({**state, "utc": utc})
            fake.told += 1
            last = state
        await asyncio.sleep(0.02)
    await socket.close()


def add_people(app: FastAPI) -> None:
    """What an administrator sees."""
    until = "2026-03-02T10:00:00+00:00"

    @app.get("/api/v1/accounts")
    def accounts() -> list[Json]:
        kinds = (("ada", "clinician", False, True), ("ben", "observer", True, False))
        return [
            {
                "name": name,
                "role": role,
                "is_administrator": name == "ada",
                "is_active": is_active,
                "has_one_time_password": one_time,
                "password_set_at": until,
            }
            for name, role, one_time, is_active in kinds
        ]

    @app.post("/api/v1/accounts")
    async def add(request: Request) -> Json:
        told = await request.json()
        return {"account": told["name"], "one_time_password": "k7-h2-m9", "expires_at": until}

    @app.get("/api/v1/tokens")
    def tokens() -> list[Json]:
        return [{"id": "t1", "label": "ward list", "scope": ["see-history"], "expires_at": until}]

    @app.get("/api/v1/rights")
    def rights() -> list[dict[str, Any]]:
        return [dict(one) for one in right.list_plain()]


def refuse(fake: FakeMachine) -> Response:
    assert fake.problem is not None
    status, body, headers = fake.problem
    return JSONResponse({"status": status, **body}, status, headers, "application/problem+json")


class FakeServer:
    """One address, behind which one fake machine takes the place of another.

    Each has an application of its own: what was asked of one that is gone reaches no other.
    """

    def __init__(self, url: str) -> None:
        self.url = url
        self._app: ASGIApp = create_app(FakeMachine())

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self._app(scope, receive, send)

    @contextlib.contextmanager
    def playing(self) -> Iterator[FakeMachine]:
        """A machine that is new, as long as it is wanted."""
        fake = FakeMachine()
        self._app = create_app(fake)
        try:
            yield fake
        finally:
            fake.down = True


@contextlib.contextmanager
def serve() -> Iterator[FakeServer]:
    """A server, as long as it is wanted. Whoever connects before it works waits in the queue."""
    with console_settings.listen("127.0.0.1", 0) as listening:
        front = FakeServer(f"http://127.0.0.1:{listening.getsockname()[1]}/")
        config = uvicorn.Config(front, log_level="error", ws="websockets-sansio", lifespan="off")
        server = uvicorn.Server(config)
        run = {"sockets": [listening]}
        thread = threading.Thread(target=server.run, kwargs=run, daemon=True)
        thread.start()
        try:
            yield front
        finally:
            server.should_exit = True
            thread.join(10.0)
