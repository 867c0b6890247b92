"""Options by keyword, as types. Names, meaning and ranges are those of the command line: ``precomp COMMAND --help`` explains each."""

import os
from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict, Union

_Offset = Sequence[float]


class LogOptions(TypedDict, total=False):
    """How a log is read."""

    columns: Union[str, Mapping[str, str], None]
    period: Union[float, None]


class ProgramOptions(TypedDict, total=False):
    """How a part program is read and planned."""

    dialect: Union[Literal["fanuc", "linuxcnc", "sinumerik"], None]
    passive: Union[str, Sequence[str], None]
    block_delete: Union[bool, None]
    macros: Literal["keep", "unknown"]
    expand: bool
    decimal_point: Union[Literal["unit", "least-increment"], None]
    work_offset: Union[_Offset, Mapping[str, _Offset], None]
    tool_length: float
    corner_tolerance: Union[float, None]
    feed: float


class OutputOptions(TypedDict, total=False):
    """How a compensated path is written."""

    controller: Union[str, "os.PathLike[str]", None]
    format: Union[Literal["g93", "g94", "keep", "table", "pvt"], None]
    decimals: Union[int, None]
    spacing: Union[float, None]


class CompensateOptions(ProgramOptions, OutputOptions, LogOptions, total=False):
    """Options of ``Model.compensate``."""

    effort: Literal["fast", "normal", "best"]
    iterations: Union[int, None]
    max_shift: Union[float, None]
    max_rotation: float
    strict: bool
    cycle_limit: Union[float, None]
    keep_stops: bool
    tolerance: Union[str, None]
    keep_time: bool


class TrainOptions(LogOptions, total=False):
    """Options of ``train``."""

    predictor: Union[str, "os.PathLike[str]"]
    features: Literal["i", "ii", "iii"]
    held_out: float
    checkpoints: Union[str, "os.PathLike[str]", None]


class SimulationOptions(TypedDict, total=False):
    """Options of a simulated machine."""

    sensor: Union[Literal["motor", "table"], None]
    noise: float


class SimulateOptions(ProgramOptions, SimulationOptions, total=False):
    """Options of ``simulate``."""


class MeasureOptions(ProgramOptions, LogOptions, total=False):
    """Options of ``measure``."""

    estimator: Literal["exact", "hermite-foot", "spline-search", "moving-window", "circle", "tangent"]
    readback: bool


class ExciteOptions(ProgramOptions, OutputOptions, total=False):
    """Options of ``excite``."""

    seconds: float
    travel: float
    rotation: float
    origin: Mapping[str, float]


class CompareOptions(ProgramOptions, SimulationOptions, total=False):
    """Options of ``compare``."""

    seeds: int
    runs: int
    gain: Union[float, None]
    low_pass: Union[float, None]
    law: Literal["model-based", "one-shot", "tracking", "norm-optimal", "cross-coupled"]
    iterations: int
    programs: bool


class LearnOptions(ProgramOptions, total=False):
    """Options of ``learn``."""

    runs: int
    max_shift: Union[float, None]
    max_rotation: float
