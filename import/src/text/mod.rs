//! Tables and trajectories in text: CSV with a header line, TUM (`t x y z qx qy qz qw`), EuRoC.
//!
//! | file | what it is |
//! | --- | --- |
//! | `quantity.rs` | [`Quantity`]: what a column can be; its unit |
//! | `mapping.rs` | [`Mapping`]: which column it is, as the user says; names that many loggers use |
//! | `read.rs` | [`read`]: a file as wheels and poses |

mod mapping;
mod quantity;
mod read;

pub use mapping::{Mapping, parse_mappings};
pub use quantity::Quantity;
pub use read::{TextLogs, parse, read};
