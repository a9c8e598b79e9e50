//! Tables and trajectories in text: CSV with a header line, TUM (`t x y z qx qy qz qw`), EuRoC.
//!
//! | file | what it is |
//! | --- | --- |
//! | `quantity.rs` | [`Quantity`]: what a column can be; its unit |
//! | `mapping.rs` | [`Mapping`]: which column it is, as the user says; names that many loggers use |
//! | `columns.rs` | columns that are numbers already |
//! | `cell.rs`, `scale.rs`, `heading.rs` | a cell as a number; units that nobody gave |
//! | `held_poses.rs` | poses that stand in a row until the next is measured |
//! | `run_column.rs`, `restarts.rs` | which run a row is of; time that begins again in each run of a table |
//! | `read.rs` | [`read`]: a file as wheels and poses |

mod cell;
mod columns;
mod heading;
mod held_poses;
mod mapping;
mod quantity;
mod read;
mod restarts;
mod run_column;
mod scale;

pub(crate) use columns::of_columns;
pub(crate) use mapping::by_name;
pub use mapping::{Mapping, parse_mappings};
pub use quantity::Quantity;
pub use read::{TextLogs, parse, read};
