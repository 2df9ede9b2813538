"""Clinical protocols fit the patient, the machine and the guidelines, or are refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.planning import clinical, planner
from opensuction.procedure.planning.clinical import ADULT, PAEDIATRIC
from opensuction.procedure.planning.planner import Abilities
from opensuction.procedure.planning.protocol import Site

BEDSIDE = Abilities(
    head_mm_per_s=50.0,
    acceleration_mm_per_s2=200.0,
    park_head_mm=-105.0,
    settle_mm=0.25,
    cam_open_rad=math.radians(30.0),
    cam_rad_per_s=math.radians(60.0),
    gap_in_mm=16.5,
    gap_out_mm=16.5,
    relief_mmhg=95.0,  # of a neonate: it protects all others, too
    jog_mm=2.0,
    pump_mmhg_per_s=285.0,
    pump_occluded_mmhg=560.0,
    turn_mm=16.5,
)
PAPER_VALVE = BEDSIDE._replace(cam_rad_per_s=math.radians(15.0))
GROWN = Site(
    park_mm=-100.0,
    boundary_mm=-80.0,
    fast_mm_per_s=30.0,
    tube_mm=8.5,
    catheter_mm=4.0,
    carina_mm=70.0,
    age=AgeGroup.ADULT,
    peep_cmh2o=6.0,
    monitored=True,
    breathes=False,
)
CHILD = Site(
    park_mm=-62.0,
    boundary_mm=-42.0,
    fast_mm_per_s=30.0,
    tube_mm=4.5,
    catheter_mm=2.0,
    carina_mm=15.0,
    age=AgeGroup.CHILD,
    peep_cmh2o=5.0,
    monitored=True,
    breathes=False,
)
NEONATE = CHILD._replace(tube_mm=3.5, carina_mm=12.0, age=AgeGroup.NEONATE)


@pytest.mark.parametrize("by_contact", [False, True])
def test_adult_dwells_for_what_the_15_s_leave(by_contact: bool) -> None:
    protocol = clinical.fitted(ADULT, BEDSIDE, GROWN, by_contact)
    times = planner.timeline(protocol, BEDSIDE, GROWN, by_contact)
    assert times.negative_pressure == pytest.approx(15.0 - clinical.TIME_MARGIN_S)
    assert 7.4 <= protocol.dwell_s <= 8.8  # [calc-timeline]: 7.4 to 8.6 s
    assert times.in_airway + clinical.IN_AIRWAY_MARGIN_S == protocol.in_airway_budget_s


def test_a_lung_that_peep_holds_open_is_sucked_for_10_s_at_most() -> None:
    for peep_cmh2o, budget_s in ((9.9, 15.0), (10.0, 10.0), (12.0, 10.0)):
        site = GROWN._replace(peep_cmh2o=peep_cmh2o)
        protocol = clinical.fitted(ADULT, BEDSIDE, site, by_contact=True)
        assert protocol.negative_pressure_budget_s == budget_s
        times = planner.timeline(protocol, BEDSIDE, site, by_contact=True)
        assert times.negative_pressure == pytest.approx(budget_s - clinical.TIME_MARGIN_S)
    small = clinical.fitted(PAEDIATRIC, BEDSIDE, CHILD._replace(peep_cmh2o=12.0), by_contact=True)
    assert small.negative_pressure_budget_s == 5.0
    stiff = GROWN._replace(peep_cmh2o=12.0, carina_mm=100.0)
    slow = PAPER_VALVE._replace(cam_rad_per_s=0.5 * PAPER_VALVE.cam_rad_per_s)
    with pytest.raises(InputError, match=r"10 s \(PEEP of 12 cmH2O\) - withdrawal"):
        clinical.fitted(ADULT, slow, stiff, by_contact=False)


def test_travel_stops_short_of_the_carina_and_contact_backs_off() -> None:
    travel = clinical.fitted(ADULT, BEDSIDE, GROWN, by_contact=False)
    contact = clinical.fitted(ADULT, BEDSIDE, GROWN, by_contact=True)
    assert (
        travel.travel_mm == GROWN.carina_mm - 13.0
    )  # 10 from the carina, and what a hand teaches too deep
    assert contact.contact_from_mm < GROWN.carina_mm < contact.travel_mm
    assert contact.backoff_mm == 10.0
    for protocol in (travel, contact):
        assert protocol.cap_mm - protocol.travel_mm >= planner.CAP_MARGIN_MM


@pytest.mark.parametrize("site", [CHILD, NEONATE], ids=["child", "neonate"])
def test_small_patients_stay_within_5_s(site: Site) -> None:
    protocol = clinical.fitted(PAEDIATRIC, BEDSIDE, site, by_contact=False)
    assert planner.timeline(protocol, BEDSIDE, site, by_contact=False).negative_pressure < 5.0
    assert protocol.dwell_s > 1.0


@pytest.mark.parametrize("site", [CHILD, NEONATE], ids=["child", "neonate"])
def test_the_papers_valve_is_too_slow_for_5_s_and_the_message_reckons_it(site: Site) -> None:
    with pytest.raises(InputError, match=r"5 s - withdrawal .* valve closing 2\.0 s") as refused:
        clinical.fitted(PAEDIATRIC, PAPER_VALVE, site, by_contact=False)
    assert "\n" not in str(refused.value)


@pytest.mark.requirement("OS-R24")
def test_a_protocol_for_another_age_is_refused() -> None:
    with pytest.raises(InputError, match="this protocol is for adult, the patient is neonate"):
        clinical.fitted(ADULT, BEDSIDE, NEONATE, by_contact=False)


@pytest.mark.requirement("OS-R23")
def test_a_catheter_too_wide_for_the_tube_is_refused_with_the_ratio() -> None:
    with pytest.raises(InputError, match=r"catheter over tube diameter would be 0\.533"):
        clinical.fitted(ADULT, BEDSIDE, GROWN._replace(tube_mm=7.5), by_contact=False)


@pytest.mark.requirement("OS-R24")
@given(st.floats(30.0, 110.0), st.floats(50.0, 100.0), st.floats(10.0, 40.0), st.booleans())
def test_whatever_is_fitted_holds_every_guideline(
    carina: float, tube: float, withdrawal: float, by_contact: bool
) -> None:
    site = GROWN._replace(carina_mm=carina, boundary_mm=-tube, park_mm=-tube - 20.0)
    template = ADULT._replace(withdrawal_mm_per_s=withdrawal)
    try:
        protocol = clinical.fitted(template, BEDSIDE, site, by_contact)
    except InputError as refused:
        assert "\n" not in str(refused)
        return
    held = clinical.held_against_guidelines(protocol, BEDSIDE, site, by_contact)
    assert all(check.ok for check in held)
    planner.check(protocol, BEDSIDE, site, by_contact)


def test_the_widest_catheter_that_fits_is_named() -> None:
    clinical.check_catheter(GROWN)
    with pytest.raises(InputError, match=r"0\.5 = 4 mm / 8 mm.* under 4 mm \(12 Fr\)"):
        clinical.check_catheter(GROWN._replace(tube_mm=8.0))


def test_a_carina_too_near_to_stop_short_of_is_refused() -> None:
    with pytest.raises(InputError, match=r"9\.0 mm below it - 10 mm to stop short = -1\.0 mm"):
        clinical.fitted(PAEDIATRIC, BEDSIDE, NEONATE._replace(carina_mm=9.0), by_contact=False)


@pytest.mark.parametrize("by_contact", [False, True])
@pytest.mark.parametrize("site", [GROWN, CHILD, NEONATE], ids=["adult", "child", "neonate"])
def test_what_is_fitted_is_not_too_deep_and_1_mm_more_than_allowed_is(
    site: Site, by_contact: bool
) -> None:
    template = ADULT if site.age == AgeGroup.ADULT else PAEDIATRIC
    protocol = clinical.fitted(template, BEDSIDE, site, by_contact)
    clinical.check_depth(protocol, site, by_contact)
    margin = planner.CAP_MARGIN_MM
    deeper = protocol._replace(cap_mm=site.carina_mm + template.window_mm + margin + 1.0)
    with pytest.raises(InputError, match=r"is too deep for this patient"):
        clinical.check_depth(deeper, site, by_contact)


def test_a_cap_must_leave_by_what_a_hand_teaches_too_deep() -> None:
    """Taught 70 mm, the carina may be at 66: a cap there is allowed, one deeper is not."""
    protocol = clinical.fitted(ADULT, BEDSIDE, GROWN, by_contact=False)
    clinical.check_depth(protocol._replace(cap_mm=66.0), GROWN, by_contact=False)
    with pytest.raises(InputError, match=r"taught length is 70\.0 mm - 4, .* = 66\.0 mm") as told:
        clinical.check_depth(protocol._replace(cap_mm=66.1), GROWN, by_contact=False)
    assert "travel_mm to at most 61.0 mm" in str(told.value)


def test_a_window_that_begins_below_the_carina_is_refused() -> None:
    protocol = clinical.fitted(ADULT, BEDSIDE, GROWN, by_contact=True)
    with pytest.raises(InputError, match=r"contact_from_mm 66 mm is not above .* = 66\.0 mm"):
        clinical.check_depth(protocol._replace(contact_from_mm=66.0), GROWN, by_contact=True)


@pytest.mark.parametrize(
    ("site", "most_mmhg"),
    [(GROWN, 150.0), (CHILD, 120.0), (NEONATE, 100.0)],
    ids=["adult", "child", "neonate"],
)
def test_a_relief_valve_that_opens_above_the_ages_limit_is_refused(
    site: Site, most_mmhg: float
) -> None:
    template = ADULT if site is GROWN else PAEDIATRIC
    on_it = BEDSIDE._replace(relief_mmhg=most_mmhg)
    assert clinical.fitted(template, on_it, site, by_contact=False).vacuum_mmhg < most_mmhg
    above_it = BEDSIDE._replace(relief_mmhg=most_mmhg + 1.0)
    with pytest.raises(InputError, match=f"opens at {most_mmhg + 1.0:g} mmHg"):
        clinical.fitted(template, above_it, site, by_contact=False)
