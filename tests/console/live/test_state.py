"""State of the machine as sent to a page: names, sentences, and gaps where nothing is known."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from opensuction.console.live.hub import Hub
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.transition import Event
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import RING
from opensuction.safety.condition import OUT_FIRST, Condition
from tests.console.written_machine import WrittenMachine

CONTRACT = frozenset(
    [
        "number",
        "tick",
        "utc",
        "age_s",
        "connected",
        "processes",
        "phase",
        "phase_left_s",
        "cause",
        "check_item",
        "check_failed",
        "tip_mm",
        "tip_low_mm",
        "tip_high_mm",
        "head_mm",
        "carriage_mm",
        "target_mm",
        "reference_mm",
        "moving",
        "is_inside",
        "contact",
        "vacuum_mmhg",
        "vacuum_setpoint_mmhg",
        "valve_open",
        "cam_rad",
        "pump_on",
        "mouth_clear",
        "secretions",
        "monitor",
        "alarms",
        "priority",
        "audible",
        "pause_left_s",
        "silent_s",
        "passes",
        "passes_most",
        "rest_left_s",
        "assessment_due",
        "locked_out",
        "preoxygenation",
        "oxygen_left_s",
        "refusal",
        "catheter_left_s",
        "last_cycle",
        "late_share",
        "skipped",
    ]
)


class Shown:
    """A machine that ticks when it is told to, and what a page is shown of it."""

    def __init__(self, folder: Path) -> None:
        self.machine = WrittenMachine(folder, str(folder / "records.db"))
        self.hub = Hub(folder)

    def __call__(self, columns: dict[str, float] | None = None) -> dict[str, Any]:
        self.machine.set(columns or {})
        self.machine.tick()
        return self.again()

    def again(self, later_s: float = 0.0) -> dict[str, Any]:
        """The same row, as it is shown some time later."""
        self.hub._told = None
        if later_s:
            self.machine._row[0] -= later_s
            self.machine._ring.write(self.machine._row)
        state = self.hub.state()
        assert json.loads(self.hub.now().text) == state, "what is sent is what is told"
        return state


@pytest.fixture
def shown(tmp_path: Path) -> Iterator[Shown]:
    made = Shown(tmp_path)
    yield made
    made.machine.stop()


def test_live_or_lost_the_same_fields_are_there(shown: Shown, tmp_path: Path) -> None:
    live = shown()
    assert set(live) >= CONTRACT
    assert set(shown.again(later_s=1.0)) == set(live)
    assert set(Hub(tmp_path / "nowhere").state()) == set(live)


def test_a_parked_machine(shown: Shown) -> None:
    state = shown()
    assert state["connected"] is True
    assert state["phase"] == "parked"
    assert state["is_inside"] is False
    assert state["tip_low_mm"] < state["tip_mm"] < state["tip_high_mm"]
    assert state["alarms"] == []
    assert state["priority"] == state["audible"] == "none"
    assert state["monitor"] == {
        "connected": True,
        "spo2_percent": 96.0,
        "heart_rate_per_min": 140.0,
        "airway_pressure_cmh2o": 12.0,
    }
    assert state["refusal"] is state["cause"] is state["check_item"] is None


def test_numbers_count_up_with_the_rows(shown: Shown) -> None:
    first, second = shown(), shown()
    assert second["number"] == first["number"] + 1
    assert second["tick"] == first["tick"] + 1


def test_a_tip_that_may_be_inside_is_inside(shown: Shown) -> None:
    """The deepest place where it can be counts, not the likeliest."""
    outside_mm = shown.hub.configuration().settings.limits.outside_mm
    shown.machine.place(outside_mm - 2.0, unsure_mm=3.0)
    assert shown()["is_inside"] is True
    shown.machine.place(outside_mm - 2.0, unsure_mm=1.0)
    assert shown()["is_inside"] is False


def test_a_tip_of_which_nothing_is_known_is_inside(shown: Shown) -> None:
    state = shown({"state.core.governor.watch.tip.foremost_mm": math.nan})
    assert state["is_inside"] is True
    assert state["tip_mm"] is state["tip_high_mm"] is None


@pytest.mark.parametrize(
    ("flag", "field"),
    [
        ("inputs.readings.head_valid", "head_mm"),
        ("inputs.readings.carriage_valid", "carriage_mm"),
        ("inputs.readings.cam_valid", "cam_rad"),
        ("inputs.readings.cam_valid", "valve_open"),
        ("inputs.readings.vacuum_valid", "vacuum_mmhg"),
        ("inputs.readings.contact_valid", "contact"),
    ],
)
def test_an_invalid_reading_is_none_not_the_number_that_came_with_it(
    shown: Shown, flag: str, field: str
) -> None:
    assert shown()[field] is not None
    assert shown({flag: 0.0})[field] is None


def test_an_oximeter_that_has_fallen_off_shows_no_number(shown: Shown) -> None:
    state = shown({"inputs.readings.monitor.spo2_valid": 0.0})
    assert state["monitor"]["spo2_percent"] is None
    assert state["monitor"]["heart_rate_per_min"] == 140.0


@pytest.mark.parametrize(
    ("speed", "moving"), [(3.0, "in"), (0.2, "still"), (-0.2, "still"), (-9.0, "out")]
)
def test_where_it_moves(shown: Shown, speed: float, moving: str) -> None:
    assert shown({"state.core.governor.watch.speed_mm_per_s": speed})["moving"] == moving


@pytest.mark.parametrize(
    ("age_ticks", "is_free", "told"),
    [
        (-1.0, 0.0, None),
        (0.0, 0.0, "coming"),
        (599.0, 0.0, "coming"),
        (599.0, 1.0, "nothing-comes"),
        (601.0, 1.0, None),
        (601.0, 0.0, None),
    ],
)
def test_secretions_are_told_as_long_as_the_line_tells_them(
    shown: Shown, age_ticks: float, is_free: float, told: str | None
) -> None:
    flow = "state.core.procedure.flow"
    state = shown({f"{flow}.age_ticks": age_ticks, f"{flow}.is_free": is_free})
    assert state["secretions"] == told


def test_alarms_come_with_sentence_and_remedy_the_first_one_first(shown: Shown) -> None:
    inside, low = Condition.CATHETER_JAMMED, Condition.RECORDER_LOST
    shown.machine.raise_alarm(low, inside, first=inside)
    shown.machine.set({"outputs.signals.acknowledged": float(1 << low)})
    state = shown()
    names = [one["name"] for one in state["alarms"]]
    assert names == ["catheter-jammed", "recorder-lost"]
    first, second = state["alarms"]
    assert first["sentence"] == inside.row.sentence
    assert first["remedy"] == inside.row.remedy
    assert (first["priority"], first["present"], first["acknowledged"]) == ("high", True, False)
    assert second["acknowledged"] is True
    assert state["priority"] == state["audible"] == "high"


def test_one_that_has_ended_and_waits_for_a_reset_is_shown_as_such(shown: Shown) -> None:
    mask = float(1 << Condition.CATHETER_JAMMED)
    state = shown({"outputs.signals.latched": mask, "outputs.signals.escalated": mask})
    (alarm,) = state["alarms"]
    assert (alarm["present"], alarm["latched"], alarm["escalated"]) == (False, True, True)


def test_words_of_a_failed_test_a_cause_and_a_refusal(shown: Shown) -> None:
    state = shown(
        {
            "outputs.phase": float(Phase.HALTED),
            "outputs.cause": float(Event.CHECK_FAILED),
            "outputs.check_failed": float(CheckItem.HEAD_HOME),
            "outputs.counters.refusal": float(Refusal.RESTING),
            "outputs.counters.rest_left_s": 12.2,
        }
    )
    assert (state["phase"], state["cause"]) == ("halted", "check-failed")
    assert state["check_failed"] == "head-home"
    assert state["check_failure"] == CheckItem.HEAD_HOME.failure
    assert state["refusal"] == {
        "name": "resting",
        "sentence": "the patient rests after the last pass",
        "remedy": "another 13 s",
    }


def test_a_catheter_whose_age_nobody_knows_has_no_time_left(shown: Shown) -> None:
    assert shown({"state.core.upkeep.catheter_age_s": math.inf})["catheter_left_s"] == 0.0


def test_what_has_not_been_written_for_half_a_second_is_no_value_any_more(shown: Shown) -> None:
    shown.machine.place(20.0)
    shown({"outputs.phase": float(Phase.SUCTIONING), "inputs.readings.line_vacuum_mmhg": 80.0})
    state = shown.again(later_s=0.6)
    assert state["connected"] is False
    assert state["age_s"] > 0.5
    assert state["phase"] == "unknown"
    for field in ("tip_mm", "vacuum_mmhg", "valve_open", "head_mm", "phase_left_s", "passes"):
        assert state[field] is None, field
    assert state["last_known"]["phase"] == "suctioning"
    assert state["last_known"]["is_inside"] is True
    (alarm,) = state["alarms"]
    assert (alarm["name"], alarm["priority"]) == ("control-lost", "high")
    assert alarm["remedy"] == OUT_FIRST
    assert state["audible"] == "high"


def test_before_any_controller_nothing_is_known(tmp_path: Path) -> None:
    state = Hub(tmp_path).state()
    assert state["connected"] is False
    assert state["age_s"] is state["last_known"] is None
    assert [one["name"] for one in state["alarms"]] == ["control-lost"]


def test_another_controller_is_followed_at_once(shown: Shown) -> None:
    shown({"outputs.phase": float(Phase.INSERTING)})
    shown.machine.stop()
    assert shown.hub.state()["phase"] == "inserting"
    other = WrittenMachine(shown.machine.folder, "records.db", "another-run")
    shown.hub._told = None
    state = shown.hub.state()
    assert (state["phase"], state["number"]) == ("parked", 1)
    other.stop()
    shown.machine = WrittenMachine(shown.machine.folder, "records.db", "a-third")


def test_a_ring_of_another_version_is_not_read(shown: Shown, tmp_path: Path) -> None:
    shown()
    data = bytearray((tmp_path / RING).read_bytes())
    (tmp_path / RING).unlink()
    (tmp_path / RING).write_bytes(data.replace(ROW_COLUMNS[-1].encode(), b"x" * 5, 1))
    assert Hub(tmp_path).state()["connected"] is False


def test_a_row_that_cannot_be_understood_shows_nothing(shown: Shown) -> None:
    state = shown({"outputs.phase": 99.0})
    assert state["connected"] is False
    assert state["alarms"][0]["name"] == "control-lost"


def test_who_gives_signs_of_life(shown: Shown) -> None:
    beats = Heartbeat(shown.machine.folder)
    beats.beat(Process.RECORDER)
    processes = shown()["processes"]
    assert processes["control"]["expected"] is processes["recorder"]["expected"] is True
    assert processes["recorder"]["age_s"] < 1.0
    assert processes["supervisor"] == {"age_s": None, "expected": False}
