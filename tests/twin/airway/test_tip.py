"""The tip at the carina: springs in series, limited by buckling."""

import math

from hypothesis import given
from hypothesis import strategies as st

from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import Tip

PVC = Tip(carina_n_per_mm=0.5, catheter_n_per_mm=0.9, buckling_n=0.2, post_buckling_ratio=0.05)
TIPS = st.builds(
    Tip,
    carina_n_per_mm=st.floats(0.1, 10.0),
    catheter_n_per_mm=st.floats(0.3, 2.0),
    buckling_n=st.floats(0.05, 0.5),
    post_buckling_ratio=st.floats(0.01, 0.2),
)


def test_short_of_the_carina_nothing_presses() -> None:
    assert airway.touch(PVC, 70.0, 69.9) == (69.9, 0.0)


def test_two_springs_share_the_overlap() -> None:
    touched = airway.touch(PVC, 70.0, 70.2)
    force = 0.2 / (1 / 0.5 + 1 / 0.9)
    assert math.isclose(touched.force_n, force)
    assert math.isclose(touched.tip_mm, 70.0 + force / 0.5)


def test_a_buckled_tip_presses_little_harder() -> None:
    deep = airway.touch(PVC, 70.0, 80.0)
    assert PVC.buckling_n < deep.force_n < 0.4  # 10 mm of overlap would be 3.2 N unbuckled


@given(TIPS, st.floats(0.0, 30.0), st.floats(0.0, 5.0))
def test_force_grows_with_the_overlap_and_never_jumps(
    shape: Tip, overlap: float, more: float
) -> None:
    here = airway.touch(shape, 70.0, 70.0 + overlap)
    there = airway.touch(shape, 70.0, 70.0 + overlap + more)
    stiffest = 1.0 / (1.0 / shape.carina_n_per_mm + 1.0 / shape.catheter_n_per_mm)
    assert here.force_n <= there.force_n + 1e-12
    assert there.force_n - here.force_n <= stiffest * more + 1e-9
    assert 70.0 <= here.tip_mm <= 70.0 + overlap + 1e-9
