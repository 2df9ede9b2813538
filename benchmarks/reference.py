"""A compiled loop that never changes: the clock that ticks are told in.

Nanoseconds depend on the computer and on who else uses it, so figures of two days cannot be
compared; how many reference ticks a tick takes can. The loop does what a tick of the twin does, in
small: a servo moves a head, plays follow it, noise is drawn, a row is written. It calls nothing of
the package and nothing of a mathematical library, so that only the compiler and the processor
decide how long it takes. Whoever changes it must measure every figure anew that is told in it;
`CHECKSUM` notices.
"""

import numba
import numpy as np
import numpy.typing as npt

TICKS = 40_000
"""About as many as a cycle has."""
CHECKSUM = 1274.0944823112652
"""What `run` returns: sums, products and quotients only, so equal on every computer."""
_WIDTHS_MM: npt.NDArray[np.float64] = 14.0 + np.arange(12, dtype=np.float64)
_TABLE = np.zeros((TICKS, 64))
"""As much memory as a trace touches."""


@numba.njit(nogil=True, boundscheck=True, error_model="python")
def _run(widths: npt.NDArray[np.float64], table: npt.NDArray[np.float64]) -> float:
    """Ticks of a servo, plays and a xorshift generator (Marsaglia 2003), row by row."""
    plays = np.zeros(widths.size)
    word = np.uint64(88172645463325252)
    head = velocity = error = checksum = 0.0
    for tick in range(table.shape[0]):
        word ^= word << np.uint64(13)
        word ^= word >> np.uint64(7)
        word ^= word << np.uint64(17)
        noise = float(word >> np.uint64(11)) * 2.0**-53 - 0.5
        way = tick % 20_000
        wanted = 0.009 * (way if way < 10_000 else 20_000 - way)
        before, error = error, wanted - head
        volts = min(max(10.0 * error + 10.0 * (error - before), -24.0), 24.0)
        velocity += 0.05 * (0.75 * volts - velocity)
        if abs(velocity) < 1e-3:
            velocity = 0.0
        head += 0.001 * velocity
        total = 0.0
        for j in range(widths.size):
            half = 0.5 * widths[j]
            plays[j] = min(max(plays[j], head - half), head + half)
            total += plays[j]
        tip = 0.95 * total / widths.size - 6.2 + 0.1 * noise
        row = table[tick]
        for j in range(row.size):
            row[j] = tip
        checksum = 0.999 * checksum + tip / (1.0 + abs(velocity))
    return checksum


def run() -> float:
    """The reference loop over `TICKS`; returns `CHECKSUM`."""
    return float(_run(_WIDTHS_MM, _TABLE))
