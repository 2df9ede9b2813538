"""LLVM code on its way from the functions of the core into the machine code of a root.

Left to itself numba optimises every function with all that it calls and makes machine code of it,
and does it again in each caller, into which it is inlined. Nobody runs the inner machine code. So
an inner function only holds its own LLVM code here, and knows what it calls; a root links them
all, is optimised once and becomes machine code.

What it may cost is the order of LLVM's passes, not a result: the same passes run over the same
functions inlined into one another, and none of them regroups floating-point arithmetic.

One core function as LLVM code for given types of arguments: typed, but not yet machine code.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, ClassVar, NamedTuple

import llvmlite.binding as llvm
from numba.core import config, typed_passes, untyped_passes
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager
from numba.core.environment import lookup_environment
from numba.core.runtime.context import NRTContext

from opensuction.kernel.compiler import compilation

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"


ENVIRONMENT_PREFIX = "_ZN08NumbaEnv"
"""Names of the variables by which compiled code finds the globals of its Python function."""

HASH_PREFIX = "_numba_hashsecret_"
"""Names of what numba defines only when all that it can compile is loaded: machine code that is
loaded from the cache would not find it."""

INNER_LEVEL = 1
"""LLVM's level for a function by itself. It makes the code small before it is linked; what level 3
adds is done in the root in any case."""


def _set_linkage(module: Any, old: Iterable[str], new: str) -> None:
    """Give every function that a module defines with an old linkage a new one."""
    for function in module.functions:
        if not function.is_declaration and function.linkage.name in old:
            function.linkage = new


def environments(module: Any) -> Iterator[Any]:
    """Environments that the code of a module refers to, as far as they live."""
    for variable in module.global_variables:
        if variable.name.startswith(ENVIRONMENT_PREFIX):
            environment = lookup_environment(variable.name)
            if environment is not None:
                yield environment


def _parse(code: bytes) -> Any:
    """A module of kept code, to be merged with others.

    What numba compiled for itself is left out by the linker while nobody refers to it yet, which
    the next module may do: so it is weak, like all other functions, until all are merged.
    """
    module = llvm.parse_bitcode(code)
    _set_linkage(module, {"linkonce_odr"}, "weak_odr")
    return module


def _merge(modules: list[Any]) -> Any:
    """One module of many; by halves, for linking takes time with what is there already."""
    if len(modules) == 1:
        return modules[0]
    middle = len(modules) // 2
    merged = _merge(modules[:middle])
    merged.link_in(_merge(modules[middle:]))
    return merged


class TranslatedLibrary(JITCodeLibrary):
    """LLVM code of one core function, without that of its callees and without machine code."""

    code: bytes = b""
    """Bitcode, once finalized; functions are weak, so that equal ones may be linked together."""

    alive: tuple[Any, ...] = ()
    """Environments that the code refers to; without a reference they vanish."""

    @property
    def callees(self) -> list[CodeLibrary]:
        """Libraries of what it calls: other core functions, and numba's own."""
        return list(dict.fromkeys(self._linking_libraries))

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager(opt=INNER_LEVEL)
                passes.run(function, builder)

    def finalize(self) -> None:
        """Nothing is added any more: keep the code, and no module in memory."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        _set_linkage(self._final_module, {"external"}, "weak_odr")
        self.code = self._final_module.as_bitcode()
        self.alive = tuple(environments(self._final_module))
        self._final_module = None
        self._finalized = True

    def restore(self, code: bytes, callees: Iterable[CodeLibrary], alive: tuple[Any, ...]) -> None:
        """Take code that was kept, instead of what would be added to an empty library.

        alive: environments that the code refers to.
        """
        self.code, self.alive, self._final_module = code, alive, None
        self._linking_libraries = list(callees)
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Module of this function and all that it calls, for a root or a caller of numba's own."""
        self._ensure_finalized()
        inner, others = _reach(self)
        module = _merge([_parse(library.code) for library in inner])
        for library in others:
            module.link_in(library._get_module_for_linking(), preserve=True)
        _set_linkage(module, {"external", "weak_odr"}, "linkonce_odr")
        return module


