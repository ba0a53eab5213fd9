//! lissom makes soft rods move.

pub mod accuracy;
pub mod balance;
mod derivatives;
pub mod error;
mod hermite;
pub mod lie;
pub mod linalg;
mod memory;
pub mod model;
pub mod modes;
pub mod newmark;
pub mod ode;
pub mod pendulum;
#[cfg(feature = "python")]
mod python;
pub mod radau;
pub mod rod;
pub mod roots;
#[cfg(feature = "scene")]
pub mod scene;
pub mod signal;
pub mod simulate;
mod spectrum;
pub mod springs;
pub mod stability;
pub mod statics;
mod unseen;
