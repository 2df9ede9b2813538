"""Emulated drives: the twin behind two CiA 402 drives and a CiA 401 module on a CANopen bus.

In-silico: a host on the bus finds nodes, and behind them numbers. What a drive does by itself, the
nodes do by themselves, whether a host lives or not.
"""

from opensuction.kernel.errors import InputError
from opensuction.machine.canopen.frame_bus import NEEDS

try:
    import canopen  # noqa: F401 - here once, for all that need it
except ImportError:
    raise InputError(NEEDS) from None
