"""The one decorator of the compiled core, and the cache that cannot go stale.

Numba's own file cache looks only at the file of the function it compiles: a callee, a table,
a constant or the field order of a record changed in another file goes unnoticed and the old
machine code runs on. So the cache lives in a folder named by a hash of every core source and of
the versions that shape the machine code; a change anywhere simply finds an empty folder.

With ``NUMBA_DISABLE_JIT=1`` every function stays plain Python: debugger, coverage, mutation tests.
"""

import hashlib
import inspect
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar, cast

import llvmlite
import numba
from numba import config
from platformdirs import user_cache_path

import opensuction.kernel.compiler.replacement  # noqa: F401 - gives records their ``_replace``
from opensuction.kernel import private_file
from opensuction.kernel.compiler import dispatcher
from opensuction.kernel.compiler.store import Store

PACKAGE = Path(__file__).resolve().parents[1]

CORE_ROOMS = (
    "kernel",
    "hysteresis",
    "control",
    "safety",
    "twin",
    "procedure",
    "identification",
    "controller",
    "simulation",
)
"""Rooms whose sources can end up in machine code."""

JIT_SETTING = "DISABLE_JIT"
"""Numba's setting, from ``NUMBA_DISABLE_JIT``."""

KEPT_CACHES = 4
"""How many cache folders survive pruning: one for each of a few checkouts or versions in use."""

FOLDER_NAME = re.compile("[0-9a-f]{16}")
"""What `sources_hash` returns."""

Function = TypeVar("Function", bound=Callable[..., object])


def sources_hash(package: Path = PACKAGE) -> str:
    """Hash of every core source file and of the versions that shape the machine code.

    package: folder that holds the rooms. Returns 16 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for version in (platform.python_version(), numba.__version__, llvmlite.__version__):
        digest.update(version.encode() + b"\0")
    for room in CORE_ROOMS:
        for source in sorted((package / room).rglob("*.py")):
            digest.update(str(source.relative_to(package)).encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_root() -> Path:
    """Folder that holds the cache folders: ``OPENSUCTION_CACHE_DIR`` or the user's cache.

    Falls back to the system's temporary folder where neither can be written.
    """
    chosen = os.environ.get("OPENSUCTION_CACHE_DIR")
    root = Path(chosen) if chosen else user_cache_path("opensuction") / "compiled"
    try:
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root):
            return root
    except OSError:
        return _private_root()


def _private_root() -> Path:
    """Temporary folder of this user alone: machine code is loaded from it.

    A folder of that name which belongs to somebody else, or which others may write, could hold
    their code: then a fresh folder of this process serves.
    """
    if hasattr(os, "getuid"):
        root = Path(tempfile.gettempdir()) / f"opensuction-compiled-{os.getuid()}"
        with suppress(OSError):  # a file, or a link, of that name
            private_file.make_folder(root)
        if private_file.is_own_folder(root):
            return root
    return Path(tempfile.mkdtemp(prefix="opensuction-compiled-"))


def prune(root: Path, keep: Path, kept: int = KEPT_CACHES) -> None:
    """Remove all but the most recently used cache folders in ``root``; never ``keep``.

    Only folders named like a hash of sources are touched: ``root`` may be anybody's folder.
    """
    folders = [
        entry
        for entry in root.iterdir()
        if entry.is_dir() and entry != keep and FOLDER_NAME.fullmatch(entry.name)
    ]
    folders.sort(key=lambda entry: entry.stat().st_mtime, reverse=True)
    for folder in folders[kept - 1 :]:
        shutil.rmtree(folder, ignore_errors=True)


def kept_caches() -> tuple[Path, ...]:
    """Cache folders of this and of earlier versions, in the order of their names."""
    root = CACHE_FOLDER.parent
    return tuple(sorted(entry for entry in root.iterdir() if FOLDER_NAME.fullmatch(entry.name)))


def clear_cache() -> tuple[Path, ...]:
    """Remove the machine code of every version; returns the folders that it was in.

    Only folders named like a hash of sources are touched. Raises OSError where one stays.
    """
    folders = kept_caches()
    for folder in folders:
        for file in [entry for entry in folder.rglob("*") if entry.is_file()]:
            file.unlink()
        if folder != CACHE_FOLDER:  # a process of these sources may be about to write into it
            shutil.rmtree(folder)
    return folders


def prepare_cache() -> Path:
    """Create and mark as used the cache folder of these sources; prune older ones."""
    root = cache_root()
    folder = root / sources_hash()
    folder.mkdir(exist_ok=True)
    os.utime(folder)
    prune(root, folder)
    return folder


CACHE_FOLDER = prepare_cache()
"""Cache folder of this process."""


def is_core(function: Callable[..., object]) -> bool:
    """True where `sources_hash` tells of any change of a function: not of one made in a call."""
    source = Path(function.__code__.co_filename)
    if not source.is_relative_to(PACKAGE) or "<locals>" in function.__qualname__:
        return False
    return source.relative_to(PACKAGE).parts[0] in CORE_ROOMS


STORE = Store(CACHE_FOLDER / "translated", is_core)
"""What compiled callers link, kept in this folder."""


def compiled(function: Function) -> Function:
    """Compile a core function on its first call; the same source runs as plain Python.

    Released lock (``nogil``) so that trials can use threads, bounds checked, Python's division
    errors, and no fast-math: results must not depend on how a sum was regrouped. Callees are
    inlined: passing nested records between functions costs more than most of them compute
    (a tick of the closed loop takes 0.42 us inlined, 0.87 us not).
    """
    if getattr(config, JIT_SETTING):
        return function
    made = dispatcher.make(function, boundscheck=True)
    made.keep(CACHE_FOLDER, STORE)
    return cast(Function, made)


def compiled_generated(function: Function) -> Function:
    """``compiled`` for the generated straight-line code of `kernel.codegen`.

    It has no file that a cache could key on: it is linked into the machine code of whoever calls
    it and cached with that. It checks the size of its row once, not at each column.
    """
    if getattr(config, JIT_SETTING):
        return function
    function.__qualname__ += "_" + _content_hash(function)
    return cast(Function, dispatcher.make(function, boundscheck=False))


def _content_hash(function: Callable[..., object]) -> str:
    """Hash of what a function does and refers to; 16 hexadecimal digits.

    Generated functions of one name are linked together, and the name must tell them apart: what
    numba adds to it is only the order in which a process came to compile them.
    """
    code, scope = function.__code__, function.__globals__
    known = [scope[name] for name in code.co_names if name in scope]
    named = [
        one.__name__
        if inspect.ismodule(one)
        else (getattr(one, "__module__", ""), getattr(one, "__qualname__", one))
        for one in known
    ]
    content = repr((code.co_code, code.co_consts, code.co_names, named))
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def as_python(function: Function) -> Function:
    """A compiled function as it is written, for whoever calls it seldom and compiles nothing.

    Only for one that calls no other: those would be compiled.
    """
    return cast(Function, getattr(function, "py_func", function))
