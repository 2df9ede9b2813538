"""Where results go: what stands there already is never overwritten unasked."""

from pathlib import Path

import pytest

from opensuction.cli import output_folder
from opensuction.kernel.errors import InputError


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("below", ["", "sub", "sub/deeper"])
def test_a_file_in_the_way_is_named_and_kept(tmp_path: Path, below: str, force: bool) -> None:
    file = tmp_path / "kept"
    file.write_text("mine")
    with pytest.raises(InputError, match="is a file; name a folder") as refused:
        output_folder.check(file / below, force)
    assert str(file) in str(refused.value)
    assert file.read_text() == "mine"


def test_what_a_folder_holds_is_replaced_only_with_force(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("older")
    with pytest.raises(InputError, match="is not empty; name another one or add --force"):
        output_folder.check(tmp_path, force=False)
    output_folder.check(tmp_path, force=True)
    output_folder.check(tmp_path / "new", force=False)
    assert (tmp_path / "report.html").read_text() == "older"
