//! Tests of commands about a model: check, list, new, import, modes, tune, equiv, accuracy, fit.

mod accuracy;
mod border;
mod check_device;
mod commands;
mod equiv;
mod export;
mod fit;
mod number_format;
mod pitch;
mod ports;
mod watch;
