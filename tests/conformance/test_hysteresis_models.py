"""Conformance suite of the catalogue of hysteresis models: one set of properties for all."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from opensuction.hysteresis import bouc_wen, dahl
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    VectorForm,
    invert,
    ranges_of,
    simulate,
    start,
)
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.oscillator.motion import HystereticOscillator
from opensuction.hysteresis.play import ModelState
from opensuction.identification.estimator.nonlinear import FITS
from opensuction.kernel.errors import InputError
from tests.conformance.hysteresis_cases import CASES, HIGH_MM, LOW_MM, RANGES, Case
from tests.conformance.plain import run_plain

Array = NDArray[np.float64]

every_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
timeless_cases = pytest.mark.parametrize(
    "case", [case for case in CASES.values() if not case.knows_time], ids=lambda case: case.name
)
vector_forms = pytest.mark.parametrize(
    ("model", "form"),
    [
        pytest.param(model, model.form, id=name)
        for name, model in CATALOGUE.items()
        if isinstance(model.form, VectorForm)
    ],
)
linear_forms = pytest.mark.parametrize(
    ("model", "form"),
    [
        pytest.param(model, model.form, id=name)
        for name, model in CATALOGUE.items()
        if isinstance(model.form, LinearForm)
    ],
)

places = st.floats(LOW_MM, HIGH_MM)
paths = st.lists(places, min_size=2, max_size=10).map(np.array)
memories = st.floats(-1.0, 1.0)

ROUNDING_MM = 1e-10
"""Some tens of roundings of numbers around 100, magnified where D > B in the Bouc-Wen model."""


def outputs(case: Case, path_mm: Array, memory: float) -> Array:
    return simulate(case.model, case.record, path_mm, memory)


def stepped(case: Case, path_mm: Array, memory: float) -> list[ModelState]:
    """States along a path, move by move."""
    state = start(case.model, case.record, float(path_mm[0]), memory)
    states = [case.model.step(case.record, state, 0.0)]
    for place_mm in path_mm[1:]:
        states.append(case.model.step(case.record, states[-1], float(place_mm) - states[-1][0]))
    return states


def finely(path_mm: Array, parts: int) -> Array:
    """A path with every move cut into equal parts."""
    moves = [np.linspace(a, b, parts, endpoint=False) for a, b in pairwise(path_mm)]
    return np.concatenate([*moves, path_mm[-1:]])


def test_every_model_of_the_catalogue_is_in_the_suite() -> None:
    assert {case.name for case in CASES.values()} == set(CATALOGUE)


@every_case
@given(path_mm=paths, memory=memories)
def test_a_whole_record_equals_its_steps(case: Case, path_mm: Array, memory: float) -> None:
    states = stepped(case, path_mm, memory)
    tips = [case.model.output_mm(case.record, state) for state in states]
    assert outputs(case, path_mm, memory) == pytest.approx(tips, abs=ROUNDING_MM)


@timeless_cases
@given(path_mm=paths, memory=memories, parts=st.integers(2, 9))
def test_a_move_in_pieces_is_the_same_move(
    case: Case, path_mm: Array, memory: float, parts: int
) -> None:
    whole = outputs(case, path_mm, memory)
    assert outputs(case, finely(path_mm, parts), memory)[::parts] == pytest.approx(
        whole, abs=ROUNDING_MM
    )


@timeless_cases
@given(path_mm=paths, memory=memories, pace=st.lists(st.integers(1, 5), min_size=10, max_size=10))
def test_speed_and_waiting_do_not_matter(
    case: Case, path_mm: Array, memory: float, pace: list[int]
) -> None:
    """Every move at another speed, with a rest after it."""
    moves = [
        np.append(np.linspace(a, b, parts, endpoint=False), [b] * parts)
        for (a, b), parts in zip(pairwise(path_mm), pace, strict=False)
    ]
    ends = np.cumsum([move.size for move in moves]) - 1
    warped = outputs(case, np.concatenate(moves), memory)[ends]
    assert warped == pytest.approx(outputs(case, path_mm, memory)[1:], abs=ROUNDING_MM)


@pytest.mark.parametrize(
    "case", [case for case in CASES.values() if case.knows_time], ids=lambda case: case.name
)
def test_a_model_that_knows_time_tells_fast_from_slow_and_comes_to_rest(case: Case) -> None:
    path_mm = np.array([10.0, 80.0])
    fast, slow = outputs(case, path_mm, 0.0), outputs(case, finely(path_mm, 200), 0.0)
    assert abs(fast[-1] - slow[-1]) > 0.1
    rests = [
        outputs(case, np.append(path, [80.0] * 400), 0.0)[-1]
        for path in (path_mm, finely(path_mm, 200))
    ]
    assert rests[0] == pytest.approx(rests[1], abs=ROUNDING_MM)


@timeless_cases
@given(path_mm=paths, memory=memories)
def test_no_move_changes_nothing_and_a_step_keeps_the_old_state(
    case: Case, path_mm: Array, memory: float
) -> None:
    state = stepped(case, path_mm, memory)[-1]
    kept = np.copy(state.memory)
    still = case.model.step(case.record, state, 0.0)
    assert still.head_mm == state.head_mm
    assert np.array_equal(still.memory, kept)
    case.model.step(case.record, state, 17.0)
    assert np.array_equal(state.memory, kept)


@every_case
def test_a_record_leaves_its_input_and_its_memory_alone(case: Case) -> None:
    path_mm = np.array([0.0, 30.0, 10.0])
    memory = case.model.memory(case.record, 0.0, -1.0)
    kept = np.copy(memory)
    case.model.simulate(case.record, path_mm, memory)
    assert path_mm.tolist() == [0.0, 30.0, 10.0]
    assert np.array_equal(memory, kept)


@every_case
@given(path_mm=paths, memory=memories)
def test_a_long_stroke_forgets_the_past(case: Case, path_mm: Array, memory: float) -> None:
    stroke_mm = np.append(path_mm, path_mm[-1] - case.forgetting_mm)
    last = [outputs(case, stroke_mm, past)[-1] for past in (memory, -1.0)]
    assert last[0] == pytest.approx(last[1], abs=2e-9)


@timeless_cases
def test_a_past_of_one_is_a_long_stroke(case: Case) -> None:
    """What `memory` promises: +1 after a long advance, -1 after a long retract."""
    for memory in (-1.0, 1.0):
        stroke_mm = np.array([50.0 - memory * case.forgetting_mm, 50.0, 30.0, 60.0])
        assert outputs(case, stroke_mm, 0.0)[1:] == pytest.approx(
            outputs(case, stroke_mm[1:], memory), abs=2e-9
        )


@pytest.mark.parametrize(
    "case", [case for case in CASES.values() if case.closes_minor_loops], ids=lambda case: case.name
)
@given(ends=st.tuples(places, places), share=st.floats(0.05, 0.95), past_mm=paths)
def test_a_minor_loop_of_plays_and_relays_closes(
    case: Case, ends: tuple[float, float], share: float, past_mm: Array
) -> None:
    """Return-point memory: an excursion inside a move, once closed, is wiped out."""
    assume(abs(ends[0] - ends[1]) > 1.0)
    turn_mm = ends[0] + share * (ends[1] - ends[0])
    path_mm = np.array([*past_mm, ends[0], ends[1], turn_mm, ends[1]])
    tips = outputs(case, path_mm, 0.0)
    assert tips[-1] == pytest.approx(tips[-3], abs=ROUNDING_MM)


@pytest.mark.parametrize(
    "case",
    [case for case in CASES.values() if not case.closes_minor_loops],
    ids=lambda case: case.name,
)
def test_the_other_models_drift_in_minor_loops(case: Case) -> None:
    """So their docstrings say: the loop does not come back to where it left."""
    tips = outputs(case, np.array([0.0, 40.0, 38.0, 40.0]), -1.0)
    assert abs(tips[-1] - tips[-3]) > 1e-4


@pytest.mark.parametrize(
    "case", [case for case in CASES.values() if case.loop_sign != 0], ids=lambda case: case.name
)
@given(turns=st.lists(places, min_size=1, max_size=5))
def test_steady_loops_turn_the_way_of_their_kind(case: Case, turns: list[float]) -> None:
    """The area of a closed cycle, as `loop_sign` says it."""
    cycle = np.array([LOW_MM, HIGH_MM, *turns])
    settled = np.concatenate([np.tile(cycle, 12), finely(np.append(cycle, LOW_MM), 400)])
    x_mm = settled[-(400 * cycle.size + 1) :]
    y_mm = outputs(case, settled, 0.0)[-x_mm.size :]
    area = float(np.sum(0.5 * (y_mm[1:] + y_mm[:-1]) * np.diff(x_mm)))
    # The stroke over the whole range always encloses something; 400 parts see it to a percent.
    assert area * case.loop_sign > 0.0


@every_case
@given(path_mm=paths, memory=memories)
def test_the_flag_of_monotonicity_is_true(case: Case, path_mm: Array, memory: float) -> None:
    assert case.model.is_monotone(case.record) == case.monotone
    if case.monotone:
        fine_mm = finely(path_mm, 20)
        moves, gains = np.diff(fine_mm), np.diff(outputs(case, fine_mm, memory))
        told_apart = np.abs(moves) > 1e-6
        assert np.all(np.sign(gains[told_apart]) == np.sign(moves[told_apart]))


@pytest.mark.parametrize(
    "case", [case for case in CASES.values() if not case.monotone], ids=lambda case: case.name
)
def test_a_model_that_is_not_monotone_fails_to_follow_a_reversal(case: Case) -> None:
    path_mm = np.array([50.0 - case.forgetting_mm, 50.0, 49.9])
    tips = outputs(case, path_mm, 0.0)
    assert tips[2] >= tips[1]


TOLD_SHARE = 1e-6
"""Least share of F_c left at which a Dahl force tells its input: the slope is as much smaller, and
roundings of 4e-16 N come back as 1e-8 mm at most."""
SLIDING_SHARE = 1e-14
"""Share of F_c below which its roundings decide whether a Dahl force slides."""


def is_told(case: Case, path_mm: Array, wanted: Array) -> bool:
    """Whether the outputs tell every move: no Dahl force ends a move in sliding.

    There alone an output stands still, to rounding, while the input moves on.
    """
    if not isinstance(case.record, Dahl):
        return True
    direction = np.sign(np.diff(path_mm))
    left = 1.0 - direction * wanted[1:] / case.record.coulomb_n
    return bool(np.all(left[direction != 0.0] >= TOLD_SHARE))


def is_sliding(case: Case, target: float) -> bool:
    """Whether a target is F_c but for its rounding: no finite move need meet it."""
    if not isinstance(case.record, Dahl):
        return False
    return abs(target) >= case.record.coulomb_n * (1.0 - SLIDING_SHARE)


@every_case
@given(path_mm=paths, memory=memories)
def test_the_inverse_undoes_the_model(case: Case, path_mm: Array, memory: float) -> None:
    wanted = outputs(case, path_mm, memory)
    state = start(case.model, case.record, float(path_mm[0]), memory)
    inputs_mm, reached = invert(case.model, case.record, state, wanted)
    if case.monotone and is_told(case, path_mm, wanted):
        assert reached.all()
        # Slopes down to .03: the output's rounding, through the inverse of every move.
        assert inputs_mm == pytest.approx(path_mm, abs=1e-6)
    state = start(case.model, case.record, float(path_mm[0]), memory)
    for target_mm in wanted:
        found = case.model.inverse_step(case.record, state, float(target_mm))
        state = case.model.step(case.record, state, found.move_mm)
        if not is_sliding(case, float(target_mm)):
            assert found.reached != case.refuses_inverse
        if found.reached:
            assert case.model.output_mm(case.record, state) == pytest.approx(
                target_mm, abs=ROUNDING_MM
            )


@every_case
@pytest.mark.parametrize("target_mm", [float("nan"), float("inf")])
def test_a_target_that_is_no_number_is_refused(case: Case, target_mm: float) -> None:
    state = start(case.model, case.record, 50.0, 0.0)
    assert case.model.inverse_step(case.record, state, target_mm) == (0.0, False)


FORGETTING_MM: dict[str, Callable[[Any], float]] = {
    "dahl": dahl.saturation_mm,
    "modified-dahl": lambda record: 1.0 / record.decay_per_mm,
    "bouc-wen": lambda record: bouc_wen.saturation_mm(record) / record.input_gain,
}
"""Travel over which a reversal is forgotten to a third or so."""


@vector_forms
@given(data=st.data())
def test_every_vector_within_bounds_is_a_model_that_forgets_its_last_number(
    model: HysteresisModel, form: VectorForm, data: st.DataObject
) -> None:
    low, high = form.bounds(RANGES).T
    shares = data.draw(st.lists(st.floats(0.0, 1.0), min_size=low.size, max_size=low.size))
    vector = low + np.array(shares) * (high - low)
    record = form.record(vector)
    assert model.is_well_posed(record)
    path_mm = np.array([0.0, 100.0, 3.0, 55.0, 54.9])
    assert np.isfinite(form.simulate(vector, path_mm)).all()
    # A stroke over which the start decays to e^-40 and less; then only the record decides.
    far_mm = 60.0 * FORGETTING_MM[model.name](record)
    stroke_mm = np.array([0.0, far_mm, far_mm - 30.0, far_mm + 5.0])
    tips_mm = form.simulate(vector, stroke_mm)[1:]
    own_mm = simulate(model, record, stroke_mm, 0.0)[1:]
    scale = 1e-12 * float(np.abs(own_mm).max())
    assert np.diff(tips_mm) == pytest.approx(np.diff(own_mm), rel=1e-9, abs=scale)


@vector_forms
def test_parameters_of_a_vector_have_names_units_and_bounds(
    model: HysteresisModel, form: VectorForm
) -> None:
    assert model.name in FITS
    names = [parameter.name for parameter in form.parameters]
    assert len(set(names)) == len(names)
    assert "offset" in names
    assert names[-1].startswith("initial_")
    bounds = form.bounds(RANGES)
    assert bounds.shape == (len(names), 2)
    assert np.all(bounds[:, 0] < bounds[:, 1])
    for parameter, (low, _) in zip(form.parameters, bounds, strict=True):
        assert parameter.unit in {"{out}/{in}", "{in}", "{out}", "1/{in}", "1"}
        assert low > 0.0 or not parameter.logarithmic


@linear_forms
@given(path_mm=paths, memory=memories, data=st.data())
def test_a_linear_model_is_its_basis_times_its_factors(
    model: HysteresisModel, form: LinearForm, path_mm: Array, memory: float, data: st.DataObject
) -> None:
    guess = data.draw(st.sampled_from(form.initial_guesses(RANGES)))
    columns = form.basis(guess, path_mm, model.memory(guess, path_mm[0], memory))
    size = columns.shape[1]
    assert simulate(model, guess, path_mm, memory).tolist() == [0.0] * path_mm.size
    factors = np.array(data.draw(st.lists(st.floats(0.0, 9.0), min_size=size, max_size=size)))
    record = form.with_factors(guess, factors)
    assert columns @ factors == pytest.approx(simulate(model, record, path_mm, memory), abs=1e-9)
    parameters = form.parameters(guess, RANGES)
    assert len({parameter.name for parameter in parameters}) == size
    # The constant, then powers of the place in the range; beside it nothing is constant.
    constant = size - 1 - form.degree(guess)
    assert columns[:, constant] == pytest.approx(1.0)
    assert parameters[constant].unit == "{out}"


@every_case
def test_parameters_are_fields_with_their_units(case: Case) -> None:
    model = case.model
    fields: tuple[str, ...] = type(case.record)._fields
    names = [parameter.name for parameter in model.parameters]
    assert names == [field for field in fields if field in names]
    for parameter in model.parameters:
        for suffix, unit in (
            ("_n_per_mm", "N/mm"),
            ("_per_mm", "1/mm"),
            ("_mm", "mm"),
            ("_n", "N"),
        ):
            if parameter.name.endswith(suffix):
                assert parameter.unit == unit
                break
        assert parameter.symbol
        assert parameter.meaning
    assert model.summary
    assert model.cannot
    assert model.inverse
    assert model.source


@every_case
@pytest.mark.parametrize(
    ("path", "memory", "message"),
    [
        ([0.0, float("nan"), 1.0, float("inf")], 0.0, "sample 1 is nan.*2 such of 4"),
        ([[0.0, 1.0]], 0.0, "one row"),
        ([], 0.0, "one row"),
        ([0.0, 1.0], 1.5, "from -1 to 1"),
        ([0.0, 1.0], float("nan"), "from -1 to 1"),
    ],
)
def test_bad_input_is_refused_in_one_line(
    case: Case, path: list[Any], memory: float, message: str
) -> None:
    with pytest.raises(InputError, match=message) as refusal:
        simulate(case.model, case.record, path, memory)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", ["dahl", "modified dahl, published", "bouc-wen, passive", "play"])
def test_a_record_that_is_not_well_posed_is_refused(name: str) -> None:
    case = CASES[name]
    wrong = type(case.record)(*(-abs(value) for value in case.record))
    assert not case.model.is_well_posed(wrong)
    message = f"{case.name}: parameters -{case.record[0]:.6g}, .* not well posed"
    with pytest.raises(InputError, match=message):
        simulate(case.model, wrong, np.array([0.0, 1.0]), 0.0)


@every_case
def test_the_compiled_core_does_not_hide_an_input_that_is_no_number(case: Case) -> None:
    """A play is the exception, and says so: it stays where it was."""
    memory = case.model.memory(case.record, 0.0, 0.0)
    tips = case.model.simulate(case.record, np.array([0.0, 20.0, np.nan, 30.0]), memory)
    assert np.isfinite(tips[:2]).all()
    assert np.isnan(tips[2]) or case.name == "play"


def test_ranges_want_a_recording_that_moves() -> None:
    ranges = ranges_of(np.array([0.0, 4.0, 1.0]), np.array([-1.0, 7.0, 3.0]))
    assert ranges == (0.0, 4.0, -1.0, 7.0, 3.0)
    assert (ranges.input_mm, ranges.output_mm, ranges.gain) == (4.0, 8.0, 2.0)
    for constant in (np.ones(3), np.array([0.0, np.nan, 1.0])):
        with pytest.raises(InputError, match="output: constant or not a number"):
            ranges_of(np.array([0.0, 4.0, 1.0]), constant)


def results() -> dict[str, list[float]]:
    """Every function of every case over a path; floats."""
    path_mm = 50.0 * (1.0 - np.cos(np.linspace(0.0, 12.0, 120)))
    values: dict[str, list[float]] = {}
    for name, case in CASES.items():
        model, record = case.model, case.record
        row = [*outputs(case, path_mm, -1.0), *outputs(case, path_mm, 0.3)]
        state = start(model, record, 20.0, 0.5)
        for move_mm in (3.0, -0.01, -25.0, 60.0):
            state = model.step(record, state, move_mm)
            found = model.inverse_step(record, state, 31.0)
            row += [model.output_mm(record, state), found.move_mm, float(found.reached)]
        if isinstance(model.form, LinearForm):
            row += list(model.form.basis(record, path_mm, state.memory).ravel())
        row += [float(model.is_well_posed(record)), float(model.is_monotone(record))]
        values[name] = [float(value) for value in row]
    oscillator = HystereticOscillator(2.0, 10.0, 5e4, 5e4, 90.0, 30.0, 1.5)
    values["oscillator"] = oscillator.simulate(path_mm, 750.0).tolist()
    return values


def test_compiled_equals_plain_python() -> None:
    plain = run_plain("tests.conformance.test_hysteresis_models", "results")
    assert isinstance(plain, dict)
    compiled = results()
    assert plain.keys() == compiled.keys()
    for name, row in compiled.items():
        # Same library functions; a fused multiply-add may differ in the last bit and then add
        # up, and the inverse passes it on through slopes down to .03.
        assert row == pytest.approx(plain[name], rel=1e-9, abs=1e-9), name
