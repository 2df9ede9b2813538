"""A core function, compiled apart for the two who call it: Python and compiled code.

Nearly all core functions are called by compiled code alone. Such a function is translated to LLVM
code, and linked into the functions that Python calls: the roots. Only those are optimised, become
machine code, and have the wrapper that takes every record apart and puts it together again: with
records of some 300 numbers that is more machine code than most functions themselves.

Calls by Python whose arguments are always of a few known kinds.

At every call numba asks each number of every record for its type: with records of some 300 numbers
that takes two thirds of the call, .1 ms, as long as 200 ticks. A typed call asks once a kind.
The types are those that the records declare: a whole number in a field of floats is taken as the
float that it stands for, instead of compiling everything anew.
"""

import copy
import gc
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Generic, TypeVar, cast, get_args, get_type_hints

import numba
from numba.core import config, sigutils, types, typing
from numba.core.compiler import Flags, _make_subtarget, compile_result
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import Environment
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys
from numba.core.targetconfig import ConfigStack

from opensuction.kernel.compiler import compilation
from opensuction.kernel.compiler.library import (
    RootLibrary,
    Translation,
    Translator,
    count_references,
)
from opensuction.kernel.compiler.store import Store

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"


CACHE_SETTING = "CACHE_DIR"
"""Numba's setting; changed only while a dispatcher is made, so other users keep theirs."""

WRAPPER_SUFFIX = "_wrapper"
"""Of the name of an environment."""

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "nogil": True,
    "error_model": "python",
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""For every core function: see `compiled.compiled`. Roots get their wrapper apart."""


@contextmanager
def _without_collector() -> Iterator[None]:
    """Compiling makes millions of objects that live to its end: looking through them is in vain."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class CoreFunction(CPUDispatcher):
    """Dispatcher of a core function, in its place: Python calls it, compiled callers link it."""

    def __init__(
        self,
        py_func: Callable[..., Any],
        locals: dict[str, Any] | None = None,  # noqa: A002 - numba's name
        targetoptions: dict[str, Any] | None = None,
    ) -> None:
        """The arguments are numba's, which makes it anew where it was sent to another process."""
        super().__init__(py_func, locals, targetoptions, pipeline_class=Translator)
        self._translations: dict[tuple[Any, ...], Translation] = {}
        self._cache_folder: Path | None = None
        self._store: Store | None = None

    def keep(self, folder: Path, store: Store) -> None:
        """Keep machine code in a folder, and translations in a store."""
        self._cache_folder, self._store = folder, store

    @property
    def translations(self) -> tuple[Translation, ...]:
        """Those of this process, one for each kind of arguments."""
        return tuple(self._translations.values())

    def translate(self, args: tuple[Any, ...]) -> Translation:
        """LLVM code for these types of arguments; raises numba's errors where they do not fit."""
        found = self._translations.get(args)
        if found is None:
            found = self._store.find(self.py_func, args) if self._store else None
            if found is None:
                result = self._compiler.compile(args, None)
                description = result.fndesc
                description.typemap = description.calltypes = None  # large, and not needed again
                result.library.finalize()
                found = Translation(
                    result.signature, description, result.environment, result.library
                )
                if self._store:
                    self._store.add(self.py_func, found)
            library = found.library
            self.targetctx.insert_user_function(library, found.description, [library])
            self._translations[args] = found
        return found

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Types of a call of this function by compiled code, for numba's type inference."""
        parameters, folded = self._compiler.fold_argument_types(args, kws)
        # A number written out is a number like any other: no translation for each.
        folded = tuple(types.unliteral(one) for one in folded)
        self.translate(folded)
        name = self.py_func.__name__
        signatures = [translation.signature for translation in self.translations]
        template = typing.make_concrete_template(name, key=name, signatures=signatures)
        return template, parameters, folded, {}

    def get_overload(self, sig: Any) -> Any:
        """Key by which numba finds what compiled code calls."""
        args, _ = sigutils.normalize_signature(sig)
        return self.translate(tuple(args)).library

    def compile(self, sig: Any) -> Any:
        """Machine code for calls by Python; returns what is called."""
        args, _ = sigutils.normalize_signature(sig)
        with global_compiler_lock, _without_collector():
            found: Any = self.overloads.get(tuple(args))
            if found is None:
                if not self._can_compile:
                    raise RuntimeError("compilation disabled")
                found = self._load(sig) or self._build(sig, tuple(args))
                self.add_overload(found)
            return found.entry_point

    def _load(self, sig: Any) -> Any:
        """A root from the cache, as numba's result; None if it is not there."""
        if self._cache_folder is not None and self._cache.cache_path is None:
            self._cache_folder.mkdir(parents=True, exist_ok=True)
            previous = getattr(config, CACHE_SETTING)
            setattr(config, CACHE_SETTING, str(self._cache_folder))
            try:
                self.enable_caching()
            finally:
                setattr(config, CACHE_SETTING, previous)
        try:
            # Not `load_overload`: to link what is ready it would load all that numba can compile,
            # which takes longer than numba itself. Machine code needs its run-time part alone.
            rtsys.initialize(self.targetctx)
            with self._cache._guard_against_spurious_io_errors():
                found = self._cache._load_overload(sig, self.targetctx)
        except Exception:  # whatever pickle makes of a damaged file
            self._cache.flush()  # it is made anew
            found = None
        (self._cache_misses if found is None else self._cache_hits)[sig] += 1
        return found

    def _build(self, sig: Any, args: tuple[Any, ...]) -> Any:
        """A root that is not in the cache; put there, with what was translated for it."""
        with compilation.report(self.py_func):
            self.typingctx.refresh()
            self.targetctx.refresh()
            if self._store:
                self._store.read()
            root = self._link(self.translate(args))
            self._cache.save_overload(sig, root)
            if self._store:
                self._store.write()
        return root

    def _link(self, translation: Translation) -> Any:
        """A root: the wrapper that Python calls, linked with the function and all that it calls."""
        flags = Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        context = _make_subtarget(self.targetctx, flags)
        count_references(context)
        library = RootLibrary(context.codegen(), self.py_func.__qualname__)
        library.enable_object_caching()
        library.add_linking_library(translation.library)
        # The wrapper has constants of its own (the records' types): in an environment of its own,
        # for other roots hold the function without the wrapper, and of a name only one lives.
        description = copy.copy(translation.description)
        description.env_name += WRAPPER_SUFFIX
        environment = Environment.from_fndesc(description)
        library.wrapper = description.llvm_cpython_wrapper_name
        with ConfigStack().enter(flags), context.push_code_library(library):
            context.create_cpython_wrapper(
                library, description, environment, None, release_gil=flags.release_gil
            )
        return compile_result(
            typing_context=self.typingctx,
            target_context=context,
            entry_point=context.get_executable(library, description, environment),
            type_annotation="",
            library=library,
            signature=translation.signature,
            objectmode=False,
            lifted=(),
            fndesc=description,
            environment=environment,
            reload_init=[],
        )


