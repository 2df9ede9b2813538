"""Backends of machines: the name in a folder decides which module is loaded."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from opensuction.kernel.errors import InputError
from opensuction.machine import backend
from opensuction.machine.backend import BACKEND


@pytest.fixture
def other(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Another kind of machine."""
    module = ModuleType("other_machine")
    module.attach = lambda folder: f"attached to {folder.name}"  # type: ignore[attr-defined]
    module.hand_of = lambda _: None  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "other_machine", module)
    monkeypatch.setitem(backend.MODULES, "other", "other_machine")
    return module


@pytest.mark.usefixtures("other")
def test_a_folder_is_attached_to_by_the_kind_that_it_names(tmp_path: Path) -> None:
    backend.name_backend(tmp_path, "other")
    assert backend.attach(tmp_path) == f"attached to {tmp_path.name}"  # type: ignore[comparison-overlap]
    assert backend.load(tmp_path).hand_of(tmp_path) is None


def test_a_folder_that_names_none_is_no_machine(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=rf"no machine in .*: no {BACKEND} names its kind"):
        backend.attach(tmp_path)


@pytest.mark.parametrize("named", ["robot", "", "twin; rm", "opensuction.machine.twin"])
def test_an_unknown_kind_is_refused_with_those_that_are_known(named: str, tmp_path: Path) -> None:
    (tmp_path / BACKEND).write_text(named)
    with pytest.raises(InputError, match=r"unknown kind of machine .*; known: twin$"):
        backend.attach(tmp_path)


def test_what_is_no_text_names_none(tmp_path: Path) -> None:
    (tmp_path / BACKEND).write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="names its kind"):
        backend.load(tmp_path)


def test_every_kind_has_what_a_backend_has(tmp_path: Path) -> None:
    for name in backend.MODULES:
        backend.name_backend(tmp_path, name)
        found = backend.load(tmp_path)
        assert callable(found.attach)
        assert callable(found.hand_of)
