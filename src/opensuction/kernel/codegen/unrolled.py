"""Loops over constants, written out as straight-line code for the compiled core.

Compiled code builds a tuple only of elements that are written out, and a tuple indexed by a
variable is kept in memory as a whole. So the source of a function is rewritten: each ``for`` over
something constant becomes its body once for each of its elements, with the loop's variables
replaced by their values; ``tuple(... for ... in ...)`` becomes a tuple of as many elements. What
a reviewer reads, a debugger steps through and mutation tests change is the loop.
"""

import ast
import copy
import inspect
import textwrap
from collections.abc import Callable, Iterator
from functools import update_wrapper
from types import FunctionType
from typing import Any, NoReturn, TypeVar, cast

from numba import config

from opensuction.kernel.compiled import JIT_SETTING, compiled_generated

Function = TypeVar("Function", bound=Callable[..., object])


def unrolled(function: Function) -> Function:
    """Compile a core function as straight-line code; the same source runs as plain Python.

    function: each of its loops goes over an expression of constants of its module (or of the
    function around it). A loop's variables are numbers, tuples of numbers or names for these; the
    body gives them no other value and has no ``break`` and no ``continue``. Raises TypeError, with
    file and line, for a loop that cannot be written out.
    """
    if getattr(config, JIT_SETTING):
        return function
    return compiled_generated(write_out(function))


def write_out(function: Function) -> Function:
    """The function with its loops written out, as plain Python; ``__wrapped__`` is as it stands."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    (definition,) = tree.body
    if not isinstance(definition, ast.FunctionDef):
        raise TypeError(f"{function.__qualname__} is no function with a name")
    definition.decorator_list.clear()
    definition.returns = None
    for argument in definition.args.args:
        argument.annotation = None
    where = f"{function.__module__}.{function.__qualname__}"
    constants = inspect.getclosurevars(function).nonlocals
    _Unroller({**function.__globals__, **constants}, where).visit(definition)
    names = {one.id for one in ast.walk(definition) if isinstance(one, ast.Name)}
    if left := names & set(constants):
        raise TypeError(f"{where} refers to {min(left)} elsewhere than in what a loop goes over")
    code = compile(ast.fix_missing_locations(tree), f"<{where}, written out>", "exec")
    (body,) = (one for one in code.co_consts if inspect.iscode(one))
    written = FunctionType(body, function.__globals__, function.__name__)
    return cast(Function, update_wrapper(written, function))


def chooser(count: int) -> Callable[[tuple[float, ...], int], float]:
    """``choose(values, index)``: one of so many numbers of a tuple, index from 0 to below count.

    A chain of comparisons: a tuple that is indexed by a variable is kept in memory as a whole.
    """

    @unrolled
    def choose(values: tuple[float, ...], index: int) -> float:
        value = values[0]
        for i in range(1, count):
            value = values[i] if index == i else value
        return value

    return choose


class _Unroller(ast.NodeTransformer):
    """Replaces each loop by its body, once for each element."""

    def __init__(self, scope: dict[str, Any], where: str) -> None:
        self._scope, self._where = scope, where

    def visit_For(self, node: ast.For) -> list[ast.stmt]:
        inside = [one for statement in node.body for one in ast.walk(statement)]
        changed = {
            one.id for one in inside if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)
        }
        if node.orelse or any(isinstance(one, ast.Break | ast.Continue) for one in inside):
            self._refuse(node, "has break, continue or else")
        written = []
        for values in self._elements(node, node.target, node.iter):
            if changed & set(values):
                self._refuse(node, f"gives {min(changed & set(values))} another value")
            for statement in node.body:
                found = self.visit(_Substitution(values).visit(copy.deepcopy(statement)))
                written += found if isinstance(found, list) else [found]
        return written

    def visit_Call(self, node: ast.Call) -> ast.expr:
        match node:
            case ast.Call(
                ast.Name("tuple"),
                [ast.GeneratorExp(element, [ast.comprehension(target, over, [], 0)])],
                [],
            ):
                elements = [
                    self.visit(_Substitution(values).visit(copy.deepcopy(element)))
                    for values in self._elements(node, target, over)
                ]
                return ast.copy_location(ast.Tuple(elements, ast.Load()), node)
        return cast(ast.expr, self.generic_visit(node))

    def _elements(self, at: ast.AST, target: ast.expr, over: ast.expr) -> Iterator[dict[str, Any]]:
        """Values of a loop's variables, for each of its elements."""
        try:
            found = eval(compile(ast.Expression(over), self._where, "eval"), self._scope)
        except NameError as problem:
            self._refuse(at, f"goes over something that is no constant: {problem}")
        for element in found:
            yield dict(self._assign(at, target, element))

    def _assign(self, at: ast.AST, target: ast.expr, value: Any) -> Iterator[tuple[str, Any]]:
        match target:
            case ast.Name(name):
                if not _is_constant(value):
                    self._refuse(at, f"has {name} = {value!r}, which is no number")
                yield name, value
            case ast.Tuple(names):
                for one, part in zip(names, value, strict=True):
                    yield from self._assign(at, one, part)
            case _:
                self._refuse(at, "assigns to something else than names")

    def _refuse(self, node: Any, problem: str) -> NoReturn:
        raise TypeError(f"{self._where}: the loop of its line {node.lineno} {problem}")


class _Substitution(ast.NodeTransformer):
    """Puts values in the place of names."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id not in self._values:
            return node
        written = ast.parse(repr(self._values[node.id]), mode="eval").body
        return ast.copy_location(written, node)


def _is_constant(value: Any) -> bool:
    """True for a number and for a tuple of numbers: what `repr` writes as Python reads it."""
    if isinstance(value, tuple):
        return all(map(_is_constant, value))
    return type(value) in (int, float, bool) and value == value and abs(value) != float("inf")
