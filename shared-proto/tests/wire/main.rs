//! What crosses the wire, byte by byte.

mod bounds;
mod config;
mod damage;
mod decoder;
mod decoding;
mod drivers_page;
mod golden;
mod key;
mod page;
mod refusals;
mod round_trip;
mod samples;
mod schema;
mod strategy;
