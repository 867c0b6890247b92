"""Time of `train` and `compensate` from Python beside that of the command, in turns.

    python python/benches/speed.py target/release/precomp [ROUNDS]

Prints the median of every job and the ratio Python / command. The time of the command is that of its process; the time from Python holds
reading the logs, the model and the program, as the command's does.
"""

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


def seconds(job: Callable[[], object]) -> float:
    began = time.perf_counter()
    job()
    return time.perf_counter() - began


def main() -> None:
    command, rounds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        logs = [folder / f"run-{index}.parquet" for index in range(len(precomp.excite("ballscrew").runs))]
        for path, log in zip(logs, precomp.record("ballscrew")):
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
            times = [(seconds(by_command), seconds(by_python)) for _ in range(rounds)]
            command_s, python_s = (statistics.median(column) for column in zip(*times))
            ratio = statistics.median(own / other for other, own in times)
            print(f"{job}: command {command_s:.2f} s, Python {python_s:.2f} s, ratio {ratio:.3f} (median of {rounds})")
        same = [(folder / "python.model", model), (folder / "python.nc", folder / "command.nc")]
        print("same bytes:", all(one.read_bytes() == other.read_bytes() for one, other in same))


if __name__ == "__main__":
    main()
