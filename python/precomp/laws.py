"""Laws of iterative learning control.

Each learns on a machine by ``precomp.learn(path, machine, law)``; those with a name in ``on_model`` also by
``Model.compensate(path, law=law)``. A law of one's own is any object with ``update(desired, reference, actual, period_s)``.
"""

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Spatial:
    """Moves the reference against the contour error at foot points (papers A and B).

    ``gain`` is the share of the error that an update takes off; with ``decreasing`` it is 1/j in run j, which averages noise.
    ``low_pass_hz`` filters every update without phase; ``None`` filters nothing.
    """

    gain: float = 0.8
    low_pass_hz: float | None = 100.0
    decreasing: bool = False

    kind: ClassVar[str] = "spatial"
    on_model: ClassVar[str | None] = None


@dataclass(frozen=True)
class Tracking:
    """Moves the reference of every axis against its tracking error."""

    gain: float = 0.8
    low_pass_hz: float | None = 100.0
    decreasing: bool = False

    kind: ClassVar[str] = "tracking"
    on_model: ClassVar[str | None] = "tracking"


@dataclass(frozen=True)
class OneShot:
    """Moves the reference once by the contour error (paper D)."""

    kind: ClassVar[str] = "one-shot"
    on_model: ClassVar[str | None] = "one-shot"


@dataclass(frozen=True)
class NormOptimal:
    """Norm-optimal learning with the axes' impulse responses, which are probed first (paper E).

    ``contour_share`` is the share of the contour error in the cost: 0 for that of every axis, 1 for the contour error alone.
    """

    contour_share: float = 0.0

    kind: ClassVar[str] = "norm-optimal"

    @property
    def on_model(self) -> str | None:
        """Name of the law on a model."""
        return {0.0: "norm-optimal", 1.0: "cross-coupled"}.get(self.contour_share)


@dataclass(frozen=True)
class ModelBased:
    """Learning of the contour error on a model by Gauss-Newton steps. On a machine it is ``learn`` without a law."""

    kind: ClassVar[str] = "model-based"
    on_model: ClassVar[str | None] = "model-based"
