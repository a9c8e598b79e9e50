//! Whole campaigns, explained.

mod explanation;
mod held_out;
mod suggestions;
