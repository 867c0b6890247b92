"""Long jobs: progress, interrupts, threads, errors."""

import copy
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import precomp
from conftest import PROGRAM


def test_progress_is_told_in_order(model: precomp.Model) -> None:
    told: list[tuple[int, int, str]] = []
    threads = set()

    def progress(done: int, total: int, what: str) -> None:
        threads.add(threading.get_ident())
        told.append((done, total, what))

    model.compensate(PROGRAM, progress=progress)
    assert len(told) > 3 and all(0 < done <= total for done, total, _ in told)
    assert "µm" in told[0][2]
    # A callback may show something, which some tools allow in one thread only.
    assert threads == {threading.get_ident()}


def test_an_exception_of_the_callback_ends_the_job(model: precomp.Model) -> None:
    def progress(done: int, total: int, what: str) -> None:
        if done == 2:
            raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        model.compensate(PROGRAM, progress=progress)
    assert threading.active_count() == before


def test_an_interrupt_ends_training(logs: list[Path], tmp_path: Path) -> None:
    script = f"""
import precomp, sys
print("begins", flush=True)
try:
    precomp.train({[str(path) for path in logs]!r}, predictor="staged").save({str(tmp_path / "never.model")!r})
except KeyboardInterrupt:
    print("interrupted")
    sys.exit(7)
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begins\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert (process.returncode, out) == (7, "interrupted\n")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_ends_the_command(logs: list[Path], tmp_path: Path) -> None:
    line = [sys.executable, "-m", "precomp", "train", *map(str, logs), "-o", str(tmp_path / "never.model")]
    process = subprocess.Popen(line, stdout=subprocess.DEVNULL)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=10) == -signal.SIGINT
    assert list(tmp_path.iterdir()) == []


def test_other_threads_run_on(model: precomp.Model) -> None:
    ticks = 0
    ended = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not ended.wait(0.001):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.perf_counter()
    model.compensate(PROGRAM)
    seconds = time.perf_counter() - began
    ended.set()
    thread.join()
    assert ticks > 50 * seconds


def test_errors_are_those_of_the_command(model: precomp.Model, folder: Path) -> None:
    def of_command(*arguments: str) -> tuple[int, str]:
        done = subprocess.run([sys.executable, "-m", "precomp", *arguments], capture_output=True, text=True, check=False)
        return done.returncode, done.stderr.removeprefix("error: ").rstrip("\n")

    bad = folder / "bad.nc"
    bad.write_text("G21 G90\nG1 X10 F1000\nG1 X12 F0\n")
    saved = str(folder / "machine.model")
    with pytest.raises(precomp.Error) as refused:
        model.predict(bad)
    assert (1, str(refused.value)) == of_command("predict", str(bad), "-m", saved)
    with pytest.raises(precomp.UsageError) as misused:
        model.predict("missing.nc")
    assert (2, str(misused.value)) == of_command("predict", "missing.nc", "-m", saved)
    with pytest.raises(precomp.UsageError) as misused:
        precomp.MachineSpec("nowhere")
    assert (2, str(misused.value)) == of_command("excite", "--machine", "nowhere", "-o", str(folder / "never"))
    with pytest.raises(precomp.Error, match="damaged|archive|model"):
        precomp.Model.from_bytes(b"PK\x03\x04 no model")


def test_options_are_checked_as_on_the_command_line(model: precomp.Model) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument `max_shfit`"):
        model.compensate(PROGRAM, max_shfit=0.1)  # type: ignore[call-arg]
    with pytest.raises(precomp.UsageError, match=r"not a number from 0 to 1000000"):
        model.compensate(PROGRAM, max_shift=-1.0)
    with pytest.raises(precomp.UsageError, match="possible values: fast, normal, best"):
        model.compensate(PROGRAM, effort="slow")  # type: ignore[arg-type]
    with pytest.raises(precomp.UsageError, match="needs a unit"):
        model.compensate(PROGRAM, tolerance="2")
    with pytest.raises(precomp.UsageError, match="--tolerance"):
        model.compensate(PROGRAM, keep_time=True)


def test_results_hold_what_a_plot_needs(model: precomp.Model) -> None:
    result = model.compensate(PROGRAM)
    assert result.desired is not None and result.time_s is not None and result.axes == ["x", "y", "z"]
    assert result.desired.shape == (len(result.time_s), 3)
    for positions in (result.reference, result.forecast, result.uncompensated):
        assert positions is not None and positions.shape == result.desired.shape
    assert result.error_before_um is not None and result.error_after_um is not None
    assert np.sqrt(np.mean(result.error_after_um**2)) < 0.5 * np.sqrt(np.mean(result.error_before_um**2))
    assert "predicted contour error" in result.report
    bounded = model.compensate(PROGRAM, max_shift=0.001)
    assert any("cut off at its bound of 0.001 mm" in warning for warning in bounded.warnings)
    assert not any("cut off" in warning for warning in result.warnings)


def test_setpoints(model: precomp.Model) -> None:
    result = model.compensate(PROGRAM, format="pvt", spacing=5)
    assert result.text is not None and "\nt_s,x_mm" in result.text
    assert result.figures["setpoints"]["interval_ms"] == 5


def test_a_model_survives_its_file(model: precomp.Model, folder: Path) -> None:
    loaded = precomp.Model.load(folder / "machine.model")
    assert loaded.to_bytes() == model.to_bytes() == precomp.Model.from_bytes(model.to_bytes()).to_bytes()
    assert copy.deepcopy(model).to_bytes() == pickle.loads(pickle.dumps(model)).to_bytes() == model.to_bytes()
    assert loaded.figures is None and loaded.axes == ["x", "y", "z"]
    assert loaded.held_out["x"]["rms"] < loaded.held_out["x"]["raw_rms"]


def test_adaptation(model: precomp.Model, logs: list[Path]) -> None:
    worn = precomp.record("worn", seconds=10.0)
    adapted = model.adapt(worn)
    assert adapted.figures is not None and adapted.figures["axes"]["x"]["adapted"]
    assert adapted.to_bytes() != model.to_bytes()


def test_a_control_is_learned_from_programs(logs: list[Path]) -> None:
    run = precomp.simulate(PROGRAM, "ballscrew")
    log = precomp.Log(run.reference, run.actual, period_s=run.period_s, axes=run.axes, name="part")
    model = precomp.train([*logs, log], programs={"part": PROGRAM}, predictor="linear")
    assert model.figures is not None and model.figures["control"] is not None
    with pytest.raises(precomp.UsageError, match="no log is called other"):
        precomp.train(logs, programs={"other": "G1 X1\nM2\n"})
