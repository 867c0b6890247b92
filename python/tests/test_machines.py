"""Machines and laws, those of the package and those written in Python."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import precomp
from precomp import laws

Array = npt.NDArray[np.float64]


class Lagging:
    """A machine whose axes follow their commands through a first-order lag."""

    def __init__(self, time_s: float = 0.005) -> None:
        self.spec = precomp.MachineSpec("ballscrew")
        self.time_s = time_s
        self.runs = 0

    def run(self, reference: Array, period_s: float) -> Array:
        self.runs += 1
        share = 1.0 - np.exp(-period_s / self.time_s)
        actual, at = np.empty_like(reference), reference[0]
        for sample, wanted in enumerate(reference):
            at = at + share * (wanted - at)
            actual[sample] = at
        return actual


class Push:
    """A law that adds a share of the tracking error of the command."""

    def update(self, desired: Array, reference: Array, actual: Array, period_s: float) -> Array:
        assert desired.shape == reference.shape == actual.shape and period_s > 0.0
        return reference + 0.5 * (desired - actual)


def rms(run: precomp.Iteration | None) -> float:
    assert run is not None
    return float(run.figures["contour_um"]["rms"])


@pytest.mark.parametrize(
    "law", [laws.Spatial(), laws.Spatial(decreasing=True), laws.Tracking(), laws.NormOptimal(), laws.OneShot(), Push(), None]
)
def test_a_machine_of_ones_own_learns(law: laws.Spatial | laws.Tracking | laws.NormOptimal | laws.OneShot | Push | None) -> None:
    machine = Lagging()
    learned = precomp.learn("curve:circle", machine, law, runs=4, feed=40)
    assert machine.runs >= len(learned.iterations)
    assert rms(learned.best) < 0.6 * rms(learned.iterations[0])
    assert learned.iterations[0].reference.shape == learned.desired.shape


def test_a_machine_of_ones_own_is_compared(model: precomp.Model) -> None:
    machine = Lagging()
    compared = precomp.compare("curve:circle", machine=machine, model=model, gain=0.8, low_pass=100, runs=2)
    methods = compared.figures["paths"][0]["methods"]
    assert methods["spatial-ilc"]["rms_um"] < methods["uncompensated"]["rms_um"]
    # It runs on copies.
    assert machine.runs == 0


def test_a_seeded_machine_gets_the_seeds(model: precomp.Model) -> None:
    seeds: list[int] = []

    class Seeded(Lagging):
        def seeded(self, seed: int) -> Lagging:
            seeds.append(seed)
            return Lagging()

    precomp.compare("curve:circle", machine=Seeded(), gain=0.8, low_pass=100, runs=1, seeds=2)
    assert len(set(seeds)) >= 2


def test_exceptions_of_machines_and_laws_come_back() -> None:
    class Broken(Lagging):
        def run(self, reference: Array, period_s: float) -> Array:
            raise ConnectionError("the control does not answer")

    class Short(Lagging):
        def run(self, reference: Array, period_s: float) -> Array:
            return reference[:-1]

    class Wrong:
        def update(self, *_: object) -> Array:
            return np.zeros((3, 3))

    with pytest.raises(ConnectionError, match="does not answer"):
        precomp.learn("curve:circle", Broken(), laws.Spatial())
    with pytest.raises(ConnectionError, match="does not answer"):
        precomp.compare("curve:circle", machine=Broken(), gain=0.8, low_pass=100)
    with pytest.raises(precomp.UsageError, match="one for each"):
        precomp.learn("curve:circle", Short(), laws.Spatial())
    with pytest.raises(precomp.UsageError, match="`update` has to return"):
        precomp.learn("curve:circle", Lagging(), Wrong())
    with pytest.raises(precomp.UsageError, match="attribute `spec`"):
        precomp.learn("curve:circle", object(), laws.Spatial())  # type: ignore[arg-type]


def test_the_machines_of_the_package(model: precomp.Model) -> None:
    spec = precomp.MachineSpec("ballscrew")
    simulated = precomp.SimulatedMachine(spec, seed=7, noise=0)
    run = precomp.simulate("curve:circle", simulated)
    again = precomp.SimulatedMachine(spec, seed=7, noise=0).run(run.reference)
    np.testing.assert_array_equal(run.actual, again)
    assert isinstance(simulated, precomp.Machine)
    learned = model.learned_machine()
    forecast = model.predict("curve:circle")
    np.testing.assert_array_equal(learned.run(forecast.reference), forecast.actual)
    assert rms(precomp.learn("curve:circle", simulated, laws.Spatial(), runs=2).best) < run.figures["contour_um"]["rms"]
    # Its own text describes the same machine.
    assert precomp.MachineSpec(spec.to_toml()).to_toml() == spec.to_toml()


def test_laws_on_the_model(model: precomp.Model, folder: Path) -> None:
    by_name = model.compensate("curve:circle", law="one-shot")
    by_object = model.compensate("curve:circle", law=laws.OneShot())
    assert by_name.figures["law"] == "one-shot"
    assert by_name.content == by_object.content
    with pytest.raises(precomp.UsageError, match=r"precomp\.learn"):
        model.compensate("curve:circle", law=laws.Spatial())  # type: ignore[arg-type]
