"""Functions of the core translated into z3's terms: their own source is run on unknowns.

Assignments, records and their fields, `_replace`, branches and early returns, conditional
expressions, comparisons, arithmetic and bit masks, loops over a known range, and calls of other
core functions. Where a branch depends on an unknown, both sides are run and each value becomes
one of two. Whatever else turns up raises NotImplementedError with its place: nothing is guessed.
"""

import ast
import builtins
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import z3

from tools.proof import arithmetic, logic, source
from tools.proof.arithmetic import Doubles
from tools.proof.logic import Truth, conjoin, disjoin, lift_truth, negate

Summary = Callable[..., Any]
"""What stands for a function that is not translated: from its arguments to any result of it."""


class Raising(NamedTuple):
    """Condition under which a translated function raises."""

    when: Truth
    what: str


class _Frame:
    """A function that is being run."""

    def __init__(self, names: dict[str, Any], scope: Mapping[str, Any], path: Truth) -> None:
        self.names = names
        self.scope = scope
        self.path = path
        """When the function is called at all."""
        self.live: Truth = True
        """When it has not returned yet."""
        self.returned: list[tuple[Truth, Any]] = []


class Translation:
    """Runs core functions on records that hold unknowns.

    doubles: how floats are taken, exactly or abstractly. summaries: by function.
    """

    def __init__(
        self, doubles: Doubles, summaries: Mapping[Callable[..., Any], Summary] | None = None
    ) -> None:
        self.doubles = doubles
        self.raising: list[Raising] = []
        given = summaries or {}
        self._summaries = {source.plain(function): what for function, what in given.items()}
        self.used: set[str] = set()
        """Names of the functions whose source was run, and of those that a summary stood for."""

    def run(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        """Result of a core function for these arguments, known or unknown."""
        return self._call(source.plain(function), list(arguments), named, True)

    # Functions

    def _call(self, function: Any, arguments: list[Any], named: dict[str, Any], path: Truth) -> Any:
        function = source.plain(function)
        name = f"{getattr(function, '__module__', '?')}.{getattr(function, '__qualname__', '?')}"
        if function in self._summaries:
            self.used.add(f"{name} (summary)")
            return self._summaries[function](*arguments, **named)
        if arithmetic.is_known_function(function):
            return arithmetic.call(self.doubles, function, arguments)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return function(*arguments, **named)
        if getattr(function, "__name__", "") in ("_replace", "_make"):
            return function(*arguments, **named)
        if not name.startswith("opensuction."):
            raise NotImplementedError(f"{name} is not known")
        self.used.add(name)
        return self._run(function, arguments, named, path)

    def _run(self, function: Any, arguments: list[Any], named: dict[str, Any], path: Truth) -> Any:
        definition = source.tree_of(function)
        names = dict(zip([one.arg for one in definition.args.args], arguments, strict=False))
        frame = _Frame(names | named, function.__globals__, path)
        if len(frame.names) != len(definition.args.args):
            raise NotImplementedError(f"{function.__qualname__} is called with other arguments")
        self._run_block(definition.body, frame)
        if frame.live is not False or not frame.returned:
            raise NotImplementedError(f"{function.__qualname__} may end without a return")
        *earlier, (_, result) = frame.returned
        for condition, value in reversed(earlier):
            result = self._choose(condition, value, result)
        return result

    def _choose(self, condition: Truth, yes: Any, no: Any) -> Any:
        return arithmetic.choose(self.doubles, condition, yes, no)

    # Statements

    def _run_block(self, statements: list[ast.stmt], frame: _Frame) -> None:
        for statement in statements:
            if frame.live is False:
                return
            self._run_statement(statement, frame)

    def _run_statement(self, statement: ast.stmt, frame: _Frame) -> None:
        match statement:
            case ast.Expr(value=ast.Constant(value=str())):
                pass  # a docstring
            case ast.Assign(targets=[target], value=value):
                self._assign(target, self._value(value, frame), frame)
            case ast.AugAssign(target=ast.Name(id=name), op=operator, value=value):
                other = self._value(value, frame)
                frame.names[name] = self._operate(
                    operator, frame.names[name], other, frame, statement
                )
            case ast.Return(value=ast.expr() as value):
                frame.returned.append((frame.live, self._value(value, frame)))
                frame.live = False
            case ast.If(test=test, body=body, orelse=otherwise):
                self._branch(self._truth(test, frame), body, otherwise, frame)
            case ast.For(target=ast.Name(id=name), iter=iterated, body=body, orelse=[]):
                for one in self._value(iterated, frame):
                    frame.names[name] = one
                    self._run_block(body, frame)
            case _:
                self._refuse(statement)

    def _assign(self, target: ast.expr, value: Any, frame: _Frame) -> None:
        match target:
            case ast.Name(id=name):
                frame.names[name] = value
            case ast.Tuple(elts=targets):
                for one, part in zip(targets, value, strict=True):
                    self._assign(one, part, frame)
            case _:
                self._refuse(target)

    def _branch(
        self, condition: Truth, body: list[ast.stmt], otherwise: list[ast.stmt], frame: _Frame
    ) -> None:
        if isinstance(condition, bool):
            self._run_block(body if condition else otherwise, frame)
            return
        names, live = frame.names, frame.live
        ends = []
        for holds, block in ((condition, body), (negate(condition), otherwise)):
            frame.names, frame.live = dict(names), conjoin(live, holds)
            self._run_block(block, frame)
            ends.append((frame.names, frame.live))
        (yes, yes_live), (no, no_live) = ends
        frame.live = disjoin(yes_live, no_live)
        if yes_live is False or no_live is False:
            frame.names = no if yes_live is False else yes
            return
        # A name that only one side has bound is not used after it, or Python would not run either.
        both = [name for name in yes if name in no]
        frame.names = {name: self._choose(condition, yes[name], no[name]) for name in both}

    # Expressions

    def _truth(self, node: ast.expr, frame: _Frame) -> Truth:
        return self._judge(self._value(node, frame), node)

    def _judge(self, value: Any, node: ast.expr) -> Truth:
        """True where a value counts as true: a whole number does where it is not 0."""
        if logic.is_whole(value):
            return negate(logic.is_equal(value, 0))
        if not logic.is_truth(value):
            self._refuse(node)
        return value

    def _value(self, node: ast.expr, frame: _Frame) -> Any:
        value: Any
        match node:
            case ast.Constant():
                value = node.value
            case ast.Name(id=name):
                value = self._look_up(name, frame)
            case ast.Attribute(value=owner, attr=name):
                value = getattr(self._value(owner, frame), name)
            case ast.Tuple(elts=elements):
                value = tuple(self._value(one, frame) for one in elements)
            case ast.Subscript(value=owner, slice=index):
                place = self._value(index, frame)
                value = arithmetic.element(self.doubles, self._value(owner, frame), place)
            case ast.Call(func=called, args=arguments, keywords=keywords):
                function = self._value(called, frame)
                given = [self._value(one, frame) for one in arguments]
                named = {str(one.arg): self._value(one.value, frame) for one in keywords}
                value = self._call(function, given, named, conjoin(frame.path, frame.live))
            case _:
                value = self._compute(node, frame)
        return value

    def _compute(self, node: ast.expr, frame: _Frame) -> Any:
        """Value of what is made with an operator."""
        match node:
            case ast.BoolOp(op=operator, values=values):
                return self._join(operator, values, frame)
            case ast.UnaryOp(op=operator, operand=operand):
                return arithmetic.invert(self.doubles, operator, self._value(operand, frame))
            case ast.BinOp(left=left, op=operator, right=right):
                one, other = self._value(left, frame), self._value(right, frame)
                return self._operate(operator, one, other, frame, node)
            case ast.Compare(left=left, ops=operators, comparators=others):
                return self._compare(left, operators, others, frame)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                return self._choose_expression(self._truth(test, frame), body, otherwise, frame)
        return self._refuse(node)

    def _look_up(self, name: str, frame: _Frame) -> Any:
        for scope in (frame.names, frame.scope, vars(builtins)):
            if name in scope:
                return scope[name]
        raise NotImplementedError(f"{name} is not bound on every path to its use")

    def _under(self, condition: Truth, node: ast.expr, frame: _Frame) -> Any:
        """Value of what is only computed under a condition."""
        path = frame.path
        frame.path = conjoin(path, condition)
        value = self._value(node, frame)
        frame.path = path
        return value

    def _choose_expression(
        self, condition: Truth, body: ast.expr, otherwise: ast.expr, frame: _Frame
    ) -> Any:
        if isinstance(condition, bool):
            return self._value(body if condition else otherwise, frame)
        yes = self._under(condition, body, frame)
        return self._choose(condition, yes, self._under(negate(condition), otherwise, frame))

    def _join(self, operator: ast.boolop, values: list[ast.expr], frame: _Frame) -> Truth:
        is_and = isinstance(operator, ast.And)
        result: Truth = is_and
        for node in values:
            reached = result if is_and else negate(result)
            if reached is False:
                break
            value = self._judge(self._under(reached, node, frame), node)
            result = conjoin(result, value) if is_and else disjoin(result, value)
        return result

    def _compare(
        self, left: ast.expr, operators: list[ast.cmpop], others: list[ast.expr], frame: _Frame
    ) -> Truth:
        one, result = self._value(left, frame), True
        for operator, node in zip(operators, others, strict=True):
            other = self._value(node, frame)
            result = conjoin(result, arithmetic.compare(self.doubles, operator, one, other))
            one = other
        return result

    def _operate(
        self, operator: ast.operator, one: Any, other: Any, frame: _Frame, node: ast.AST
    ) -> Any:
        if isinstance(operator, ast.Div):
            zero = arithmetic.compare(self.doubles, ast.Eq(), other, 0.0)
            when = conjoin(frame.path, frame.live, zero)
            if when is not False:
                self.raising.append(Raising(when, f"division by zero: {ast.unparse(node)}"))
            if zero is True:
                return self.doubles.make(0.0)  # it has raised
        return arithmetic.operate(self.doubles, operator, one, other)

    def _refuse(self, node: ast.AST) -> Any:
        text = ast.unparse(node)
        raise NotImplementedError(f"cannot be translated: {text!r}")


def any_raises(translation: Translation) -> z3.BoolRef:
    """True where anything that was run raises."""
    return lift_truth(disjoin(*(one.when for one in translation.raising)))
