"""The controller in somebody's own loop: what it takes, what it refuses, what it says."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction import NO_MONITOR, NO_REQUESTS, Controller, InputError, Readings
from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller, real_time_call, setup
from opensuction.controller.calibration import Feedforward, assume_nominal
from opensuction.controller.configuration import Configuration
from opensuction.controller.machine_profile import BENCH
from opensuction.controller.real_time_call import OUTPUT_COLUMNS, RealTimeCall
from opensuction.controller.record import Inputs, Outputs, State
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.compiler.dispatcher import CoreFunction
from opensuction.kernel.interface import Host
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER

DT_S = 0.001
NAN = math.nan
START = NO_REQUESTS._replace(start=True)


@cache
def configuration(kind: CompensationKind = CompensationKind.PREVIEW) -> Configuration:
    found = assume_nominal(PUBLISHED, Feedforward(velocity_v_s_per_mm=1.28, friction_v=0.5))
    settings = setup.settings(BENCH, PAPER, kind, found, by_contact=False, site=BENCH_SITE)
    return Configuration(settings, setup.branches(kind, found))


PARKED_MM = configuration().settings.parked.head_mm


def new(**given: Any) -> Controller:
    return Controller(configuration(), **{"catheter_age_s": 0.0, **given})


def readings(head_mm: float = PARKED_MM, **given: Any) -> Readings:
    """Of a sound machine at rest."""
    return Readings(
        head_mm=head_mm,
        head_valid=True,
        carriage_mm=head_mm,
        carriage_valid=True,
        cam_rad=0.0,
        cam_valid=True,
        line_vacuum_mmhg=0.0,
        vacuum_valid=True,
        contact_closed=False,
        contact_valid=True,
        mouth_clear=False,
        insertion_current_a=0.0,
        monitor=NO_MONITOR,
    )._replace(**given)


def test_a_start_begins_the_pre_use_test_and_torque_comes_on() -> None:
    chosen = new()
    assert chosen.step(readings(), NO_REQUESTS, DT_S).phase == "parked"
    said = chosen.step(readings(), START, DT_S)
    assert said.phase == "checking"
    assert said.commands.insertion_on
    assert said.trips == ()
    assert said.alarms == ()
    assert said.refusal is None


def test_it_is_the_real_time_call_with_the_same_rows() -> None:
    chosen, settings = new(), configuration().settings
    call = RealTimeCall(settings, None, controller.start(settings, PARKED_MM, 0.0))
    out = np.zeros(len(OUTPUT_COLUMNS))
    for tick in range(20):
        asked = START if tick == 3 else NO_REQUESTS
        said = chosen.step(readings(), asked, DT_S)
        inputs = Inputs(tick, DT_S, readings(), asked, Host(False, 0))
        call.step(plain_row.pack(Inputs, inputs), out)
        assert plain_row.pack(Outputs, said.outputs).tobytes() == out.tobytes()
    assert plain_row.pack(State, chosen.state).tobytes() == call.state_row.tobytes()


def test_the_first_readings_power_it_up_in_front_of_its_park_position_it_draws_out_at_once() -> (
    None
):
    chosen = new()
    said = chosen.step(readings(PARKED_MM + 60.0), NO_REQUESTS, DT_S)
    assert said.phase == "aborting"
    assert "recovery-needed" in [alarm.name for alarm in said.alarms]


def test_a_head_that_nothing_tells_of_halts_it() -> None:
    unknown = readings(NAN, head_valid=False, carriage_valid=False)
    assert new().step(unknown, NO_REQUESTS, DT_S).phase == "halted"


def test_a_catheter_of_unknown_age_is_not_used() -> None:
    chosen = Controller(configuration())
    said = chosen.step(readings(), START, DT_S)
    assert (said.phase, said.refusal) == ("parked", "catheter-life-over")


def test_what_was_kept_goes_on_in_the_next_controller() -> None:
    first = new(catheter_age_s=100.0)
    first.step(readings(), NO_REQUESTS, DT_S)
    second = Controller(configuration(), kept=first.state.core.upkeep, off_s=50.0)
    second.step(readings(), NO_REQUESTS, DT_S)
    assert second.state.core.upkeep.catheter_age_s == pytest.approx(150.002)


def test_numbers_of_other_kinds_that_mean_the_same_change_nothing() -> None:
    plain, mixed = new(), new()
    head_mm = float(np.float32(PARKED_MM))
    odd = readings(
        np.float32(head_mm),  # type: ignore[arg-type]
        head_valid=np.bool_(True),
        carriage_valid=1,
        cam_rad=0,
        vacuum_valid=np.int64(1),
        line_vacuum_mmhg=np.int16(0),
    )
    for _ in range(3):
        plain.step(readings(head_mm), START, DT_S)
        mixed.step(odd, START._replace(start=1), np.float64(DT_S))  # type: ignore[arg-type]
    assert repr(mixed.state) == repr(plain.state)


@pytest.mark.skipif(not isinstance(real_time_call.play, CoreFunction), reason="nothing is compiled")
def test_nothing_is_compiled_after_construction() -> None:
    chosen = new()
    before = len(real_time_call.play.overloads)  # type: ignore[attr-defined]
    for value in (0, 0.0, np.float32(0.0), np.int8(0), NAN, math.inf, 10**400):
        chosen.step(readings(cam_rad=value), NO_REQUESTS, DT_S)
    assert len(real_time_call.play.overloads) == before  # type: ignore[attr-defined]


def test_a_reading_that_is_flagged_may_be_anything() -> None:
    chosen = new()
    for value in (NAN, math.inf, -1e300):
        said = chosen.step(readings(cam_rad=value, cam_valid=False), NO_REQUESTS, DT_S)
        assert math.isfinite(said.commands.cam_rad)


def test_nan_that_is_not_flagged_is_a_fault_of_the_sensor_and_no_error_of_the_loop() -> None:
    chosen = new()
    chosen.step(readings(), NO_REQUESTS, DT_S)
    for _ in range(500):
        said = chosen.step(readings(line_vacuum_mmhg=NAN), NO_REQUESTS, DT_S)
    assert said.trips == ("vacuum-reading-invalid",)
    (alarm, *_) = (one for one in said.alarms if one.name == "vacuum-reading-invalid")
    assert alarm.priority in {"medium", "high"}
    assert alarm.sentence
    assert alarm.remedy
    assert all(math.isfinite(value) for value in plain_row.numbers(said.commands))


WRONG = {
    "readings is dict: should be Readings": ({}, NO_REQUESTS, DT_S),
    "requests is NoneType: should be Requests": (readings(), None, DT_S),
    "requests is Readings: should be Requests": (readings(), readings(), DT_S),
    "readings.monitor is NoneType: should be Monitor": (readings(monitor=None), NO_REQUESTS, DT_S),
    "readings.head_mm is None: should be a number": (readings(None), NO_REQUESTS, DT_S),  # type: ignore[arg-type]
    "readings.head_mm is '3': should be a number": (readings("3"), NO_REQUESTS, DT_S),  # type: ignore[arg-type]
    "readings.head_mm is True: should be a number": (readings(True), NO_REQUESTS, DT_S),
    "readings.cam_rad is .*: should be a number": (readings(cam_rad=1j), NO_REQUESTS, DT_S),
    "readings.cam_valid is nan: should be True or False": (
        readings(cam_valid=NAN),
        NO_REQUESTS,
        DT_S,
    ),
    "readings.contact_closed is 2: should be True or False": (
        readings(contact_closed=2),
        NO_REQUESTS,
        DT_S,
    ),
    "requests.start is 'yes': should be True or False": (
        readings(),
        NO_REQUESTS._replace(start="yes"),  # type: ignore[arg-type]
        DT_S,
    ),
    "readings.head_mm is .1.0,.: should be a number": (readings((1.0,)), NO_REQUESTS, DT_S),  # type: ignore[arg-type]
    "dt_s is 0 s: should be 0.0005 to 0.002 s": (readings(), NO_REQUESTS, 0.0),
    "dt_s is -0.001 s: should be 0.0005 to 0.002 s": (readings(), NO_REQUESTS, -DT_S),
    "dt_s is 1 s: should be 0.0005 to 0.002 s": (readings(), NO_REQUESTS, 1.0),
    "dt_s is nan s: should be 0.0005 to 0.002 s": (readings(), NO_REQUESTS, NAN),
    "dt_s is inf s: should be 0.0005 to 0.002 s": (readings(), NO_REQUESTS, math.inf),
    "dt_s is None: should be a number": (readings(), NO_REQUESTS, None),
    "dt_s is '0.001': should be a number": (readings(), NO_REQUESTS, "0.001"),
    "dt_s is 0.002 s and was 0.001 s before: .* overrun=True": (readings(), NO_REQUESTS, 0.002),
}


@pytest.mark.parametrize("words", WRONG)
def test_what_is_of_another_kind_is_one_plain_error_and_changes_nothing(words: str) -> None:
    chosen = new()
    chosen.step(readings(), START, DT_S)
    before = repr(chosen.state)
    with pytest.raises(InputError, match=words) as caught:
        chosen.step(*WRONG[words])  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
    assert repr(chosen.state) == before
    assert chosen.step(readings(), NO_REQUESTS, DT_S).phase == "checking"


@cache
def worn() -> Controller:
    chosen = new()
    chosen.step(readings(), NO_REQUESTS, DT_S)
    return chosen


ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=3),
    st.tuples(st.floats()),
    st.complex_numbers(),
    st.binary(max_size=2),
)


@given(
    st.dictionaries(st.sampled_from(Readings._fields), ANYTHING, max_size=3),
    st.dictionaries(st.sampled_from(NO_REQUESTS._fields), ANYTHING, max_size=2),
)
def test_whatever_a_loop_hands_in_is_a_tick_or_a_plain_error(
    read: dict[str, Any], asked: dict[str, Any]
) -> None:
    chosen = worn()
    before = repr(chosen.state)
    try:
        said = chosen.step(readings(**read), NO_REQUESTS._replace(**asked), DT_S)
    except InputError as refused:
        assert "\n" not in str(refused)
        assert repr(chosen.state) == before
    else:
        assert all(math.isfinite(value) for value in plain_row.numbers(said.commands))


def test_what_the_host_sees_adds_an_alarm_by_name() -> None:
    chosen = new()
    for _ in range(6000):
        said = chosen.step(readings(), NO_REQUESTS, DT_S, conditions=["recorder-lost"])
    assert [alarm.name for alarm in said.alarms] == ["recorder-lost"]
    assert said.trips == ()
    assert said.phase == "parked"


def test_a_condition_that_is_not_known_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"condition 'recorder-lots'.*recorder-lost"):
        new().step(readings(), NO_REQUESTS, DT_S, conditions=["recorder-lots"])
    with pytest.raises(InputError, match="should be several names"):
        new().step(readings(), NO_REQUESTS, DT_S, conditions="recorder-lost")


def test_ticks_that_end_late_are_a_trip_once_there_are_many() -> None:
    chosen = new()
    for _ in range(200):
        said = chosen.step(readings(), NO_REQUESTS, DT_S, overrun=True)
    assert "late-ticks" in said.trips
    with pytest.raises(InputError, match="overrun is 'late': should be True or False"):
        chosen.step(readings(), NO_REQUESTS, DT_S, overrun="late")  # type: ignore[arg-type]


def test_a_state_that_is_set_goes_on_where_it_was() -> None:
    first = new()
    for tick in range(100):
        first.step(readings(), START if tick == 0 else NO_REQUESTS, DT_S)
    second = new()
    second.state = first.state
    after = [one.step(readings(), NO_REQUESTS, DT_S) for one in (first, second)]
    assert after[0] == after[1]
    assert after[0].phase == "checking"


def test_settings_alone_do_where_no_curves_are_needed() -> None:
    assert Controller(configuration().settings, catheter_age_s=0.0).settings == configuration()
    table = configuration(CompensationKind.LOOKUP_TABLE)
    with pytest.raises(InputError, match="needs curves"):
        Controller(table.settings)
    assert Controller(table).step(readings(), NO_REQUESTS, DT_S).phase == "parked"


BAD: dict[str, tuple[Any, dict[str, Any]]] = {
    "settings is dict: should be a Configuration": ({"settings": {}}, {}),
    "catheter_age_s is 'new': should be a number": ({}, {"catheter_age_s": "new"}),
    "off_s goes with kept": ({}, {"off_s": 1.0}),
    "kept is int: should be Interlocks": ({}, {"kept": 3}),
}


@pytest.mark.parametrize("words", BAD)
def test_a_controller_is_not_made_of_what_does_not_fit(words: str) -> None:
    settings, given = BAD[words]
    with pytest.raises(InputError, match=words):
        Controller(settings or configuration(), **given)


def test_the_age_of_a_catheter_is_given_once() -> None:
    first = new()
    with pytest.raises(InputError, match="give one of the two"):
        Controller(configuration(), catheter_age_s=1.0, kept=first.state.core.upkeep, off_s=1.0)


@pytest.mark.parametrize("given", [{}, {"off_s": -1.0}, {"off_s": math.inf}])
def test_how_long_no_controller_ran_must_be_known_where_something_was_kept(
    given: dict[str, float],
) -> None:
    with pytest.raises(InputError, match=r"off_s is .* s: should be 0 or more"):
        Controller(configuration(), kept=new().state.core.upkeep, **given)


FLAGGED = {
    "head_mm": "head_valid",
    "carriage_mm": "carriage_valid",
    "cam_rad": "cam_valid",
    "line_vacuum_mmhg": "vacuum_valid",
    "contact_closed": "contact_valid",
}


@pytest.mark.parametrize("name", FLAGGED)
def test_a_number_behind_a_flag_changes_nothing(name: str) -> None:
    pair: tuple[Any, Any] = (True, False) if name == "contact_closed" else (NAN, 40.0)
    first, second = new(), new()
    for one in (first, second):
        one.step(readings(), START, DT_S)
    for _ in range(200):
        hidden: list[dict[str, Any]] = [{FLAGGED[name]: False, name: value} for value in pair]
        said = [
            each.step(readings()._replace(**one), NO_REQUESTS, DT_S)
            for each, one in zip((first, second), hidden, strict=True)
        ]
        assert said[0] == said[1]
