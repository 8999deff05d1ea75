"""Whether a file is one of our results, said before anything is read from it or written to it."""

from __future__ import annotations

from pathlib import Path

from mpmkit.errors import ResultsError

FORMAT = 2
"""Version of the group ``/mpmkit``."""
DAMAGED = (OSError, KeyError, RuntimeError, ValueError, IndexError, TypeError, AttributeError, MemoryError, OverflowError)
"""What a damaged file is noticed by: HDF5's own errors, and things that are missing or of another kind than they should be."""


def check_ours(path: Path) -> None:
    """Raise `ResultsError` unless `path` is a result file of mpmkit in a format known here."""
    import h5py

    if not path.exists():
        raise ResultsError(f"{path}: no such result file; a run writes it where its Record says")
    if not path.is_file():
        raise ResultsError(f"{path} is not a file; give the .vtkhdf or .hdf file that a run has written")
    size = path.stat().st_size
    with path.open("rb") as start:
        if start.read(8) != b"\x89HDF\r\n\x1a\n":
            raise ResultsError(f"{path} is not a result file: {'it is empty' if size == 0 else 'it is no HDF5 file at all'}")
    try:
        with h5py.File(path, "r", locking=False) as file:
            if "VTKHDF" not in file:
                raise ResultsError(f"{path} is not a result file: an HDF5 file without the group /VTKHDF")
            if "mpmkit" not in file or "format" not in file["mpmkit"].attrs:
                kind = file["VTKHDF"].attrs.get("Type", b"?")
                kind = kind.decode() if isinstance(kind, bytes) else kind
                raise ResultsError(
                    f"{path} is a VTKHDF file of another program (type {kind}): it has no group /mpmkit; open it in ParaView instead"
                )
            found = int(file["mpmkit"].attrs["format"])
    except DAMAGED as error:
        raise damaged(path, error) from error
    if found != FORMAT:
        raise ResultsError(
            f"{path} was written in format {found}, this mpmkit reads format {FORMAT}; read it with the version that wrote it"
        )


def damaged(path: Path, error: BaseException) -> ResultsError:
    """The error to raise for a file that cannot be read."""
    what = "truncated" if "truncated" in str(error) else "damaged"
    return ResultsError(
        f"{path} is {what} ({path.stat().st_size} bytes): {plain(error)}; copy it again from where it was written, or run the scene again"
    )


def plain(error: BaseException) -> str:
    """The reason without HDF5's words around it."""
    text = str(error).strip("'\"")
    inner = text[text.find("(") + 1 : text.rfind(")")] if "(" in text and text.endswith(")") else ""
    return inner if any(c.isalpha() for c in inner) else text
