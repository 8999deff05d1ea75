"""Full disks: notice them before HDF5 does, since it may crash the process when a write fails half-way."""

from __future__ import annotations

import os
from typing import Any

_SLACK = 1 << 17
"""Bytes for the tables that HDF5 writes beside the data."""


def reserve(file: Any, n_bytes: int) -> None:
    """Claim room behind the end of an open h5py file.

    Parameters
    ----------
    file : h5py.File
        Open for writing.
    n_bytes : int
        Bytes of the data to come.

    Raises
    ------
    OSError
        If the disk, the quota or the allowed file size is exhausted; the file is as it was.
    """
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.id.get_vfd_handle(), file.id.get_filesize(), int(n_bytes) + _SLACK)
    else:
        import shutil

        if shutil.disk_usage(os.path.dirname(os.path.abspath(file.filename))).free < n_bytes + _SLACK:
            raise OSError(28, "No space left on device")


def close_trimmed(file: Any) -> None:
    """Close an h5py file and give back what was reserved and not used."""
    file.flush()
    path, used = file.filename, file.id.get_filesize()
    file.close()
    if os.path.getsize(path) > used:
        os.truncate(path, used)


def abandon(file: Any) -> None:
    """Close an h5py file after a failed write without letting HDF5 write to it again, which could crash."""
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        os.dup2(nowhere, file.id.get_vfd_handle())
        os.close(nowhere)
        file.close()
    except (OSError, RuntimeError, ValueError):
        pass  # the reason of the failed write is what the user needs to see
