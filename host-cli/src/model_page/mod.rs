//! The page on which a campaign's model is tried out: each effect is a switch, and the error falls, or does not.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `workbench.rs` | [`Workbench`]: a campaign, and what the page may ask of it |
//! | `request.rs` | what it asks: effects, each fitted or at values set by hand |
//! | `answer.rs` | what it is answered, as JSON |
//! | `look_ahead.rs` | the models that may be asked for next, fitted while nobody waits |
//! | `server.rs` | its questions over HTTP |
//! | `offline.rs` | the page as one file, with its answers in it |
//! | `assets/` | the page itself |
//!
//! The figures are those of `beeline model add`, `compare`, `explain` and `report`: the same functions compute them.

mod answer;
mod look_ahead;
mod offline;
mod request;
mod server;
mod workbench;

pub use offline::offline_page;
pub use request::ModelRequest;
pub use server::serve;
pub use workbench::Workbench;
