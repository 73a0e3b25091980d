//! Tests of commands about a model: check, list, new, import, modes, tune, equiv, accuracy, fit.

mod accuracy;
mod against;
mod border;
mod commands;
mod equiv;
mod fit;
mod numbers;
mod pitch;
mod ports;
mod watch;
