"""Translated functions, kept in files for later processes: those compile other roots of them.

A file holds what one root added. It is written once and never changed, so that any number of
processes may write at the same time; each reads what the others have written when it next has
something to compile.
"""

# numba is typed in parts only
# mypy: disable-error-code="no-untyped-call, attr-defined"

import hashlib
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from numba.core.codegen import CodeLibrary
from numba.core.registry import cpu_target
from numba.core.serialize import dumps

from opensuction.kernel.compiler.library import TranslatedLibrary, Translation, environments

SUFFIX = ".translated"


class _Part(NamedTuple):
    """LLVM code of one library."""

    name: str
    code: bytes
    callees: tuple[str, ...]
    """Keys of the parts that it calls."""
    environments: bytes
    """Pickled: what `library.environments` finds."""


class _Contents(NamedTuple):
    """Of one file, or of all that are known."""

    functions: dict[str, list[bytes]]
    """By name: pickled translations, one for each kind of arguments, with the keys of parts."""
    parts: dict[str, _Part]
    """By a hash of the code and of all that it calls."""

    def add(self, other: "_Contents") -> None:
        """Take in what another one holds."""
        for name, translations in other.functions.items():
            self.functions.setdefault(name, []).extend(translations)
        self.parts.update(other.parts)


class Store:
    """Translations in a folder.

    covers: whether a function can be kept, for the name of the folder tells of any change of it.
    """

    def __init__(self, folder: Path, covers: Callable[[Callable[..., Any]], bool]) -> None:
        self._folder, self._covers = folder, covers
        self._read: set[str] = set()
        self._known = _Contents({}, {})
        self._new = _Contents({}, {})
        self._libraries: dict[str, TranslatedLibrary] = {}
        self._keys: dict[CodeLibrary, str | None] = {}

    def read(self) -> None:
        """Take in the files that were written since the last time; a damaged one is removed."""
        machine = _machine()
        for file in sorted(self._folder.glob("*" + SUFFIX)):
            if file.name not in self._read:
                self._read.add(file.name)
                try:
                    made_for, contents = pickle.loads(file.read_bytes())
                except Exception:  # whatever pickle makes of a damaged file
                    file.unlink(missing_ok=True)
                    continue
                if made_for == machine:
                    self._known.add(contents)

    def write(self) -> None:
        """Write what was added since the last time into a file of its own."""
        if not self._new.functions:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=self._folder, delete=False) as file:
            unfinished = Path(file.name)
            try:
                pickle.dump((_machine(), self._new), file)
                file.close()
                finished = unfinished.replace(unfinished.with_name(unfinished.name + SUFFIX))
            except BaseException:
                unfinished.unlink()
                raise
        self._read.add(finished.name)
        self._known.add(self._new)
        self._new = _Contents({}, {})

    def find(self, function: Callable[..., Any], args: tuple[Any, ...]) -> Translation | None:
        """The translation of a function for these types of arguments, if it was kept whole.

        Somebody may have cleared the cache while others wrote: then a file calls what is gone.
        """
        if not self._covers(function):
            return None
        for pickled in self._known.functions.get(_name(function), []):
            signature, description, environment, key = pickle.loads(pickled)
            library = self._restore(key) if tuple(signature.args) == args else None
            if library is not None:
                return Translation(signature, description, environment, library)
        return None

    def add(self, function: Callable[..., Any], translation: Translation) -> None:
        """Keep a translation, from the next `write` on; not one that holds addresses."""
        key = self._keep(translation.library) if self._covers(function) else None
        if key is not None:
            pickled = dumps((*translation[:-1], key))
            self._new.functions.setdefault(_name(function), []).append(pickled)

    def _restore(self, key: str) -> TranslatedLibrary | None:
        """The library of a part, one for each in a process; None where a part of it is missing."""
        if key not in self._libraries:
            part = self._known.parts.get(key)
            if part is None:
                return None
            callees = [self._restore(callee) for callee in part.callees]
            found = [callee for callee in callees if callee is not None]
            if len(found) < len(callees):
                return None
            library = TranslatedLibrary(cpu_target.target_context.codegen(), part.name)
            library.restore(part.code, found, pickle.loads(part.environments))
            self._libraries[key], self._keys[library] = library, key
        return self._libraries[key]

    def _keep(self, library: CodeLibrary) -> str | None:
        """Key of the part that a library has become; None if it holds addresses."""
        if library not in self._keys:
            self._keys[library] = self._keep_part(library)
        return self._keys[library]

    def _keep_part(self, library: CodeLibrary) -> str | None:
        callees: list[str] = []
        if isinstance(library, TranslatedLibrary):
            code, alive = library.code, library.alive
            for callee in library.callees:
                key = self._keep(callee)
                if key is None:
                    return None
                callees.append(key)
        else:
            module = library._get_module_for_linking()
            code, alive = module.as_bitcode(), tuple(environments(module))
        if library.has_dynamic_globals:
            return None
        key = hashlib.sha256(
            b"\0".join([code, *(callee.encode() for callee in callees)])
        ).hexdigest()
        lasting = tuple(environment for environment in alive if environment.can_cache())
        self._new.parts[key] = _Part(library.name, code, tuple(callees), dumps(lasting))
        return key


def _name(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _machine() -> tuple[str, ...]:
    """Target (processor and its features) that machine code of this process is made for."""
    machine: tuple[str, ...] = cpu_target.target_context.codegen().magic_tuple()
    return machine
