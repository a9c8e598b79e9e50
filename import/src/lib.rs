//! Logs of other programs become campaign folders.
pub mod alignment;
pub mod bag;
pub mod cdr;
pub mod cut;
pub mod export;
pub mod log;
pub mod mcap;
pub mod mend;
pub mod message;
pub mod plane;
pub mod source;
pub mod text;
pub mod turns;
pub mod understand;
pub mod write;
