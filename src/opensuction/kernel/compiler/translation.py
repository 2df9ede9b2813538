"""One core function as LLVM code for given types of arguments: typed, but not yet machine code."""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from numba.core import typed_passes, untyped_passes
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager
from numba.core.runtime.context import NRTContext

from opensuction.kernel.compiler import compilation
from opensuction.kernel.compiler.library import TranslatedLibrary


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
