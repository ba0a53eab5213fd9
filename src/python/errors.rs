//! Exceptions of the package. Bad input raises `ValueError` or `TypeError`; these are for what no check can foresee.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning};

create_exception!(
    lissom,
    LissomError,
    PyException,
    "Base class of the numerical failures that lissom raises."
);

create_exception!(
    lissom,
    ConvergenceError,
    LissomError,
    "A search that did not converge, raised on request; its result is the attribute `result`."
);

create_exception!(
    lissom,
    AccuracyWarning,
    PyUserWarning,
    "A run reached its end, but its result may be far from the right one."
);
