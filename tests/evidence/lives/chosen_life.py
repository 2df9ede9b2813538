"""One life with chosen faults, and the invariants that it breaks."""

from opensuction.evidence.lives import life
from opensuction.evidence.lives.life_fault import LifeFault
from opensuction.evidence.lives.life_record import Life, LifeResult


def play(*faults: LifeFault, seed: int = 1) -> LifeResult:
    return life.play(Life(seed, 3, faults))


def broken(found: LifeResult) -> set[str]:
    return {one.invariant for one in found.violations}
