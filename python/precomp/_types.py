"""What the functions of the package take."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias, Union, runtime_checkable

import numpy as np
import numpy.typing as npt

Positions: TypeAlias = npt.NDArray[np.float64]
"""Positions: a row a sample, a column an axis; mm, rotary axes in rad."""


@runtime_checkable
class Machine(Protocol):
    """A machine: commanded motion in, actual motion out.

    A machine with a ``spec`` attribute (a ``MachineSpec``) says its axes and limits itself. ``compare`` runs copies of it at the same
    time: those of its method ``seeded(seed)`` where it has one, else deep copies.
    """

    def run(self, reference: Positions, period_s: float, /) -> Any:
        """The actual positions at the instants of `reference`, as an array of its shape."""


@runtime_checkable
class Law(Protocol):
    """How a reference is moved after a run."""

    def update(self, desired: Positions, reference: Positions, actual: Positions, period_s: float, /) -> Any:
        """The next reference, as an array of the shape of `reference`."""


class ArrowStream(Protocol):
    """A data frame that speaks Arrow's PyCapsule interface: of pandas (from 2.2), polars or pyarrow."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...


class Progress(Protocol):
    """Is told how far a long job is. An exception ends the job, and is raised."""

    def __call__(self, done: int, total: int, what: str, /) -> object: ...


FilePath: TypeAlias = Union[str, "os.PathLike[str]"]
Columns: TypeAlias = Mapping[str, npt.ArrayLike]
JSON: TypeAlias = dict[str, Any]
Names: TypeAlias = Sequence[str]
