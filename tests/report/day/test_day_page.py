import pytest

from opensuction.report import sheet
from opensuction.report.day import day_page
from tests.report import example
from tests.report.day_example import cycle, day, samples

INSIDE = {
    "outcome": "aborted",
    "headline": "CATHETER IS STILL IN THE AIRWAY, 48.6 mm below the tube's end",
    "verdict": "bad",
    "inside_at_end": True,
}
HARMED = {"headline": "PATIENT AT RISK: oxygen", "verdict": "bad", "harm": ["saturation"]}
ALARMED = {"headline": "High alarm: the circuit", "verdict": "bad"}
AMBER = {"headline": "Completed, look at secretions removed (0.3 mL)", "verdict": "notice"}


def test_the_most_urgent_cycle_leads_the_day() -> None:
    worse = [cycle(1), cycle(2, **AMBER), cycle(3, **ALARMED), cycle(4, **HARMED)]
    worse.append(cycle(5, **INSIDE))
    leads = []
    for count in range(1, 6):
        found = day_page.verdict(day(*worse[:count]))
        leads.append((found.text, found.kind))
    assert leads == [
        ("1 of 1 cycles completed", "good"),
        ("2 of 2 cycles completed, one to look at", "notice"),
        ("Cycle 3: High alarm: the circuit", "bad"),
        ("Cycle 4: PATIENT AT RISK: oxygen", "bad"),
        ("Cycle 5: CATHETER IS STILL IN THE AIRWAY, 48.6 mm below the tube's end", "bad"),
    ]
    last = day_page.verdict(day(*worse))
    assert last.lead == "4 of 5 cycles completed. Look at cycles 2, 3, 4 too."


@pytest.mark.parametrize("changes", [INSIDE, HARMED, {"outcome": "aborted"}])
def test_a_day_with_such_a_cycle_fails_whatever_came_after_it(changes: dict[str, object]) -> None:
    found = day(cycle(1, **changes), cycle(2))
    assert not found.is_good
    assert day(cycle(1, **AMBER), cycle(2)).is_good


def test_a_refused_cycle_fails_the_day() -> None:
    refused = day(cycle(1), refusal="the gap is out of its range", repeat=3)
    found = day_page.verdict(refused)
    assert (found.text, found.kind) == ("A further cycle was refused", "bad")
    assert found.lead == "The gap is out of its range. 1 of 3 cycles completed."
    assert not refused.is_good


def test_a_day_that_ended_early_is_not_green() -> None:
    assert day_page.verdict(day(cycle(1), repeat=3)).kind == "bad"


def test_each_cycle_leads_to_its_report_and_figures_are_rounded() -> None:
    told = [{"what": "reserve-energy-used", "at_s": 3.0, "by": "power", "priority": "high"}]
    made = day(cycle(1), cycle(2, report=None, told=told))
    html = sheet.render(day_page.page(example.on_patient(), made, samples()))
    assert '<a href="cycle-001.html">1</a>' in html
    assert "cycle-002.html" not in html
    for shown in (">2.6<", ">14.5<", ">20.9<", ">95.2<", ">248<", ">1.0<"):
        assert shown in html
    assert "95.23" not in html
    assert "reserve-energy-used" in html


def test_a_day_to_look_at_is_amber() -> None:
    html = sheet.render(day_page.page(example.on_patient(), day(cycle(1, **AMBER)), samples()))
    assert '<p class="outcome notice"' in html
    assert "Cycle 1: Completed, look at secretions removed (0.3 mL)." in html
