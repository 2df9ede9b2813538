"""State of a model with a memory of any kind, and what its inverse answers."""

from typing import Any, NamedTuple


class ModelState(NamedTuple):
    """Position of the input, and the memory there."""

    head_mm: float
    memory: Any
    """A float, or an array of elements."""


class InverseMove(NamedTuple):
    """A move of the input found by inverting a model."""

    move_mm: float
    """Signed move of the input from where it is."""
    reached: bool
    """Whether the output is at the target after it. If not, no move reaches the target: the move
    is 0 or ends where the model's output or the range it holds for ends; each model says which."""
