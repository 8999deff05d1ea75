"""Where the files of a run lie, and whether they may be written."""

from __future__ import annotations

import os
from pathlib import Path

from mpmkit.errors import ResultsError, shown


def history_path(result: str | os.PathLike[str]) -> Path:
    """``disks.history.csv`` of ``disks.vtkhdf``."""
    return Path(result).with_suffix(".history.csv")


def left_path(result: str | os.PathLike[str]) -> Path:
    """``disks.left.csv`` of ``disks.vtkhdf``: particles that were taken out of the domain."""
    return Path(result).with_suffix(".left.csv")


def checkpoint_path(result: str | os.PathLike[str]) -> Path:
    """``disks.ckpt.h5`` of ``disks.vtkhdf``."""
    return Path(result).with_suffix(".ckpt.h5")


def claim(path: str | os.PathLike[str], *, overwrite: bool, what: str = "results", remove: bool = True) -> Path:
    """Check, before a long run, that `path` can be written; make its folder, remove an old file if that was asked for.

    Parameters
    ----------
    path : path
        The file.
    overwrite : bool
        Whether it may exist.
    what : str
        What messages call it.
    remove : bool
        Remove an old file now.

    Raises
    ------
    ResultsError
        If the file exists and `overwrite` is false, is no ordinary file, or its folder cannot be written.
    """
    path = Path(path)
    try:
        return _claim(path, overwrite, what, remove)
    except (OSError, ValueError) as error:  # a name that is too long, or that no file can have
        reason = getattr(error, "strerror", None) or error
        raise ResultsError(f"{shown(str(path))}: cannot write {what} here ({reason}); choose a path that can be written") from error


def _claim(path: Path, overwrite: bool, what: str, remove: bool) -> Path:
    if path.exists() or path.is_symlink():
        if path.is_dir():
            raise ResultsError(f"{path}: cannot write {what} here, this is a folder; give a file name")
        if not overwrite:
            raise ResultsError(
                f"{path} exists: {what} are never overwritten unasked; choose another path, move the file, "
                "or set overwrite=True (--overwrite on the command line)"
            )
    folder = path.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"{path}: cannot make the folder {folder} ({error.strerror}); choose a path that can be written") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ResultsError(f"{path}: the folder {folder} cannot be written; choose another path or change its permissions")
    if remove and (path.exists() or path.is_symlink()):
        try:
            # a reader that has the old file open keeps it; writing into it in place would confuse it
            path.unlink()
        except OSError as error:
            raise ResultsError(f"{path}: cannot replace the old {what} ({error.strerror})") from error
    return path
