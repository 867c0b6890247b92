//! Statistics of contour errors: over samples and length, on circles, at corners, of the tool
//! orientation, by estimator.

mod circular;
mod corners;
mod orientation;
mod summary;
mod table;

pub use circular::{CirclePlane, CircularTest, DirectionFigures, NominalCircle, circular_test};
pub use corners::{PAPER_B_RATIO, PAPER_B_SUPPORT, SupportRegion, corner_flags, corner_ratios, stretches};
pub use orientation::{OrientationError, orientation_errors};
pub use summary::{ContourSummary, summary, summary_by_length, summary_of};
pub use table::{TableRow, sample_estimators, table_row};
