//! The report: one self-contained page with what a command found.
//!
//! A [`Page`] is made of groups of sections of a few kinds ([`section::Content`]). [`sections`] shows the runs of a path; the other files
//! make sections of what a command knows beside. [`render()`] writes the page; its scripts are in `page/`.

mod circle;
mod column;
mod comparison;
mod diagnosis;
mod figures;
mod learning;
mod model;
mod path;
mod polar;
mod render;
mod run;
mod section;
mod thin;
mod track;
mod worst;

pub use comparison::comparison;
pub use diagnosis::{diagnosis, nothing, suggestion};
pub use figures::sections;
pub use learning::{Forecasts, learning_curve, over_runs};
pub use model::{adaptation, asked, held_out, known, model_fit, trained_range};
pub use render::render;
pub use run::Run;
pub use section::{Group, Page};
pub use track::Track;
