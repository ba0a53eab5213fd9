//! Plain data of rods, joints, bodies and motions, and the tables by which all parts of a model are read, checked and written.

pub mod body;
pub(crate) mod derivatives;
pub mod joint;
pub mod rod;
pub mod schema;
pub mod signal;
pub mod world;
