"""The page of a campaign says what its JSON object says."""

from typing import Any

from docs.generator import campaign_page


def count(cycles: int, broken: int) -> dict[str, Any]:
    return {"cycles": cycles, "broken": broken, "upper_percent": 0.0123}


FOUND: dict[str, Any] = {
    "compensation": "preview",
    "machines": 64,
    "first_seed": 20_000,
    "first": 0,
    "last": 100_000,
    "commands": count(100_000, 0),
    "fault_free": count(6_000, 0),
    "single": count(54_000, 0),
    "double": count(40_000, 17),
    "false_alarms": 0,
    "left_inside": {
        "single": {"count": 5_200, "unavoidable": 5_100, "told": 5_150},
        "double": {"count": 6_000, "unavoidable": 5_900, "told": 5_950},
    },
    "unnoticed": {
        "gear-lost": {"cycles": 900, "unnoticed": 700},
        "pump-lost": {"cycles": 800, "unnoticed": 0},
    },
    "breaches": [
        {
            "faults": "line-leak + pump-lost",
            "invariant": "time in the airway",
            "physical": True,
            "cycles": 17,
            "worst": 50.0,
            "bound": 44.0,
            "examples": (3, 5),
        }
    ],
}


def test_counts_and_their_bounds_are_told() -> None:
    page = campaign_page.markdown(FOUND, "2026-11-21")
    assert "# Random faults: 100,000 cycles" in page
    assert "| bounds of the patient, two faults | 40,000 | 17 | 0.012 % |" in page
    assert "In-silico" in page
    assert "| single | 5200 | 5100 | 5150 |" in page


def test_each_kind_of_breach_can_be_played_again() -> None:
    page = campaign_page.markdown(FOUND, "2026-11-21")
    assert "| line-leak + pump-lost | time in the airway | 17 | 50 | 44 | 3, 5 |" in page
    none = campaign_page.markdown({**FOUND, "breaches": []}, "2026-11-21")
    assert "\nNone.\n" in none


def test_only_what_went_untold_is_listed_as_such() -> None:
    page = campaign_page.markdown(FOUND, "2026-11-21")
    assert "| `gear-lost` | 900 | 700 |" in page
    assert "pump-lost` | 800" not in page
