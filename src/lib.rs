//! lissom makes soft rods move.

pub mod accuracy;
pub mod balance;
pub mod body;
mod derivatives;
pub mod error;
mod hermite;
pub mod lie;
pub mod linalg;
pub mod load;
mod memory;
pub mod model;
pub mod modes;
mod natural;
pub mod newmark;
pub mod ode;
pub mod pendulum;
#[cfg(feature = "python")]
mod python;
pub mod radau;
pub mod robot;
pub mod rod;
pub mod roots;
#[cfg(feature = "scene")]
pub mod scene;
pub mod second_order;
pub mod signal;
pub mod simulate;
mod small_motions;
mod spectrum;
pub mod springs;
pub mod stability;
pub mod statics;
pub mod support;
mod unseen;
pub mod world;
