//! Runs of models: to an end or step by step, to a requested accuracy, many at once, with derivatives.

pub mod accuracy;
pub mod balance;
pub mod ensemble;
pub mod methods;
pub mod sensitivity;
pub mod simulate;
pub mod stepping;
pub mod time_limit;
