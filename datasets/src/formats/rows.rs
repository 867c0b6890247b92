//! Rows of a log file, a batch at a time.

use crate::DatasetError;

/// The rows of a file in their order.
pub(crate) trait Rows: Send {
    /// Appends at most `most` rows to the columns, one for each that is wanted, and the lines of these rows to `lines`. Values that are no
    /// numbers become NaN. Returns the number of rows, 0 at the end of the file.
    ///
    /// # Errors
    /// When the file cannot be read or violates its format.
    fn read(&mut self, most: usize, columns: &mut [Vec<f64>], lines: &mut Vec<usize>) -> Result<usize, DatasetError>;

    /// Passes over `rows` rows.
    ///
    /// # Errors
    /// As [`Rows::read`].
    fn skip(&mut self, rows: usize) -> Result<(), DatasetError>;

    /// Message about a last row that is cut off and left out, once the end is reached.
    fn cut_off(&self) -> Option<&str>;
}
