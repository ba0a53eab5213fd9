//! The extension module `lissom._lissom`. The linker needs all crates complete, the compiler does not: here, `lissom-core` and
//! `lissom` are compiled side by side.

pub use lissom::python::_lissom;
