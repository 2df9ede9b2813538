from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.settings.toml_file import LARGEST_BYTES, load_toml


def refusal(path: Path) -> str:
    """Message for a file, without the folder it lies in."""
    with pytest.raises(InputError) as raised:
        load_toml(path)
    message = str(raised.value)
    assert len(message.splitlines()) == 1
    assert message.startswith(f"{path}: ")
    return message.removeprefix(f"{path}: ")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "cycle.toml"


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "byte order mark"])
def test_sections_and_values_are_read(file: Path, mark: bytes) -> None:
    file.write_bytes(mark + "[cycle]\r\ndwell_s = 9\r\nname = 'Köln'\r\n".encode())
    assert load_toml(file) == {"cycle": {"dwell_s": 9, "name": "Köln"}}


def test_a_missing_file(file: Path) -> None:
    assert refusal(file) == "no such file; give the path of a TOML file"


def test_a_folder(tmp_path: Path) -> None:
    assert refusal(tmp_path) == "is a folder; give the path of a TOML file in it"


def test_an_unreadable_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)  # file modes do not stop root
    assert refusal(file) == "may not be read; change its permissions"


def test_a_file_in_another_encoding(file: Path) -> None:
    file.write_bytes(b"dwell_s = 9\nname = 'K\xf6ln'\n")
    assert refusal(file) == "line 2: not UTF-8 text; save the file as UTF-8"


def test_malformed_toml_names_line_and_column(file: Path) -> None:
    file.write_text("[cycle]\ndwell_s 9\n")
    assert refusal(file).startswith("line 2, column 9: not valid TOML: ")


def test_a_key_given_twice(file: Path) -> None:
    file.write_text("dwell_s = 9\ndwell_s = 10\n")
    assert refusal(file).startswith("line 2, column ")


@pytest.mark.parametrize(
    "text",
    ["a = " + "[" * 5000, "a = " + "9" * 5000, "a = 2026-13-45", "a = '''"],
    ids=["nested", "digits", "date", "open text"],
)
def test_toml_that_breaks_other_readers(file: Path, text: str) -> None:
    file.write_text(text)
    assert "not valid TOML: " in refusal(file)


def test_a_file_too_large_for_settings(file: Path) -> None:
    file.write_bytes(b"#" * (LARGEST_BYTES + 1))
    assert "is larger than 1000000 bytes" in refusal(file)


@pytest.mark.parametrize("name", ["no\0file.toml", "x" * 5000])
def test_a_path_that_no_file_can_have(name: str) -> None:
    with pytest.raises(InputError, match="cannot be read: "):
        load_toml(name)


@given(content=st.binary() | st.text().map(str.encode))
def test_any_content_gives_a_dictionary_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    file = tmp_path_factory.getbasetemp() / "any.toml"
    file.write_bytes(content)
    try:
        assert isinstance(load_toml(file), dict)
    except InputError as error:
        assert len(str(error).splitlines()) == 1