def make(function: Callable[..., object], **options: bool) -> CoreFunction:
    """Dispatcher of a core function. options: of numba, besides `OPTIONS`."""
    return CoreFunction(function, {}, {**OPTIONS, **options})


# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined, index"


Result = TypeVar("Result")
SCALARS = {float: types.float64, int: types.int64, bool: types.boolean}


def declared(hint: Any, found: Any) -> Any:
    """The type in machine code of what is declared as ``hint``.

    found: numba's type of an example; it decides where the declaration leaves a choice.
    """
    if hint in SCALARS:
        return SCALARS[hint]
    if isinstance(found, types.BaseNamedTuple):
        hints = get_type_hints(found.instance_class)
        inner = [declared(hints[name], found[i]) for i, name in enumerate(found.fields)]
        return types.BaseTuple.from_types(inner, found.instance_class)
    if isinstance(found, types.BaseTuple):
        inners = get_args(hint)
        if inners[-1] is Ellipsis:
            inners = inners[:1] * len(found)
        return types.Tuple.from_types([declared(one, found[i]) for i, one in enumerate(inners)])
    return found


class TypedCall(Generic[Result]):
    """One core function, as Python calls it often; whoever holds it declares the arguments."""

    def __init__(self, function: Callable[..., Result], kind: Callable[..., Hashable]) -> None:
        """kind: tells apart what the classes of the arguments leave open, as a union in a record.

        It takes the arguments.
        """
        self._function, self._kind = function, kind
        self._known: dict[Hashable, Callable[..., Result]] = {}

    def __call__(self, *arguments: Any) -> Result:
        """Call it."""
        return self.find(arguments)(*arguments)

    def find(self, arguments: tuple[Any, ...]) -> Callable[..., Result]:
        """Machine code for arguments of these kinds.

        Whoever calls it again and again, and with no others, need not have it looked up each time.
        """
        kind = (self._kind(*arguments), *map(type, arguments))
        code = self._known.get(kind)
        if code is None:
            code = self._known[kind] = self._resolve(arguments)
        return code

    def _resolve(self, arguments: tuple[Any, ...]) -> Callable[..., Result]:
        """Machine code for arguments of these kinds; the function itself where all is Python."""
        if not isinstance(self._function, CoreFunction):
            return self._function
        hints = get_type_hints(self._function.py_func).values()
        taken = tuple(
            declared(hint, numba.typeof(one)) for hint, one in zip(hints, arguments, strict=False)
        )
        return cast(Callable[..., Result], self._function.compile(taken))
