"""Buttons act when they are pressed, not as long as they are held.

What is done for each button is written out from the fields of `Requests`: see
`kernel.codegen.straight_line`.
"""

from collections.abc import Callable

from opensuction.kernel.codegen import straight_line
from opensuction.kernel.requests import STOP, Requests

NONE = 0
"""No button is held."""


def _holder() -> Callable[[Requests], int]:
    """``hold(now)``: mask of the buttons that are down in this tick, bits in their order."""
    lines = ["def hold(now):", "    mask = 0"]
    for bit, field in enumerate(Requests._fields):
        lines += [f"    if now.{field}:", f"        mask |= {1 << bit}"]
    hold: Callable[[Requests], int] = straight_line.define([*lines, "    return mask"], "buttons")
    return hold


def _presser() -> Callable[[Requests, int], Requests]:
    """``press_once(now, held)``: buttons pressed in this tick; the stop also while it is held.

    held: mask of those that were down in the last tick. A button that sticks, or a thumb that stays
    on it, asks for one cycle, one reset, one answer.
    """
    pressed = [
        f"now.{field}" if field == STOP else f"now.{field} and held & {1 << bit} == 0"
        for bit, field in enumerate(Requests._fields)
    ]
    press_once: Callable[[Requests, int], Requests] = straight_line.define(
        [
            "def press_once(now, held):",
            f"    if held == {NONE}:",
            "        return now",
            f"    return Requests({', '.join(pressed)})",
        ],
        "buttons pressed",
        Requests=Requests,
    )
    return press_once


hold = _holder()
press_once = _presser()
