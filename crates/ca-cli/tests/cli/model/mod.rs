//! What is asked of a model before it plays: findings, numbers, pitch, accuracy, its scale in the hand, a fit.

mod accuracy;
mod against;
mod border;
mod equiv;
mod fit;
mod numbers;
mod pages;
mod pitch;
mod ports;
mod watch;
