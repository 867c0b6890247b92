"""Time of `train` and `compensate` from Python beside that of the command, in turns.

    python python/benches/speed.py target/release/precomp [ROUNDS [SECONDS OF LOGS]]

Prints the medians of every job and the ratios Python / command, in time and in processor time, which other work on the machine disturbs
less. The time of the command is that of its process; that from Python holds reading the logs, the model and the program, as the command's
does.
"""

import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import precomp

PART = "G21 G90 G94 G17\nG0 X0 Y0 Z0\n" + "".join(
    f"G1 X{20 + i % 3} Y{i} F2400\nG3 X{20 + i % 3} Y{i + 2} J1\nG1 X0\n" for i in range(0, 40, 2)
)


Times = tuple[float, float]
"""Time and processor time of a job, s."""


def times_of(job: Callable[[], object], who: int) -> Times:
    def processor_s() -> float:
        used = resource.getrusage(who)
        return used.ru_utime + used.ru_stime

    began, used = time.perf_counter(), processor_s()
    job()
    return time.perf_counter() - began, processor_s() - used


def main() -> None:
    command = sys.argv[1]
    rounds, log_s = (int(value) for value in [*sys.argv[2:], *("5", "60")[len(sys.argv) - 2 :]])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        recorded = precomp.record("ballscrew", seconds=log_s)
        logs = [folder / f"run-{index}.parquet" for index in range(len(recorded))]
        for path, log in zip(logs, recorded):
            log.save(path)
        part, model = folder / "part.nc", folder / "machine.model"
        part.write_text(PART + "M30\n")

        def run(*arguments: object) -> None:
            subprocess.run([command, *map(str, arguments)], check=True, capture_output=True)

        jobs: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {
            "train": (
                lambda: run("train", *logs, "--machine", "ballscrew", "-o", model),
                lambda: precomp.train(logs, machine="ballscrew").save(folder / "python.model"),
            ),
            "compensate": (
                lambda: run("compensate", part, "-m", model, "-o", folder / "command.nc"),
                lambda: precomp.Model.load(model).compensate(part).save(folder / "python.nc"),
            ),
        }
        for job, (by_command, by_python) in jobs.items():
            by_command(), by_python()
            turns = [
                (times_of(by_command, resource.RUSAGE_CHILDREN), times_of(by_python, resource.RUSAGE_SELF)) for _ in range(rounds)
            ]
            for index, kind in enumerate(("time", "processor time")):
                command_s = statistics.median(command[index] for command, _ in turns)
                python_s = statistics.median(python[index] for _, python in turns)
                ratio = statistics.median(python[index] / command[index] for command, python in turns)
                print(f"{job}, {kind}: command {command_s:.2f} s, Python {python_s:.2f} s, ratio {ratio:.3f}", flush=True)
        same = [(folder / "python.model", model), (folder / "python.nc", folder / "command.nc")]
        print("same bytes:", all(one.read_bytes() == other.read_bytes() for one, other in same))


if __name__ == "__main__":
    main()
