"""`Record`: what of a run is kept, where and how often."""

from __future__ import annotations

from pathlib import Path

from mpmkit.errors import ParameterError, did_you_mean, shown
from mpmkit.parameters import define, parameter

SUFFIXES = (".vtkhdf", ".hdf")
"""File names that VTK and ParaView recognise as VTKHDF (ParaView before 5.12 knows only the second)."""


@define
class Record:
    """Keep a run in one file that ParaView opens while the run goes on, with its history and checkpoint beside it.

    The run ``disks.vtkhdf`` leaves ``disks.vtkhdf`` (particles over time), ``disks.history.csv`` (energies and momenta)
    and ``disks.ckpt.h5`` (to resume from).

    Raises
    ------
    ParameterError
        If the path does not end in .vtkhdf or .hdf, or a field is named twice.
    """

    path: str = parameter("result file, ending in .vtkhdf or .hdf", example="run.vtkhdf")
    every: float | None = parameter(
        "simulated time between two frames; none for start and end only", unit="s", gt=0, default=None, example=0.05
    )
    fields: tuple[str, ...] = parameter("particle fields of each frame", default=("x", "v", "stress"), example=("x", "v", "stress"))
    history: int = parameter("a row of the history every that many steps", ge=1, default=10, example=10, kw_only=True)
    overwrite: bool = parameter("replace existing results", default=False, example=False, kw_only=True)
    compress: bool = parameter(
        "gzip the frames: about a fifth smaller, ten times slower to write", default=False, example=False, kw_only=True
    )
    checkpoint: bool = parameter(
        "write checkpoints to resume from: at frames and every minute, 2 % of the time at most", default=True, example=True, kw_only=True
    )

    def __attrs_post_init__(self) -> None:
        if "\0" in self.path or any("\ud800" <= c <= "\udfff" for c in self.path):
            raise ParameterError(f"Record.path must be text that a file can be called, got {shown(self.path)}")
        suffix = Path(self.path).suffix
        if suffix not in SUFFIXES:
            near = did_you_mean(suffix, SUFFIXES) if suffix else ""
            wanted = Path(self.path).with_suffix(SUFFIXES[0]).name if Path(self.path).name else "run" + SUFFIXES[0]
            raise ParameterError(
                f"Record.path must end in .vtkhdf or .hdf, got {shown(self.path)}{near} (such as {wanted!r}; ParaView goes by the ending)"
            )
        twice = sorted({f for f in self.fields if self.fields.count(f) > 1})
        if twice:
            raise ParameterError(f"Record.fields must name each field once, got {', '.join(map(shown, twice))} more than once")
        for name in self.fields:
            if not name or "/" in name or "." in name:
                raise ParameterError(
                    f"Record.fields must be names of particle fields such as 'v' or 'stress', got {shown(name)}; "
                    "components are chosen when drawing"
                )
