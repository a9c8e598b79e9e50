//! The whole stack in virtual time: the host's session, the protocol, the firmware's tasks, the plant.

mod calibration;
mod config;
mod dead_reckoning;
mod determinism;
mod fault_cases;
mod healthy;
mod hello;
mod key;
mod key_change;
mod key_noise;
mod key_stop;
mod latched;
mod lease;
mod long_counts;
mod motion;
mod nearly_at_rest;
mod request_order;
mod retry;
mod rolling;
mod safety;
mod stall;
mod stopped_task;
mod supply;
mod velocity;
mod voltage;
mod wiring;
