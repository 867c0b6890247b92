"""A fleet on a local Ray of two workers gives the same bytes as the command, and goes on where it was stopped."""

import os
import subprocess
from pathlib import Path

import pytest

import precomp
import precomp.fleet

COMMAND = os.environ.get("PRECOMP_FLEET")
TRAIN = ["--predictor", "linear", "--days", "1", "--healthy-days", "1"]


def command(*arguments: str) -> None:
    assert COMMAND is not None
    subprocess.run([COMMAND, "fleet", *arguments], check=True, capture_output=True)


def test_a_folder_without_machines_is_refused(tmp_path: Path) -> None:
    with pytest.raises(precomp.Error, match="machine=NAME"):
        precomp.fleet.machines(tmp_path)


def test_tasks_give_the_bytes_of_the_command_and_repeat_nothing(tmp_path: Path) -> None:
    ray = pytest.importorskip("ray", reason="Ray is not installed")
    if COMMAND is None:
        pytest.skip("PRECOMP_FLEET does not name a command with the feature fleet")
    plant, alone, models = (str(tmp_path / name) for name in ("plant", "alone", "models"))
    command("simulate", plant, "--machines", "2", "--minutes", "0.2", "--days", "3")
    command("train", plant, "-o", alone, *TRAIN)
    command("watch", plant, "-m", alone, "-o", str(tmp_path / "alone.parquet"), "--only", "random-1")
    ray.init(num_cpus=2, include_dashboard=False)
    try:
        precomp.fleet.train(plant, models, command=COMMAND, options=TRAIN)
        again = precomp.fleet.train(plant, models, command=COMMAND, options=TRAIN)
        assert all("has a model" in said for said in again.values())
        precomp.fleet.watch(plant, models, tmp_path / "tables", command=COMMAND)
    finally:
        ray.shutdown()
    for file in Path(alone).iterdir():
        assert file.read_bytes() == (Path(models) / file.name).read_bytes()
    assert (tmp_path / "alone.parquet").read_bytes() == (tmp_path / "tables" / "random-1.parquet").read_bytes()
