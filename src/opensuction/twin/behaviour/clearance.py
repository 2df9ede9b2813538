"""Spontaneous transport of secretions: cilia and coughs carry them up, some adhere, some lie deep.

Loose ones lie in the trachea's bins, where suction can reach them. Adherent ones cling to its wall
from the tube to the carina and come loose slowly. Deep ones lie below the carina and come up with
the others. A cough brings some of the topmost out through the tube. Their total is conserved.
"""

from typing import NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.twin.airway.secretion import BIN_MM, Bins

DEEP_MM = 50.0
"""[assumed] Way from where deep secretions lie to the carina."""
LEAST_RESISTANCE, MOST_RESISTANCE = 0.5, 4.0
"""[assumed] Bounds of what secretions make of the resistance."""


class Clearance(NamedTuple):
    """Clearance of one patient's secretions by cilia and coughs."""

    cilia_mm_per_s: float
    """Speed at which cilia carry them."""
    cough_mm_per_s_per_cmh2o: float
    """Speed for each cmH2O by which the muscles push."""
    expelled_share: float
    """Share of what a cough drives out of the topmost bin that leaves through the tube."""
    adherent_share: float
    """Share of the secretions that stick."""
    loosening_s: float
    """Time constant of their coming loose."""
    deep_share: float
    """Share of the secretions that lie below the carina."""
    resistance_share: float
    """Share of the airways' resistance that goes when all of the usual secretions are gone."""
    usual_ml: float
    """Secretions with which the resistance is as stated, in mL."""


class Store(NamedTuple):
    """Secretions that suction does not reach, in mL."""

    adherent_ml: float
    """On the whole wall: a second array of bins would cost every tick of the machine."""
    deep_ml: float
    expelled_ml: float
    """Coughed out so far."""


def part(clearance: Clearance, secretion_ml: Bins) -> tuple[Bins, Store]:
    """Secretions as they lie at first, parted into loose ones and the others."""
    loose_share = 1.0 - clearance.adherent_share - clearance.deep_share
    store = Store(
        adherent_ml=clearance.adherent_share * float(secretion_ml.sum()),
        deep_ml=clearance.deep_share * float(secretion_ml.sum()),
        expelled_ml=0.0,
    )
    return loose_share * secretion_ml, store


EMPTY = Store(adherent_ml=0.0, deep_ml=0.0, expelled_ml=0.0)
"""Nothing that suction does not reach."""


@compiled
def resistance_ratio(clearance: Clearance, loose_ml: Bins, store: Store) -> float:
    """Resistance of the airways over the stated one: it grows with what has gathered."""
    gathered_ml = store.adherent_ml + store.deep_ml
    for i in range(loose_ml.size):
        gathered_ml += loose_ml[i]
    ratio = 1.0 + clearance.resistance_share * (gathered_ml / clearance.usual_ml - 1.0)
    return min(max(ratio, LEAST_RESISTANCE), MOST_RESISTANCE)


@compiled
def _carry(clearance: Clearance, loose_ml: Bins, muscle_cmh2o: float, dt_s: float) -> float:
    """Move what is loose upwards by one step, upwind; returns what leaves through the tube.

    loose_ml: written. In the topmost bin cilia end: only a cough takes anything further.
    """
    coughed_mm_per_s = clearance.cough_mm_per_s_per_cmh2o * max(muscle_cmh2o, 0.0)
    coughed = min(coughed_mm_per_s * dt_s / BIN_MM, 1.0)
    share = min((clearance.cilia_mm_per_s + coughed_mm_per_s) * dt_s / BIN_MM, 1.0)
    expelled_ml = float(clearance.expelled_share * coughed * loose_ml[0])
    loose_ml[0] -= expelled_ml
    for i in range(1, loose_ml.size):
        moved_ml = share * loose_ml[i]
        loose_ml[i] -= moved_ml
        loose_ml[i - 1] += moved_ml
    return expelled_ml


@compiled
def step(
    clearance: Clearance,
    loose_ml: Bins,
    store: Store,
    produced_ml_per_s: Bins,
    carina_mm: float,
    muscle_cmh2o: float,
    dt_s: float,
) -> tuple[Bins, Store]:
    """Loose secretions and the others after a step that `secretion.step` has made already.

    produced_ml_per_s: what that added to the loose ones; shares of it stick or lie too deep. The
    arrays given stay as they are.
    """
    loose, made_ml = loose_ml.copy(), 0.0
    hidden_share = clearance.adherent_share + clearance.deep_share
    for i in range(loose.size):
        made_ml += produced_ml_per_s[i] * dt_s
        loose[i] -= hidden_share * produced_ml_per_s[i] * dt_s
    freed_ml = dt_s / (clearance.loosening_s + dt_s) * store.adherent_ml
    lowest = min(int(carina_mm / BIN_MM), loose.size - 1)
    for i in range(lowest + 1):
        loose[i] += freed_ml / (lowest + 1)
    deep_ml = store.deep_ml + clearance.deep_share * made_ml
    expelled_ml = _carry(clearance, loose, muscle_cmh2o, dt_s)
    pushed_mm_per_s = clearance.cough_mm_per_s_per_cmh2o * max(muscle_cmh2o, 0.0)
    risen_ml = min((clearance.cilia_mm_per_s + pushed_mm_per_s) * dt_s / DEEP_MM, 1.0) * deep_ml
    loose[lowest] += risen_ml
    return loose, Store(
        adherent_ml=store.adherent_ml + clearance.adherent_share * made_ml - freed_ml,
        deep_ml=deep_ml - risen_ml,
        expelled_ml=store.expelled_ml + expelled_ml,
    )
