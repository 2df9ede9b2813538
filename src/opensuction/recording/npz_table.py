"""NumPy archives (``.npz``): named arrays, each a column. Pickled objects are never loaded."""

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.errors import InputError
from opensuction.recording.array_column import read_numbers
from opensuction.recording.bound import MOST_SAMPLES, describe_excess

MAGIC = b"PK\x03\x04"
"""How any zip archive begins."""
SUFFIX = ".npy"
WIDEST_BYTES = 16
"""Of a number, as NumPy stores the widest; what an array may take unpacked is known before."""
HEADING_BYTES = 65536

DAMAGED = (zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, NotImplementedError)
"""What comes of an archive that is cut off, altered or packed in another way."""


def is_archive(path: Path) -> bool:
    """True for a zip archive of NumPy's: it holds arrays and nothing else."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except DAMAGED:
        return False
    return bool(names) and all(name.endswith(SUFFIX) for name in names)


def read_names(path: Path) -> tuple[str, ...]:
    """Names of the arrays."""
    with zipfile.ZipFile(path) as archive:
        return tuple(name.removesuffix(SUFFIX) for name in archive.namelist())


def read_columns(
    path: Path, wanted: Sequence[str], allow_missing: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Numbers of the columns that are wanted; see `table.read_columns`."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            sizes = {one.filename: one.file_size for one in archive.zip.infolist()}
            values = {name: _read(path, name, archive, sizes) for name in wanted}
    except (*DAMAGED, MemoryError):  # an array that says it is larger than the memory
        raise InputError(f"{path}: is damaged or incomplete; save it again") from None
    return {name: read_numbers(path, name, row, allow_missing) for name, row in values.items()}


def _read(
    path: Path, name: str, archive: np.lib.npyio.NpzFile, sizes: dict[str, int]
) -> NDArray[np.generic]:
    size_bytes = sizes.get(f"{name}{SUFFIX}", 0)
    if size_bytes > WIDEST_BYTES * MOST_SAMPLES + HEADING_BYTES:
        raise InputError(f"{path}: {name!r} {describe_excess(size_bytes // WIDEST_BYTES)}")
    try:
        values: NDArray[np.generic] = archive[name]
    except ValueError as error:
        if "pickle" in str(error):
            raise InputError(
                f"{path}: {name!r} holds Python objects, whose loading could run code; save it "
                "as an array of numbers"
            ) from None
        raise InputError(f"{path}: {name!r} is damaged; save it again") from None
    return values
