"""Processor time of tests, and the table of the costliest."""

from tests.stage import cost


def test_work_counts_and_the_costliest_come_first() -> None:
    begun_s = cost.processor_s()
    total = 0
    while cost.processor_s() - begun_s < 0.02:
        total += 1
    assert total > 0
    lines = list(cost.table({"a.py::one": 1.0, "a.py::two": 2.5, "b.py::one": 3.0}, 2))
    assert lines == [
        "6 s in 3 tests",
        "",
        "     3.0 s  b.py::one",
        "     2.5 s  a.py::two",
        "",
        "     3.5 s  a.py",
        "     3.0 s  b.py",
    ]
