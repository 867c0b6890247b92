//! Results of a watch as a table: Parquet, and means over a week.

use polars::prelude::{
    Column, DataFrame, IntoLazy, NamedFrom, ParquetCompression, ParquetWriter, PolarsResult, RollingOptionsFixedWindow, Series,
    col,
};

use crate::error::{FleetError, Result};
use crate::estimate::Quantity;
use crate::watch::AxisDay;

/// Days of the rolling means.
const WEEK: usize = 7;

/// The rows as a Parquet file, with the means over the last seven days of an axis.
///
/// # Errors
/// When they cannot be written.
pub fn content(rows: &[AxisDay]) -> Result<Vec<u8>> {
    let failed = |error| FleetError::Results(Box::new(error));
    let mut frame = table(rows).and_then(rolling).map_err(failed)?;
    let mut bytes = Vec::new();
    let writer = ParquetWriter::new(&mut bytes).with_compression(ParquetCompression::Snappy).set_parallel(false);
    writer.finish(&mut frame).map_err(failed)?;
    Ok(bytes)
}

/// The frame with rolling means of a week by machine and axis.
///
/// # Errors
/// When columns are missing.
pub fn rolling(frame: DataFrame) -> PolarsResult<DataFrame> {
    let week = RollingOptionsFixedWindow { window_size: WEEK, min_periods: 1, ..RollingOptionsFixedWindow::default() };
    let mean = |name: &str| -> PolarsResult<_> {
        let mean = col(name).rolling_mean(week.clone()).over([col("machine"), col("axis")])?;
        Ok(mean.alias(format!("{name}_week")))
    };
    let means = ["model_rms_um", "friction_um", "backlash_um", "lag_ms"].map(mean);
    frame.lazy().with_columns(means.into_iter().collect::<PolarsResult<Vec<_>>>()?).collect()
}

fn table(rows: &[AxisDay]) -> PolarsResult<DataFrame> {
    let text = |name: &str, of: &dyn Fn(&AxisDay) -> String| -> Column {
        Series::new(name.into(), rows.iter().map(of).collect::<Vec<_>>()).into()
    };
    let count = |name: &str, of: &dyn Fn(&AxisDay) -> usize| -> Column {
        Series::new(name.into(), rows.iter().map(|row| of(row) as u64).collect::<Vec<_>>()).into()
    };
    let number = |name: &str, of: &dyn Fn(&AxisDay) -> Option<f64>| -> Column {
        Series::new(name.into(), rows.iter().map(|row| of(row).filter(|value| value.is_finite())).collect::<Vec<_>>()).into()
    };
    let mut columns = vec![
        text("machine", &|row| row.machine.clone()),
        text("date", &|row| row.date.clone()),
        text("axis", &|row| row.quality.axis.clone()),
        text("phase", &|row| row.phase.name().to_owned()),
        count("rows", &|row| row.quality.rows),
        number("seconds", &|row| Some(row.quality.seconds)),
        count("gaps", &|row| row.quality.gaps),
        count("missing", &|row| row.quality.missing),
        number("tracking_rms_um", &|row| Some(row.quality.tracking_rms_um)),
        number("tracking_worst_rms_um", &|row| Some(row.quality.tracking_worst_rms_um)),
        number("model_rms_um", &|row| row.estimate.as_ref().map(|estimate| estimate.model_rms_um)),
        number("held_out_rms_um", &|row| row.estimate.as_ref().map(|estimate| estimate.held_out_rms_um)),
        number("in_band", &|row| row.estimate.as_ref().map(|estimate| estimate.in_band)),
    ];
    for quantity in Quantity::ALL {
        let name = quantity.name();
        if let Some(unit) = quantity.unit() {
            columns.push(number(&format!("{name}_{unit}"), &|row| row.levels.get(&quantity).copied()));
        }
        let change = |row: &AxisDay| row.changes.get(&quantity).copied();
        columns.push(number(&format!("{name}_{}", quantity.change_name()), &|row| Some(change(row)?.change)));
        columns.push(number(&format!("{name}_limit"), &|row| Some(change(row)?.limit)));
    }
    columns.push(text("alarms", &|row| row.alarms().map(Quantity::name).collect::<Vec<_>>().join(" ")));
    DataFrame::new(rows.len(), columns)
}