def _reach(library: TranslatedLibrary) -> tuple[list[TranslatedLibrary], list[CodeLibrary]]:
    """Libraries of the core that a function needs, itself first, and numba's own, each once."""
    inner, waiting = {library: None}, [library]
    others: dict[CodeLibrary, None] = {}
    while waiting:
        for callee in waiting.pop().callees:
            if not isinstance(callee, TranslatedLibrary):
                others[callee] = None
            elif callee not in inner:
                inner[callee] = None
                waiting.append(callee)
    return list(inner), list(others)


class RootLibrary(JITCodeLibrary):
    """Machine code of one core function with all that it calls, and Python's way into it."""

    wrapper: str = ""
    """Name of what Python calls. All other functions are the root's own, though other roots hold
    copies of them: no call is bound to what another root holds."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Nothing by itself: the whole module is optimised when all is linked."""
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """Optimise all that has been linked.

        With LLVM's vectoriser of straight-line code, which numba leaves out by default: a tick is
        little else (docs/decisions/0020). Elsewhere numba's own setting holds.
        """
        compilation.report_optimising()
        for function in self._final_module.functions:
            if not function.is_declaration and function.name != self.wrapper:
                function.linkage = "internal"
        others, config.SLP_VECTORIZE = config.SLP_VECTORIZE, 1
        try:
            super()._optimize_final_module()
        finally:
            config.SLP_VECTORIZE = others

    def finalize(self) -> None:
        """Link, optimise, make machine code.

        Raises NotImplementedError for code that a later process could not load.
        """
        super().finalize()
        if any(one.name.startswith(HASH_PREFIX) for one in self._final_module.global_variables):
            raise NotImplementedError(f"{self.name} hashes text or bytes, which the core does not")
        for environment in environments(self._final_module):
            self._codegen.set_env(environment.env_name, environment)


# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"


class Translation(NamedTuple):
    """Translation of a function, for the callers that link it."""

    signature: Any
    description: Any
    """Numba's ``fndesc``: names and types on the side of LLVM."""
    environment: Any
    library: TranslatedLibrary


class References(NRTContext):
    """Counts references, and looks for them only in types that hold any.

    Wherever a variable ends numba takes its record apart, field by field, to look for arrays in it:
    half of all LLVM code of a tick, thrown away by the first pass over it.
    """

    _holders: ClassVar[dict[Any, bool]] = {}

    def get_meminfos(self, builder: Any, ty: Any, val: Any) -> list[Any]:
        """Type and counter of each reference inside a value."""
        if ty not in self._holders:
            self._holders[ty] = self._context.data_model_manager[ty].contains_nrt_meminfo()
        found: list[Any] = super().get_meminfos(builder, ty, val) if self._holders[ty] else []
        return found


def count_references(context: Any) -> None:
    """Let a target context, a copy for one function, count by `References`."""
    context.nrt = References(context, context.enable_nrt)


PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.RewriteSemanticConstants,
    untyped_passes.DeadBranchPrune,
    untyped_passes.GenericRewrites,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.NopythonRewrites,
    typed_passes.NoPythonSupportedFeatureValidation,
    typed_passes.IRLegalization,
    typed_passes.AnnotateTypes,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)
"""Numba's passes less those for what the core does not write: closures, comprehensions, blocks of
``with``, unrolled loops and functions inlined by numba. Each goes through every function anew."""


class Translator(CompilerBase):
    """Numba's compiler as far as LLVM code, into a `TranslatedLibrary`."""

    def define_pipelines(self) -> list[PassManager]:
        """One sequence of `PASSES`."""
        manager = PassManager("core")
        for one in PASSES:
            manager.add_pass(one, one._name)
        manager.finalize()
        return [manager]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Translate a Python function; returns numba's result, without a function to call."""
        self.state.flags.no_compile = True
        self.state.library = TranslatedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        count_references(self.state.targetctx)
        result = super().compile_extra(func)
        compilation.count()
        return result
