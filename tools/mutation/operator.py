"""Mutants of a module: the same source with one small mistake each.

Left alone: annotations, decorators, docstrings, other strings, imports and names. A mistake is one
that a person could make: a comparison with the wrong edge, a wrong sign, an `and` for an `or`, a
number off by one, a condition the wrong way round, a result off by one.
"""

import ast
import copy
from collections.abc import Iterator, Sequence
from typing import NamedTuple

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
SWAPPED_CALLS = {"min": "max", "max": "min", "any": "all", "all": "any"}


class Mutant(NamedTuple):
    """One mistake."""

    line: int
    column: int
    change: str
    """Before and after, on one line."""
    tree: ast.Module


def _same_place(new: ast.expr, old: ast.expr) -> ast.expr:
    return ast.fix_missing_locations(ast.copy_location(new, old))


def _compared(node: ast.Compare) -> Iterator[ast.expr]:
    for index, operator in enumerate(node.ops):
        for replacement in COMPARISONS.get(type(operator), ()):
            new = copy.deepcopy(node)
            new.ops[index] = replacement()
            yield new


def _calculated(node: ast.BinOp) -> Iterator[ast.expr]:
    replacement = ARITHMETIC.get(type(node.op))
    if replacement is not None:
        yield ast.BinOp(left=node.left, op=replacement(), right=node.right)


def _joined(node: ast.BoolOp) -> Iterator[ast.expr]:
    other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield ast.BoolOp(op=other, values=node.values)


def _constant(node: ast.Constant) -> Iterator[ast.expr]:
    if isinstance(node.value, bool):
        yield ast.Constant(value=not node.value)
    elif isinstance(node.value, int | float):
        yield ast.Constant(value=node.value + 1)


def _called(node: ast.Call) -> Iterator[ast.expr]:
    if isinstance(node.func, ast.Name) and node.func.id in SWAPPED_CALLS:
        name = ast.Name(id=SWAPPED_CALLS[node.func.id], ctx=ast.Load())
        yield ast.Call(func=name, args=node.args, keywords=node.keywords)


def _alternatives(node: ast.expr) -> Iterator[ast.expr]:
    """Expressions that an expression can be mistaken for."""
    match node:
        case ast.Compare():
            yield from _compared(node)
        case ast.BinOp():
            yield from _calculated(node)
        case ast.BoolOp():
            yield from _joined(node)
        case ast.UnaryOp(operand=operand):
            yield operand
        case ast.Constant():
            yield from _constant(node)
        case ast.Call():
            yield from _called(node)
        case ast.IfExp(test=test, body=body, orelse=orelse):
            yield ast.IfExp(test=test, body=orelse, orelse=body)


class _Places(ast.NodeVisitor):
    """Collects where a mistake can be made: parent, field, index in the field, replacement."""

    def __init__(self) -> None:
        self.found: list[tuple[ast.AST, str, int | None, ast.AST]] = []
        self._returns: list[str] = []

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Body and default values, neither decorators nor annotations."""
        self._returns.append(ast.unparse(node.returns) if node.returns else "")
        for name, value in (("defaults", node.args.defaults), ("body", node.body)):
            owner = node.args if name == "defaults" else node
            self._children(owner, name, value)
        self._returns.pop()

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self._children(node, "body", node.body)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self._child(node, "value", None, node.value)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        replacement = ARITHMETIC.get(type(node.op))
        if replacement is not None:
            self.found.append((node, "op", None, replacement()))
        self._child(node, "value", None, node.value)

    def visit_If(self, node: ast.If) -> None:
        self._negated(node, node.test)
        self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        self._negated(node, node.test)
        self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is None:
            return
        if self._returns[-1] in ("int", "float"):
            off = ast.BinOp(left=node.value, op=ast.Add(), right=ast.Constant(value=1))
            self.found.append((node, "value", None, _same_place(off, node.value)))
        elif self._returns[-1] == "bool" and not isinstance(node.value, ast.Constant):
            self._negated(node, node.value, "value")
        self._child(node, "value", None, node.value)

    def visit_Import(self, node: ast.Import) -> None:
        """Nothing to mistake."""

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Nothing to mistake."""

    def generic_visit(self, node: ast.AST) -> None:
        for name, value in ast.iter_fields(node):
            if isinstance(value, list):
                self._children(node, name, value)
            elif isinstance(value, ast.AST):
                self._child(node, name, None, value)

    def _negated(self, node: ast.stmt, test: ast.expr, field: str = "test") -> None:
        if not isinstance(test, ast.Compare | ast.UnaryOp):  # their own mistakes say the same
            wrong = ast.UnaryOp(op=ast.Not(), operand=test)
            self.found.append((node, field, None, _same_place(wrong, test)))

    def _children(self, node: ast.AST, name: str, values: Sequence[ast.AST]) -> None:
        for index, value in enumerate(values):
            if isinstance(value, ast.AST):
                self._child(node, name, index, value)

    def _child(self, node: ast.AST, name: str, index: int | None, value: ast.AST) -> None:
        if isinstance(value, ast.expr):
            for replacement in _alternatives(value):
                self.found.append((node, name, index, _same_place(replacement, value)))
        self.visit(value)


def _text(node: ast.AST) -> str:
    if isinstance(node, ast.operator):
        return type(node).__name__
    return " ".join(ast.unparse(node).split())


def mutants(source: str) -> Iterator[Mutant]:
    """Every mutant of a module, in the order of the source; one tree is changed and changed back.

    Use a tree before asking for the next.
    """
    tree = ast.parse(source)
    places = _Places()
    places.visit(tree)
    for parent, name, index, replacement in places.found:
        field = getattr(parent, name)
        old = field if index is None else field[index]
        where = parent if isinstance(old, ast.operator) else old
        _put(parent, name, index, replacement)
        yield Mutant(
            line=getattr(where, "lineno", 0),
            column=getattr(where, "col_offset", 0) + 1,
            change=f"{_text(old)} -> {_text(replacement)}",
            tree=tree,
        )
        _put(parent, name, index, old)


def _put(parent: ast.AST, name: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, name, node)
    else:
        getattr(parent, name)[index] = node
