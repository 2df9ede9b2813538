import json
import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control.compensation import ON_TABLE, Branches, CompensationKind
from opensuction.controller import configuration, setup
from opensuction.controller.calibration import Feedforward, assume_nominal
from opensuction.controller.configuration import Configuration
from opensuction.controller.machine_profile import BENCH
from opensuction.controller.record import Settings
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER

FOUND = assume_nominal(PUBLISHED, Feedforward(velocity_v_s_per_mm=1.28, friction_v=0.5))


def of_kind(kind: CompensationKind) -> Configuration:
    settings = setup.settings(BENCH, PAPER, kind, FOUND, by_contact=False, site=BENCH_SITE)
    return Configuration(settings, setup.branches(kind, FOUND))


PREVIEW = of_kind(CompensationKind.PREVIEW)
CURVED = of_kind(CompensationKind.LOOKUP_TABLE)
TABLED = configuration.to_json(of_kind(CompensationKind.MODEL_PREVIEW))
ROW = plain_row.pack(Settings, PREVIEW.settings)
FREE = [
    i
    for i, column in enumerate(row.layout(Settings))
    if column.kind is float and column.name.startswith("plan.")
]
"""Where a settings' row may have any number above 0."""


def is_same(one: Configuration, other: Configuration) -> bool:
    first, second = (plain_row.pack(Settings, each.settings).tobytes() for each in (one, other))
    if one.heads_mm is None or other.heads_mm is None:
        return first == second and one.heads_mm is other.heads_mm
    return first == second and one.heads_mm.tobytes() == other.heads_mm.tobytes()


@pytest.mark.parametrize("kind", CompensationKind)
def test_every_kind_comes_back_bit_for_bit(kind: CompensationKind) -> None:
    chosen = of_kind(kind)
    text = configuration.to_json(chosen)
    back = configuration.from_json(text)
    assert is_same(back, chosen)
    assert configuration.to_json(back) == text
    assert "\n" not in text
    assert (chosen.heads_mm is not None) == (kind in ON_TABLE)


@given(
    st.dictionaries(
        st.sampled_from(FREE), st.floats(0.0, allow_infinity=False, allow_subnormal=True)
    )
)
def test_any_number_comes_back_bit_for_bit(changes: dict[int, float]) -> None:
    values = ROW.copy()
    for place, value in changes.items():
        values[place] = value
    chosen = Configuration(plain_row.unpack(Settings, values))
    back = configuration.from_json(configuration.to_json(chosen))
    assert is_same(back, chosen)
    assert configuration.hash_of(back) == configuration.hash_of(chosen)


@given(st.sampled_from(FREE))
def test_the_last_bit_of_a_number_changes_the_hash(place: int) -> None:
    values = ROW.copy()
    before = float(values[place])
    values[place] = 0.0 if math.isinf(before) else math.nextafter(before, math.inf)
    chosen = Configuration(plain_row.unpack(Settings, values))
    assert configuration.hash_of(chosen) != configuration.hash_of(PREVIEW)


def test_the_hash_is_of_what_is_set_and_not_of_how_it_is_written() -> None:
    assert re.fullmatch("[0-9a-f]{64}", configuration.hash_of(PREVIEW))
    settings = PREVIEW.settings
    motion = settings.plan.motion
    target = np.float64(motion.target_mm)
    other = settings._replace(plan=settings.plan._replace(motion=motion._replace(target_mm=target)))
    assert configuration.hash_of(Configuration(other)) == configuration.hash_of(PREVIEW)
    assert CURVED.heads_mm is not None
    bent = CURVED.heads_mm.copy()
    bent[1, 1] = math.nextafter(bent[1, 1], math.inf)
    assert configuration.hash_of(CURVED._replace(heads_mm=bent)) != configuration.hash_of(CURVED)


def changed(key: str, value: Any) -> str:
    whole = json.loads(configuration.to_json(CURVED))
    whole["settings"][key] = value
    return json.dumps(whole)


def with_heads(heads_mm: Any, text: str = "") -> str:
    return json.dumps(json.loads(text or configuration.to_json(CURVED)) | {"heads_mm": heads_mm})


NO_SHAPE = "heads_mm should be null or lists of as many numbers"
BAD = {
    "{": "no JSON: ",
    "[" * 100_000: "no JSON: ",
    '{"a": 1, "a": 2}': "no JSON: a field is there twice",
    '{"a": NaN}': "no JSON: NaN is no number of JSON",
    "[]": "should be an object of 'heads_mm' and 'settings'",
    '{"settings": {}}': "should be an object of 'heads_mm' and 'settings'",
    '{"settings": {}, "heads_mm": null}': "'plan.motion.park_mm', .* more: not there",
    changed("plan.motion.target", 3.0): "'plan.motion.target': not known",
    changed("plan.motion.target_mm", "deep"): "plan.motion.target_mm is 'deep': should be a number",
    changed("limits.vacuum_mmhg", "nan"): "settings.limits.vacuum_mmhg is nan",
    changed("compensation.kind", 99): "compensation.kind is 99: no compensator has that number",
    changed("compensation.kind", 6): "compensation 'preview' goes by no curves: see heads_mm",
    with_heads(None): "compensation 'lookup-table' needs curves, and there are none: see heads_mm",
    with_heads([[1.0, 2.0]]): "heads_mm is 1 x 2 numbers: should be two branches",
    with_heads([[1.0], [2.0]]): "heads_mm is 2 x 1 numbers: should be two branches of 2 entries",
    with_heads([[1.0, 2.0], [1.0]]): NO_SHAPE,
    with_heads([[1.0, "2"], [1.0, 2.0]]): NO_SHAPE,
    with_heads([1.0, 2.0]): NO_SHAPE,
    with_heads([[1.0, 10**400], [1.0, 2.0]]): "heads_mm has a number that is not finite",
    with_heads(None, TABLED): "'model-preview' needs a table, and there is none: see heads_mm",
    with_heads([[1.0, 2.0]] * 3, TABLED): "heads_mm is 3 x 2 numbers: should be a row for the",
    with_heads([[1.0] * 6] * 2000, TABLED): "heads_mm is 2000 x 6 numbers: should be at most 10000",
    with_heads([[1.0, -7.0, 1.0, 0.0], [20.0, 0.0, -0.9, 0.0]], TABLED): (
        "no head can be driven by the model of heads_mm: it is not monotone: a gain is -0.9"
    ),
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_text_that_is_no_configuration_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match=f"controller settings: {BAD[text]}|{BAD[text]}") as caught:
        configuration.from_json(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "heads_mm"),
    [(CompensationKind.PREVIEW, CURVED.heads_mm), (CompensationKind.GAP_WIDTH, None)],
)
def test_curves_that_do_not_go_with_the_compensator_are_refused(
    kind: CompensationKind, heads_mm: Branches | None
) -> None:
    with pytest.raises(InputError, match="see heads_mm"):
        configuration.check(Configuration(of_kind(kind).settings, heads_mm))
