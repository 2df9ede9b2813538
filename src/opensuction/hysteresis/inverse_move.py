"""What a model's inverse answers: the move that brings the output to a target, or how far it got.

One record for every model, so that who compensates a hysteresis need not know which one it is.
"""

from typing import NamedTuple


class InverseMove(NamedTuple):
    """A move of the input found by inverting a model."""

    move_mm: float
    """Signed move of the input from where it is."""
    reached: bool
    """Whether the output is at the target after it. If not, no move reaches the target: the move
    is 0 or ends where the model's output or the range it holds for ends; each model says which."""
