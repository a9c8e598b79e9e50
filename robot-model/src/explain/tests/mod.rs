//! Whole campaigns: effects found, runs suggested, runs held out.

mod averaged;
mod explanation;
mod held_out;
mod larger_than_usual;
mod suggestions;
mod used_to_predict;
mod without_noise;
