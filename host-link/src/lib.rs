//! The link to a robot, for any program: opens it, talks to it, drives it.
//!
//! ```no_run
//! # fn main() -> host_link::Result<()> {
//! use host_link::motion::{Motion, RecordOptions, drive};
//!
//! let mut session = host_link::connect(&"tcp:127.0.0.1:7700".parse().expect("an address"))?;
//! let recording = host_link::block_on(async {
//!     session.open().await?;
//!     drive(&mut session, &Motion::PAPER, RecordOptions::default(), &mut |_| ()).await
//! })?;
//! println!("{} telemetry frames", recording.telemetry.len());
//! # Ok(())
//! # }
//! ```
//!
//! | module | what it is |
//! | --- | --- |
//! | [`session`] | handshake, requests with retries, telemetry, events |
//! | [`motion`] | drives a motion to its end, safely |
//! | [`limits`] | whether the robot would refuse a motion |
//! | [`address`] | serial ports and TCP addresses |
//! | [`listen`] | the other end, on TCP for several clients or on a pseudo-terminal |
//! | [`share`] | a serial port that several hosts use at once |
//! | [`wire`], [`clock`] | bytes and time of a session |
//! | [`cancel`] | a request to end a procedure in good order |
//! | [`lease`] | for how long a motion goes on by itself, and who keeps it alive |
//! | [`key_file`] | the file of a pre-shared key |
//! | [`stream`] | telemetry in order, without gaps |
//! | [`error`] | what can go wrong |
//!
//! The crate leaves to others: advice to a user (errors are enums with plain sentences, without
//! advice on any one program), what is computed from telemetry, and simulated robots, for which
//! [`Wire`] and [`clock::TimeSource`] are implemented elsewhere.

pub mod address;
mod announcement;
pub mod cancel;
pub mod clock;
pub mod error;
pub mod fault_in_words;
pub mod key_file;
mod key_file_problem;
pub mod lease;
pub mod limits;
pub mod listen;
pub mod motion;
mod robot_clock;
pub mod session;
pub mod share;
mod statistics;
pub mod stream;
mod validate;
pub mod wire;

pub use address::{Address, connect};
pub use async_io::block_on;
pub use cancel::Cancel;
pub use clock::Clock;
pub use error::{Error, Result};
pub use lease::Holder;
pub use motion::Motion;
pub use session::Session;
pub use wire::Wire;
