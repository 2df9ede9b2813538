"""The plain-Python source of a core function, as a syntax tree."""

import ast
import inspect
import textwrap
from collections.abc import Callable
from functools import cache
from typing import Any


def plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """The Python function behind a compiled one."""
    python: Callable[..., Any] = getattr(function, "py_func", function)
    return python


@cache
def tree_of(function: Callable[..., Any]) -> ast.FunctionDef:
    """Syntax tree of a function's definition. Raises NotImplementedError for one without source."""
    try:
        text = textwrap.dedent(inspect.getsource(function))
    except OSError as error:
        raise NotImplementedError(f"{function.__qualname__} has no source: {error}") from error
    definition = ast.parse(text).body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise NotImplementedError(f"{function.__qualname__} is no plain function")
    return definition
