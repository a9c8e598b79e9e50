//! What a robot must do, whatever its numbers.

mod caster;
mod encoder;
mod faults;
mod grip;
mod integration;
mod misread;
mod motor;
mod motor_defects;
mod parameters;
mod path;
mod rest;
mod rig;
mod uneven;
mod worn;
