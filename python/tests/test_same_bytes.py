"""Python and the command line give the same bytes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import precomp
import pytest
from conftest import SEED

Command = Callable[..., dict[str, Any]]
TRAIN = ("--machine", "ballscrew", "--predictor", "linear", "--seed", SEED)


def without_times(figures: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in figures.items() if key != "seconds"}


def test_the_model(model: precomp.Model, logs: list[Path], tmp_path: Path, command: Command) -> None:
    out = tmp_path / "command.model"
    figures = command("train", *logs, *TRAIN, "-o", out)
    assert out.read_bytes() == model.to_bytes()
    assert model.figures is not None
    assert without_times(model.figures) == without_times(figures)


def test_the_program(model: precomp.Model, folder: Path, tmp_path: Path, command: Command) -> None:
    out = tmp_path / "out.nc"
    figures = command("compensate", folder / "part.nc", "-m", folder / "machine.model", "-o", out)
    of_file = model.compensate(folder / "part.nc")
    assert of_file.changed
    assert of_file.content == out.read_bytes()
    assert of_file.figures["program"] == figures["program"]
    shared = of_file.figures.keys() & figures.keys()
    assert {key: of_file.figures[key] for key in shared} == {key: figures[key] for key in shared}
    # As text the program has no name, which its bytes do not show.
    of_text = model.compensate((folder / "part.nc").read_text())
    assert of_text.text == of_file.text
    of_file.save(tmp_path / "saved.nc")
    assert (tmp_path / "saved.nc").read_bytes() == out.read_bytes()


def test_a_program_with_options(model: precomp.Model, folder: Path, tmp_path: Path, command: Command) -> None:
    out = tmp_path / "out.nc"
    options = ("--max-shift", 0.004, "--work-offset", "-10,5,0", "--format", "g93", "--effort", "fast")
    command("compensate", folder / "part.nc", "-m", folder / "machine.model", "-o", out, *options)
    result = model.compensate(
        folder / "part.nc", max_shift=0.004, work_offset=[-10, 5, 0], format="g93", effort="fast"
    )
    assert result.content == out.read_bytes()
    assert result.content != model.compensate(folder / "part.nc").content


def test_a_reference(model: precomp.Model, folder: Path, tmp_path: Path, command: Command) -> None:
    reference = precomp.simulate("curve:crown", "ballscrew", noise=0)
    given = tmp_path / "crown.parquet"
    reference.save(given)
    for ending in ("csv", "parquet"):
        out = tmp_path / f"out.{ending}"
        command("compensate", given, "-m", folder / "machine.model", "-o", out)
        result = model.compensate(given)
        result.save(tmp_path / f"saved.{ending}")
        assert (tmp_path / f"saved.{ending}").read_bytes() == out.read_bytes()


def test_figures_of_runs(model: precomp.Model, folder: Path, tmp_path: Path, command: Command) -> None:
    part, log = folder / "part.nc", tmp_path / "run.parquet"
    run = precomp.simulate(part, "ballscrew", seed=5)
    assert run.figures == command("simulate", part, "--machine", "ballscrew", "--seed", 5, "-o", log)
    run.save(tmp_path / "saved.parquet")
    assert (tmp_path / "saved.parquet").read_bytes() == log.read_bytes()
    assert model.predict(part).figures == command("predict", part, "-m", folder / "machine.model")
    measured = command("measure", log, "--desired", part, "-m", folder / "machine.model")
    assert model.measure(log, part).figures == measured
    assert precomp.measure(log, part, model=model).figures == measured


def test_the_excitation(tmp_path: Path, command: Command) -> None:
    command("excite", "--machine", "ballscrew", "--seconds", 10, "--seed", 9, "-o", tmp_path / "command")
    excitation = precomp.excite("ballscrew", seconds=10, seed=9)
    excitation.save(tmp_path / "python")
    names = sorted(path.name for path in (tmp_path / "command").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "python").iterdir())
    assert "control-test.nc" in names
    for name in names:
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name
    program = excitation.runs[0].program
    assert program is not None and program.encode() == (tmp_path / "command" / f"{excitation.runs[0].name}.nc").read_bytes()


def test_the_next_excitation(model: precomp.Model, folder: Path, tmp_path: Path, command: Command) -> None:
    part = folder / "part.nc"
    options = ("--after", folder / "machine.model", "--for", part, "--work-offset", "0,0,0")
    command("excite", "--machine", "ballscrew", "--seconds", 10, *options, "-o", tmp_path / "command")
    excitation = precomp.excite("ballscrew", seconds=10, after=model, part=part, work_offset=[0, 0, 0])
    excitation.save(tmp_path / "python")
    for path in (tmp_path / "command").iterdir():
        assert (tmp_path / "python" / path.name).read_bytes() == path.read_bytes(), path.name
    with pytest.raises(precomp.UsageError):
        precomp.excite("ballscrew", part=part)


def test_the_comparison(model: precomp.Model, folder: Path, command: Command) -> None:
    options = ("--gain", 0.8, "--low-pass", 100, "--runs", 2, "--seed", 4)
    figures = command("compare", "curve:circle", "--machine", "ballscrew", "-m", folder / "machine.model", *options)
    compared = precomp.compare("curve:circle", machine="ballscrew", model=model, gain=0.8, low_pass=100, runs=2, seed=4)
    assert compared.figures == figures
    assert "first-run" in compared.report
