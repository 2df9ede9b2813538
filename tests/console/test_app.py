"""The application as a whole."""

from pathlib import Path

import httpx
import pytest

from tests.console.served import Served, served


def test_the_page_is_there_and_says_what_it_is_not(console: Served) -> None:
    answer = console.client().get("/")
    assert answer.status_code == 200
    assert "not a medical device" in answer.text


def test_nothing_is_told_to_anybody_else_whatever_the_environment_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """FastAPI sends what it has served to whom these name, if it is let."""
    monkeypatch.setenv("FASTAPI_OTEL_AUTO_CONFIGURE", "true")
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", "http://collector.example:4318")
    with served(tmp_path) as console, console.client() as client:
        assert client.get("/api/v1/state").status_code == 200
        telemetry = console.app._telemetry
        assert not any(telemetry[one] for one in ("tracing", "metrics", "logs", "auto_configure"))
        assert not console.app._native_telemetry.enabled()


@pytest.mark.parametrize(
    "path",
    [
        "/../app.py",
        "/%2e%2e/app.py",
        "/..%2fapp.py",
        "/js/..%2f..%2fapp.py",
        "//etc/passwd",
        "/%2fetc/passwd",
        "/app.py",
        "/.%00/index.html",
    ],
)
def test_no_file_outside_the_page_is_given(console: Served, path: str) -> None:
    request = httpx.Request("GET", console.url)
    client = console.client()
    request.url = request.url.copy_with(raw_path=path.encode())
    answer = client.send(request)
    assert answer.status_code in (400, 404), answer.text
    assert "import" not in answer.text
    assert "root:" not in answer.text


def test_what_is_not_there_is_refused_as_a_problem(console: Served) -> None:
    answer = console.client().get("/api/v1/nothing")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["status"] == 404


def test_the_vendored_script_is_a_module(console: Served) -> None:
    answer = console.client().get("/vendor/uPlot.js")
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.text.rstrip().endswith("export default uPlot;")
