"""``record._replace(field=...)`` of NamedTuples in compiled code.

Numba knows the constructor of a NamedTuple and its fields, but not its ``_replace``. So a record of
which one number changes would be written out field by field, and a field that is added would have
to be copied in every place. Here the method is taught to numba as a template of its own: keyword
arguments cannot be taken by `numba.extending.overload_method`.

A record keeps its type: what is given is cast to the type of its field, as an integer to a float,
where that loses nothing; anything else is refused while compiling. The constructor would quietly
make a record of another type, and everything that it is handed to would be compiled once more.
"""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call"

import inspect
from typing import Any

from numba.core import types
from numba.core.errors import TypingError
from numba.core.imputils import impl_ret_borrowed, lower_builtin
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer_getattr,
    signature,
)

KEY = "NamedTuple._replace"
"""What numba looks the implementation up by."""


def _field_type(record: Any, field: str, given: Any, context: Any) -> Any:
    """The type of a field that is given; raises TypingError where no safe cast leads to it."""
    name, wanted = record.instance_class.__name__, record[record.fields.index(field)]
    conversion = context.can_convert(given, wanted)
    if conversion is None or conversion > Conversion.safe:
        raise TypingError(f"{name}.{field} is {wanted}: {given} cannot replace it")
    return wanted


class _Replace(AbstractTemplate):
    """Typing of the call; ``this`` is the type of the record."""

    key = KEY
    this: Any

    def generic(self, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        """Signature with a parameter for each field; those that stay as they are are none."""
        record = self.this
        name = record.instance_class.__name__
        if args:
            raise TypingError(f"{name}._replace takes keyword arguments only")
        unknown = sorted(set(kws) - set(record.fields))
        if unknown:
            raise TypingError(f"{name} has no field {', '.join(unknown)}")
        chosen = [
            _field_type(record, field, kws[field], self.context) if field in kws else types.none
            for field in record.fields
        ]
        found = signature(record, *chosen, recvr=record)
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        return found.replace(
            pysig=inspect.Signature(
                [inspect.Parameter(field, kind, default=None) for field in record.fields]
            )
        )


@infer_getattr
class _ReplaceAttribute(AttributeTemplate):
    """Gives every NamedTuple the method."""

    key = types.BaseNamedTuple

    def resolve__replace(self, record: Any) -> Any:
        """The method bound to a record."""
        return types.BoundFunction(_Replace, record)


@lower_builtin(KEY, types.BaseNamedTuple, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
def _insert(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """One value inserted for each field that is given; the others stay where they are."""
    record, *fields = sig.args
    result, *values = args
    for index, (field, value) in enumerate(zip(fields, values, strict=True)):
        if field is not types.none:
            result = builder.insert_value(result, value, index)
    return impl_ret_borrowed(context, builder, record, result)
