"""Logs from arrays and data frames are those of files."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import precomp
from conftest import SEED


def read(log: precomp.Log) -> Any:
    return log.axes, log.period_s, log.reference.tolist(), log.actual.tolist()


def test_every_kind_of_frame_is_the_same_log(logs: list[Path]) -> None:
    wanted = read(precomp.Log.read(logs[0]))
    frame = pl.read_parquet(logs[0])
    columns = {name: frame[name].to_numpy() for name in frame.columns}
    chunked = pl.concat([frame[:100], frame[100:]], rechunk=False)
    for given in (frame, chunked, columns, pd.DataFrame(columns), pa.table(columns), precomp.Log.read(logs[0])):
        assert read(precomp.Log.read(given)) == wanted, type(given)


def test_a_model_from_frames_is_that_of_the_files(logs: list[Path], model: precomp.Model) -> None:
    frames = [pl.read_parquet(path) for path in logs]
    assert precomp.train(frames, machine="ballscrew", predictor="linear", seed=SEED).to_bytes() == model.to_bytes()


def test_columns_are_named_and_scaled(logs: list[Path]) -> None:
    log = precomp.Log.read(logs[0])
    time = (log.time_s * 1e9).round().astype("datetime64[ns]") + np.timedelta64(1_790_000_000, "s")
    given = pd.DataFrame({"time": time, "soll": log.reference[:, 0] * 1e3, "ist": log.actual[:, 0] * 1e3, "name": "x"})
    for columns in ("t=time,x_ref=soll:um,x_act=ist:um", {"t": "time", "x_ref": "soll:um", "x_act": "ist:um"}):
        found = precomp.Log.read(given, columns=columns)
        assert found.axes == ["x"]
        np.testing.assert_allclose(found.reference[:, 0], log.reference[:, 0], atol=1e-9)
        assert found.period_s == pytest.approx(log.period_s, rel=1e-6)
    as_array = {"time": time, "x_ref_um": log.reference[:, 0] * 1e3, "x_act_um": log.actual[:, 0] * 1e3}
    np.testing.assert_allclose(precomp.Log.read(as_array).actual[:, 0], log.actual[:, 0], atol=1e-9)


def test_missing_and_integer_values(logs: list[Path]) -> None:
    log = precomp.Log.read(logs[0])
    counts = pl.DataFrame({"t": log.time_s, "x_ref_nm": (log.reference[:, 0] * 1e6).round().astype(np.int64)})
    counts = counts.with_columns(x_act_nm=pl.Series((log.actual[:, 0] * 1e6).round().astype(np.int32)))
    np.testing.assert_allclose(precomp.Log.read(counts).reference[:, 0], log.reference[:, 0], atol=1e-6)
    # Few rows without a value are left out; where they are many, the axis is.
    short = counts.with_columns(pl.when(pl.col("t") > 0.1).then(pl.col("x_act_nm")))
    assert 0 < len(log.reference) - len(precomp.Log.read(short).reference) <= 60
    holed = counts.with_columns(pl.when(pl.col("t") > 0.5 * log.time_s[-1]).then(pl.col("x_act_nm")))
    with pytest.raises(precomp.Error, match="x_act_nm"):
        precomp.Log.read(holed)


def test_what_is_no_log_is_refused() -> None:
    with pytest.raises(precomp.UsageError, match="give a path"):
        precomp.Log.read(7)  # type: ignore[arg-type]
    with pytest.raises(precomp.UsageError, match="`b` has 1 values"):
        precomp.Log.read({"a": [1.0, 2.0], "b": [1.0]})
    with pytest.raises(precomp.Error, match="no axis has both"):
        precomp.Log.read({"t": [0.0, 1.0], "speed": [1.0, 2.0]})
    with pytest.raises(precomp.UsageError, match="there is no such file"):
        precomp.Log.read("missing.csv")


def test_a_log_of_arrays() -> None:
    reference = np.linspace(0.0, 1.0, 40).reshape(20, 2)
    log = precomp.Log(reference, reference - 0.001, period_s=0.002, axes=["x", "y"], name="mine")
    assert (log.name, len(log), log.axes) == ("mine", 20, ["x", "y"])
    np.testing.assert_array_equal(log.columns()["y_act"], reference[:, 1] - 0.001)
    with pytest.raises(precomp.UsageError, match="2 columns; the machine has 3 axes"):
        precomp.Log(reference, reference, period_s=0.002, axes=["x", "y", "z"])
    with pytest.raises(precomp.Error):
        precomp.Log(reference, reference * np.nan, period_s=0.002, axes=["x", "y"])
