"""Origin of a request: only the console's own page is accepted."""

import pytest

from opensuction.console.guard.origin import hosts_of, refuse_host, refuse_origin

HOSTS = hosts_of("127.0.0.1", 8080, False)
OWN = {"host": "127.0.0.1:8080", "origin": "http://127.0.0.1:8080"}


@pytest.mark.parametrize(
    "said", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "LOCALHOST:8080"]
)
def test_names_of_this_computer_are_let_through(said: str) -> None:
    assert refuse_host(HOSTS, said) == ""


@pytest.mark.parametrize(
    "said",
    [
        None,
        "",
        "evil.example",
        "evil.example:8080",
        "127.0.0.1",
        "127.0.0.1:80",
        "127.0.0.1:8080.evil.example",
    ],
)
def test_any_other_host_is_refused_so_no_name_can_be_made_to_mean_this_computer(
    said: str | None,
) -> None:
    assert refuse_host(HOSTS, said)


def test_at_the_usual_port_the_host_may_leave_it_out() -> None:
    assert refuse_host(hosts_of("127.0.0.1", 80, False), "localhost") == ""
    assert refuse_host(hosts_of("127.0.0.1", 443, True), "localhost") == ""
    assert refuse_host(hosts_of("127.0.0.1", 443, False), "localhost")


def test_with_a_certificate_any_name_may_be_its_own() -> None:
    assert refuse_host(hosts_of("0.0.0.0", 443, True), "ward-3.example") == ""


def test_a_change_from_the_own_page_is_let_through() -> None:
    assert refuse_origin(OWN, "http", needs_origin=True) == ""


@pytest.mark.parametrize(
    "changed",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "https://127.0.0.1:8080"},
        {"origin": "http://127.0.0.1:8081"},
        {"origin": "http://127.0.0.1:8080.evil.example"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_a_page_of_another_origin_is_refused(changed: dict[str, str]) -> None:
    assert refuse_origin(OWN | changed, "http", needs_origin=True)


def test_who_only_reads_need_not_say_where_from_but_must_not_say_elsewhere() -> None:
    host = {"host": "127.0.0.1:8080"}
    assert refuse_origin(host, "http", needs_origin=False) == ""
    assert refuse_origin(host, "http", needs_origin=True)
    assert refuse_origin(host | {"sec-fetch-site": "cross-site"}, "http", needs_origin=False)
