"""Checkpoints: the whole state of a run in one file that is either whole or not there.

The file is HDF5 behind a header of 512 bytes (a *user block*, which HDF5 tools skip) with a magic word, the format and
a digest of all that follows. The digest is checked before HDF5 sees a byte, so a flipped bit anywhere is refused.
It is written under another name in the same folder, synced, and renamed; a run killed at any moment leaves the last good
checkpoint, and the one before it as ``.1``.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mpmkit._core.running.disk import abandon, close_trimmed, reserve
from mpmkit.errors import ResultsError

MAGIC = "mpmkit checkpoint"
FORMAT = 3
_HEADER = 512
_FAILURES = (OSError, RuntimeError, ValueError, TypeError)
"""What a full disk, a missing folder and values that no file can hold are raised as."""


def save(path: str | os.PathLike[str], arrays: Mapping[str, np.ndarray], attrs: Mapping[str, Any]) -> None:
    """Write a checkpoint, atomically; the previous one stays as ``PATH.1``.

    Parameters
    ----------
    path : path
        The file, by habit `paths.checkpoint_path` of the result file.
    arrays : mapping of str to array
        Numbers of any type and shape; "/" in a name nests. They come back to the bit.
    attrs : mapping
        Plain data (numbers, text, lists, mappings); floats come back to the bit, tuples as lists.

    Raises
    ------
    ResultsError
        If it cannot be written (no folder, full disk); the previous checkpoint is untouched.
    """
    seal(path, begin(path, arrays, attrs))


def begin(path: str | os.PathLike[str], arrays: Mapping[str, np.ndarray], attrs: Mapping[str, Any]) -> Path:
    """First half of `save`: write everything into a temporary file, for `seal`. The arrays may change afterwards."""
    import h5py

    path = Path(path)
    temporary = None
    try:
        text = json.dumps(attrs, default=_as_plain).encode()
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".tmp", dir=path.parent)
        os.close(handle)
        temporary = Path(name)
        file = h5py.File(temporary, "w", libver=("earliest", "v110"), locking=False, userblock_size=_HEADER)
        try:
            plain = {key: np.asarray(array) for key, array in arrays.items()}
            reserve(file, _HEADER + len(text) + sum(array.nbytes + 1024 for array in plain.values()))
            file.create_dataset("attrs", data=text, dtype=h5py.string_dtype("utf-8", max(1, len(text))))
            group = file.create_group("arrays")
            for key, array in plain.items():
                group.create_dataset(key, data=array, track_times=False)
            close_trimmed(file)
        except BaseException:
            abandon(file)
            raise
        temporary.chmod(0o666 & ~_umask())  # here and not in `seal`, whose thread must not touch the mask of all
        return temporary
    except BaseException as error:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        if isinstance(error, _FAILURES):
            raise _failed(path, error) from error
        raise


def seal(path: str | os.PathLike[str], temporary: Path) -> None:
    """Second half of `save`, the longer one: digest, sync to the disk, and the name; needs nothing of the run."""
    path = Path(path)
    try:
        with temporary.open("rb+") as raw:
            raw.write(_header(raw))
            raw.flush()
            os.fsync(raw.fileno())
        if path.exists():
            _keep(path)
        temporary.replace(path)
        _sync_folder(path.parent)
    except _FAILURES as error:
        raise _failed(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _failed(path: Path, error: BaseException) -> ResultsError:
    kept = "; the checkpoint before it is kept" if path.exists() else ""
    return ResultsError(f"{path}: cannot write the checkpoint ({error}){kept}")


def load(path: str | os.PathLike[str]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read a checkpoint.

    Returns
    -------
    arrays : dict of str to array
        As given to `save`.
    attrs : dict
        As given to `save`.

    Raises
    ------
    ResultsError
        If the file is missing, truncated, changed by a single bit, from another program, or of another format.
    """
    path = Path(path)
    try:
        return _load(path)
    except ResultsError as error:
        spare = previous(path)
        try:
            _load(spare)
        except ResultsError:
            raise error from None
        raise ResultsError(f"{error}\n  The checkpoint before it is whole: resume from {spare}") from None


def previous(path: str | os.PathLike[str]) -> Path:
    """Where the checkpoint before the last one is kept."""
    return Path(f"{os.fspath(path)}.1")


def remove_stale(path: str | os.PathLike[str]) -> list[Path]:
    """Delete temporary files that killed runs left beside `path`; call it before the first `save`."""
    path = Path(path)
    stale = sorted(path.parent.glob(f".{path.name}.*.tmp")) if path.parent.is_dir() else []
    for file in stale:
        file.unlink(missing_ok=True)
    return stale


def _load(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    import h5py

    if not path.is_file():
        raise ResultsError(f"{path}: no such checkpoint; a run writes it beside its result file, as NAME.ckpt.h5")
    with path.open("rb") as raw:
        header = raw.read(_HEADER)
        found = _fields(header)
        if found.get("magic") != MAGIC:
            raise ResultsError(f"{path} is not a checkpoint of mpmkit; give the .ckpt.h5 file that a run has written")
        if found.get("format") != str(FORMAT):
            raise ResultsError(
                f"{path} was written in checkpoint format {found.get('format')}, this mpmkit reads "
                f"format {FORMAT}; resume with the version that wrote it"
            )
        size, expected = path.stat().st_size, found.get("bytes", "")
        if str(size - _HEADER) != expected:
            raise ResultsError(f"{path} is truncated: {size - _HEADER} of {expected} bytes; copy it again or run the scene again")
        if _header(raw) != header:
            raise ResultsError(f"{path} is damaged: its content does not fit its checksum; copy it again or run the scene again")
    arrays: dict[str, np.ndarray] = {}
    with h5py.File(path, "r", locking=False) as file:
        attrs = json.loads(file["attrs"].asstr()[()])
        file["arrays"].visititems(lambda key, item: arrays.update({key: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return arrays, attrs


def _header(raw: Any) -> bytes:
    """What the first 512 bytes should be: lines of text, filled with zeros; leaves `raw` at its start."""
    raw.seek(0, os.SEEK_END)
    size = raw.tell() - _HEADER
    raw.seek(_HEADER)
    lines = f"magic {MAGIC}\nformat {FORMAT}\nbytes {size}\nblake2b {_digest(raw)}\n"
    raw.seek(0)
    return lines.encode().ljust(_HEADER, b"\0")


def _fields(header: bytes) -> dict[str, str]:
    lines = header.rstrip(b"\0").decode("ascii", "replace").splitlines()
    return dict(line.split(" ", 1) for line in lines if " " in line)


def _digest(raw: Any) -> str:
    """Of the rest of the file."""
    digest = hashlib.blake2b(digest_size=32)
    while block := raw.read(1 << 20):
        digest.update(block)
    return digest.hexdigest()


def _keep(path: Path) -> None:
    """Give the old checkpoint its second name; a link first, so there is always a file called `path`."""
    spare = previous(path)
    spare.unlink(missing_ok=True)
    try:
        os.link(path, spare)
    except OSError:
        # file systems without links: copy through a rename would leave a moment without a checkpoint
        import shutil

        shutil.copyfile(path, spare)


def _sync_folder(folder: Path) -> None:
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _as_plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"a checkpoint cannot hold {value!r}")
