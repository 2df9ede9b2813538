"""LLVM code on its way from the functions of the core into the machine code of a root.

Left to itself numba optimises every function with all that it calls and makes machine code of it,
and does it again in each caller, into which it is inlined. Nobody runs the inner machine code. So
an inner function only holds its own LLVM code here, and knows what it calls; a root links them
all, is optimised once and becomes machine code.

What it may cost is the order of LLVM's passes, not a result: the same passes run over the same
functions inlined into one another, and none of them regroups floating-point arithmetic.
"""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"

from collections.abc import Iterable, Iterator
from typing import Any

import llvmlite.binding as llvm
from numba.core import config
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.environment import lookup_environment

from opensuction.kernel.compiler import compilation

ENVIRONMENT_PREFIX = "_ZN08NumbaEnv"
"""Names of the variables by which compiled code finds the globals of its Python function."""

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
        """Link, optimise, make machine code."""
        super().finalize()
        for environment in environments(self._final_module):
            self._codegen.set_env(environment.env_name, environment)
