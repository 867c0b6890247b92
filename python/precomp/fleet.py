"""A fleet of machines on Ray: one task a machine.

Every task is the command `precomp fleet` for one machine, in a build with the feature `fleet`, so that the files are the same bytes as without Ray, and a
training that was stopped goes on: machines with a finished model are passed over. On several computers folders and command have to be there under the
same paths. `ray.init(...)` beforehand chooses the cluster; without it Ray starts on this computer.
"""

import shutil
import subprocess
from collections.abc import Callable, Iterable
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from precomp._precomp import Error

StrPath = str | PathLike[str]

_MACHINE = "machine="


def machines(folder: StrPath) -> list[str]:
    """The names of the machines whose logs lie in `folder` under `machine=NAME/`, in order.

    Raises `precomp.Error` where there is none.
    """
    found = [path.name for path in Path(folder).glob(f"{_MACHINE}*") if path.is_dir()]
    if not found:
        raise Error(f"{fspath(folder)} holds no folder `machine=NAME`; logs are expected as machine=NAME/date=YYYY-MM-DD/*.parquet")
    return sorted(name.removeprefix(_MACHINE) for name in found)


def train(
    folder: StrPath, models: StrPath, *, only: Iterable[str] | None = None, command: StrPath = "precomp", options: Iterable[str] = ()
) -> dict[str, str]:
    """Trains a model for every machine, or those of `only`: `precomp fleet train`. `options` are those of the command, as in `["--days", "3"]`.

    Returns what the command printed, by machine. Raises `precomp.Error` with the reasons where machines could not be trained; the others were.
    """
    path = fspath(models)
    return _each(folder, only, command, lambda name: ["train", fspath(folder), "-o", path, "--only", name, *options])


def watch(
    folder: StrPath,
    models: StrPath,
    out: StrPath,
    *,
    only: Iterable[str] | None = None,
    command: StrPath = "precomp",
    options: Iterable[str] = (),
) -> dict[str, str]:
    """Watches every machine, or those of `only`: `precomp fleet watch`, with a table `NAME.parquet` for each in the folder `out`.

    Returns what the command printed, by machine. Raises as `train`.
    """

    def arguments(name: str) -> list[str]:
        table = fspath(Path(out) / f"{name}.parquet")
        return ["watch", fspath(folder), "-m", fspath(models), "-o", table, "--only", name, *options]

    return _each(folder, only, command, arguments)


def _run(arguments: list[str]) -> tuple[int, str, str]:
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def _each(
    folder: StrPath, only: Iterable[str] | None, command: StrPath, arguments: Callable[[str], list[str]]
) -> dict[str, str]:
    """Runs the command for each machine in a task of its own."""
    try:
        import ray
    except ImportError as error:
        raise Error("Ray is not installed; pip install ray, or use the command precomp fleet") from error
    program = shutil.which(fspath(command))
    if program is None or _run([program, "fleet", "--help"])[0] != 0:
        raise Error(f"{fspath(command)} has no `fleet`; build it with cargo install --path . --features fleet, and state its path as command=")
    names = machines(folder) if only is None else list(only)
    task: Any = ray.remote(num_cpus=1)(_run)
    jobs = {name: task.remote([program, "fleet", *arguments(name)]) for name in names}
    done = {name: ray.get(job) for name, job in jobs.items()}
    failed = [f"{name}: {stderr.strip()}" for name, (status, _, stderr) in done.items() if status != 0]
    if failed:
        raise Error(f"{len(failed)} of {len(names)} machines failed:\n" + "\n".join(failed))
    return {name: stdout for name, (_, stdout, _) in done.items()}
