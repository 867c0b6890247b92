"""A machine, its logs and a model, made once for all tests; and the command line to compare with."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import precomp

SEED = 3

PROGRAM = """G21 G90 G94 G17
G0 X0 Y0 Z0
G1 X20 F2400
G3 X20 Y20 J10
G1 X0
G1 Y0
M30
"""


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the logs `run-0.parquet` and so on, `part.nc` and `machine.model`."""
    folder = tmp_path_factory.mktemp("precomp")
    (folder / "part.nc").write_text(PROGRAM)
    return folder


@pytest.fixture(scope="session")
def logs(folder: Path) -> list[Path]:
    """Files of an excitation that was recorded on the simulated machine."""
    paths = []
    for index, log in enumerate(precomp.record("ballscrew", seconds=20.0, seed=SEED)):
        paths.append(folder / f"run-{index}.parquet")
        log.save(paths[-1])
    return paths


@pytest.fixture(scope="session")
def model(logs: list[Path], folder: Path) -> precomp.Model:
    """A model that was trained in Python."""
    model = precomp.train(logs, machine="ballscrew", predictor="linear", seed=SEED)
    model.save(folder / "machine.model")
    return model


@pytest.fixture(scope="session")
def command() -> Callable[..., dict[str, Any]]:
    """Runs a command line as a process, and returns its figures."""

    def run(*arguments: object) -> dict[str, Any]:
        line = [sys.executable, "-m", "precomp", *map(str, arguments), "--json", "-"]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        figures: dict[str, Any] = json.loads(done.stdout)
        return figures

    return run
