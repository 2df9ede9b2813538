import re

import pytest

from opensuction.report.cycle import page
from tests.report import example
from tests.report.page_data import payload


def test_page_needs_nothing_from_elsewhere() -> None:
    html = page.render(example.summary(), example.trace())
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", html)
    styles = "".join(re.findall(r"<style>(.*?)</style>", html, re.S))
    assert not re.search(r"@import|url\(", styles)


def test_page_is_small() -> None:
    assert len(page.render(example.summary(), example.trace()).encode()) < 1_000_000


def test_page_says_what_it_is_and_what_happened() -> None:
    html = page.render(example.summary(), example.trace())
    assert "not a medical device" in html
    assert "Completed" in html
    assert "90.7 mm" in html
    assert "negative pressure lasts 21 s" in html


def test_page_says_how_far_machine_and_patient_were_drawn_where_not_as_usual() -> None:
    assert "2, spread x 2" in page.render(example.summary(seed=2, spread=2.0), example.trace())
    assert "spread" not in page.render(example.summary(seed=2, spread=1.0), example.trace())


def test_a_completed_cycle_with_the_catheter_inside_is_not_green() -> None:
    tip = example.SUMMARY["tip"] | {"end_mm": 48.6, "inside_at_end": True}
    html = page.render(example.summary(tip=tip), example.trace())
    assert '<p class="outcome bad"' in html
    assert "CATHETER IS STILL IN THE AIRWAY, 48.6 mm below the tube" in html
    assert '<p class="outcome good"' in page.render(example.good(), example.trace())


def test_aborted_cycle_shows_trip_and_alarm() -> None:
    html = page.render(example.aborted(), example.trace())
    assert "Aborted at 17.0 s" in html
    assert "16.9 s: the line vacuum is above its limit" in html
    row = html.split('<h2 id="alarms">')[1].split("</table>")[0]
    for said in ("The line vacuum is above its limit", "high", "from 16.9 s on, kept"):
        assert said in row
    assert "Check the regulator." in row


def test_plots_mark_when_the_alarm_began() -> None:
    data = payload(page.render(example.aborted(), example.trace()))
    marked = [[label, time_s] for label, _, time_s in data["instants"]]
    assert marked == [["Alarm: vacuum exceeded", 16.9]]
    assert payload(page.render(example.summary(), example.trace()))["instants"] == []


def test_a_page_without_alarms_has_no_section_for_them() -> None:
    assert 'id="alarms"' not in page.render(example.summary(), example.trace())


def test_text_from_a_summary_is_never_markup() -> None:
    attack = "</script><script>alert(1)</script>"
    summary = example.summary(protocol=attack, warnings=[attack], seed=attack)
    html = page.render(summary, example.trace(), {attack: {attack: attack}})
    assert attack not in html


def test_equal_inputs_give_equal_pages() -> None:
    first, second = (page.render(example.summary(), example.trace()) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("key", sorted(example.SUMMARY))
def test_anything_may_be_unknown(key: str) -> None:
    result = example.summary(**{key: None})
    assert "None" not in page.render(result, example.trace(rows=2000)).split("<script")[0]


def test_trace_without_rows_gives_a_page_without_plots() -> None:
    html = page.render(example.summary(), {})
    assert "Over time" not in html
    assert payload(html)["series"] == {}


def test_phase_of_one_tick_is_not_a_step() -> None:
    assert [band.label for band in page.bands(example.summary())] == [
        "Checking",
        "Inserting",
        "Opening valve",
        "Suctioning",
        "Withdrawing",
        "Closing valve",
    ]


def test_sections_become_tables() -> None:
    sections = {"Protocol settings": {"travel_mm": 90.0, "bench_only": True}}
    html = page.render(example.summary(), {}, sections)
    assert re.search(r"Protocol settings.*travel_mm.*90.*bench_only.*yes", html, re.S)


def test_patient_and_requirements_are_on_the_page() -> None:
    html = page.render(example.on_patient(), example.breathing_trace())
    assert "The patient over time" in html
    assert set(payload(html)["patient"]) == {
        "time",
        "airway_pressure",
        "lung_volume",
        "lung_volume_loss",
        "spo2",
        "heart_rate",
    }
    assert re.search(r"Vacuum</th>.*?120 mmHg.*?at most 150 mmHg.*?>yes<.*?II-B", html, re.S)
    assert re.search(r"Catheter over tube diameter.*?0\.533<.*?below 0\.5<.*?>no<", html, re.S)


def test_bench_has_no_patient_on_the_page() -> None:
    html = page.render(example.summary(), example.breathing_trace())
    assert payload(html)["patient"] == {}
    assert 'id="saturation"' not in html
    assert "Within the guidelines?" not in html


@pytest.mark.parametrize("key", sorted(example.ON_PATIENT))
def test_anything_of_a_patient_may_be_unknown(key: str) -> None:
    html = page.render(example.on_patient(**{key: None}), {})
    assert "None" not in html.split("<script")[0]


def test_rest_after_the_cycle_is_no_step() -> None:
    assert page.bands(example.on_patient())[-1].label == "Closing valve"


def test_page_with_a_patient_is_small() -> None:
    html = page.render(example.on_patient(), example.breathing_trace())
    assert len(html.encode()) < 1_000_000
