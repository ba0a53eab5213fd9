//! Simulations that the caller advances step by step: [`Run`].
//!
//! ```
//! use lissom::pendulum::SpringPendulum;
//! use lissom::newmark;
//! use lissom::stepping::{Method, Run};
//!
//! let pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let method = Method::Newmark(newmark::Options::new(1e-3));
//! let mut run = Run::new(pendulum, (0.0, 1e-3), &[-0.7, 0.5], &[0.0, 0.0], &method)?;
//! for _ in 0..1000 {
//!     let end = run.end_of(None)?;
//!     run.begin_interval(end);
//!     let status = run.finish(&mut |_| Ok(())).expect("nothing interrupts it");
//!     assert!(status.is_success(), "{}", run.explain(status));
//! }
//! assert_eq!(run.t(), 1.0);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod changes;
mod energy_watch;
mod following;
mod impact_resolver;
mod integrator;
mod method;
mod prescribed_watch;
mod rebounds;
mod resolved;
mod run;
mod start;
mod status;
mod unstable_vibrations;

pub use method::Method;
pub use run::Run;
pub use status::Status;

pub(crate) use method::{check_span, check_step};
pub(crate) use start::Start;
pub(crate) use status::Stop;
