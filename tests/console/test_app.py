"""The application as a whole."""

from tests.console.served import Served


def test_the_page_is_there_and_says_what_it_is_not(console: Served) -> None:
    answer = console.client().get("/")
    assert answer.status_code == 200
    assert "not a medical device" in answer.text


def test_what_is_not_there_is_refused_as_a_problem(console: Served) -> None:
    answer = console.client().get("/api/v1/nothing")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["status"] == 404


def test_the_vendored_script_is_a_module(console: Served) -> None:
    answer = console.client().get("/vendor/uPlot.js")
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.text.rstrip().endswith("export default uPlot;")
