"""Description of the machine before anything moves, readable by anybody."""

import pytest

from opensuction.console.live import machine_description
from opensuction.kernel.interface import Requests
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime.machine_folder import CONFIGURATION
from opensuction.safety import limits as safety_limits
from tests.console.served import Served

MACHINE = "/api/v1/machine"


def test_all_that_the_page_draws_is_told(console: Served) -> None:
    told = console.client().get(MACHINE).json()
    settings = console.site.hub.configuration().settings
    assert (told["serial"], told["is_twin"]) == ("twin-1", True)
    assert "not a medical device" in told["notice"]
    anatomy = told["anatomy"]
    assert anatomy["park_mm"] < anatomy["boundary_mm"] < anatomy["tube_end_mm"] == 0.0
    assert 0.0 < anatomy["target_mm"] < anatomy["cap_mm"]
    most_mm = safety_limits.head_cap_mm(settings.limits.tip, settings.limits.cap_mm)
    assert anatomy["head_most_mm"] == pytest.approx(most_mm, abs=1e-4)
    park_head_mm = settings.plan.motion.park_head_mm
    assert anatomy["park_head_mm"] == pytest.approx(park_head_mm, abs=1e-4)
    assert park_head_mm < most_mm
    assert told["limits"]["vacuum_mmhg"] == settings.limits.vacuum_mmhg
    assert {one["phase"] for one in told["phases"]} >= {"parked", "backing-off", "out-of-service"}
    assert len(told["phases"]) == len(Phase)
    assert {one["ask"].replace("-", "_") for one in told["requests"]} == {
        *(set(Requests._fields) - {"changed"})  # that of a new catheter takes its label
    }
    assert all(one["label"] for one in told["requests"])
    assert told["catheter"]["left_s"] == settings.service.life_s


def test_a_start_says_in_one_line_what_it_will_do(console: Served) -> None:
    told = console.client().get(MACHINE).json()["plan_sentence"]
    assert told == "to 2 mm, 80 mmHg, at most 5 s suction"


def test_of_a_promise_no_tenth_is_rounded_away(console: Served) -> None:
    settings = console.site.hub.configuration().settings
    motion = settings.plan.motion._replace(target_mm=88.04)
    limits = settings.limits._replace(negative_pressure_s=14.61)
    other = settings._replace(plan=settings.plan._replace(motion=motion), limits=limits)
    assert machine_description.say_plan(other) == "to 88 mm, 80 mmHg, at most 14.7 s suction"


def test_other_settings_are_told_as_soon_as_they_hold(console: Served) -> None:
    from opensuction.controller import configuration

    client = console.client()
    assert "80 mmHg" in client.get(MACHINE).json()["plan_sentence"]
    chosen = console.site.hub.configuration()
    plan = chosen.settings.plan._replace(vacuum_mmhg=70.0)
    other = chosen._replace(settings=chosen.settings._replace(plan=plan))
    file = console.site.folder / CONFIGURATION
    new = file.with_suffix(".new")
    new.write_text(configuration.to_json(other))
    new.replace(file)
    assert "70 mmHg" in client.get(MACHINE).json()["plan_sentence"]


@pytest.mark.parametrize("text", ["", "{}", "not json"])
def test_a_machine_that_is_not_set_up_is_no_failure(console: Served, text: str) -> None:
    (console.site.folder / CONFIGURATION).write_text(text)
    answer = console.client().get(MACHINE)
    assert answer.status_code == 503
    assert answer.json()["detail"].startswith("no machine is set up: ")
    assert console.client().get("/api/v1/state").json()["connected"] is False


def test_the_last_cycle_is_told_once_it_is_on_record(console: Served) -> None:
    from opensuction.console.live.hub import LastCycle
    from opensuction.records.entry import CycleEnd, Outcome
    from tests.records.example import start

    site = console.site
    last = LastCycle(site.hub, site.records, site.about)
    last.look()
    assert console.site.hub.state()["last_cycle"] is None
    cycle = site.records.begin_cycle(start()._replace(machine=site.about().machine))
    site.records.end_cycle(cycle, CycleEnd(Outcome.ABORTED, "contact-misplaced", False))
    last.look()
    site.hub._told = None
    told = site.hub.state()["last_cycle"]
    assert (told["id"], told["outcome"], told["detail"]) == (cycle, "aborted", "contact-misplaced")
