"""Learns how a CNC machine's axes lag and stick, and pre-compensates part programs before their first run.

>>> model = precomp.train("runs/full.csv", machine="mill.toml")       # doctest: +SKIP
>>> model.compensate("part.nc").save("compensated.nc")                # doctest: +SKIP

Lengths are in mm, angles in rad, times in s; a unit at the end of a name is the unit of its value. Options are those of the command
line: ``max_shift=0.2`` is ``--max-shift 0.2``.
"""

from precomp import laws, options
from precomp._precomp import (
    Comparison,
    Compensated,
    Error,
    Excitation,
    ExcitationRun,
    Iteration,
    LearnedMachine,
    Learned,
    Log,
    MachineSpec,
    Measurement,
    Model,
    Run,
    SimulatedMachine,
    UsageError,
    __version__,
    compare,
    excite,
    learn,
    measure,
    record,
    simulate,
    train,
)
from precomp._types import Law, Machine

__all__ = [
    "Comparison",
    "Compensated",
    "Error",
    "Excitation",
    "ExcitationRun",
    "Iteration",
    "Law",
    "LearnedMachine",
    "Learned",
    "Log",
    "Machine",
    "MachineSpec",
    "Measurement",
    "Model",
    "Run",
    "SimulatedMachine",
    "UsageError",
    "__version__",
    "compare",
    "excite",
    "laws",
    "learn",
    "measure",
    "options",
    "record",
    "simulate",
    "train",
]
