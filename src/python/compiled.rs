//! Compiled right-hand sides: C functions called through their pointers, without Python.
//!
//! The only unsafe code of the crate. There is no safe substitute: a call of a Python function costs about a
//! hundred times more than the stepper itself.

#![allow(unsafe_code, reason = "a function that is known by its address can only be called in unsafe code")]

use std::ffi::CString;

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods, PyDict, PyTuple};

/// `void f(double t, const double *y, double *out, const double *args)`.
type Signature = unsafe extern "C" fn(f64, *const f64, *mut f64, *const f64);

/// The signature for messages.
const SIGNATURE: &str = "void (double t, const double *y, double *out, const double *args)";

/// A C function with the signature of a right-hand side, and the data for its calls.
#[derive(Debug)]
pub(super) struct CompiledFunction {
    function: Signature,
    inputs: usize,
    outputs: usize,
    parameters: Parameters,
    // Keeps the machine code alive; never called itself.
    owner: Py<PyAny>,
}

/// Memory to which the last argument points.
#[derive(Debug)]
enum Parameters {
    /// Numbers owned by this struct.
    Owned(Vec<f64>),
    /// The `user_data` of a `LowLevelCallable`, as an address.
    Foreign(usize),
}

impl CompiledFunction {
    /// The compiled function of a Python object (a function of ctypes, a `numba.cfunc` or a
    /// `scipy.LowLevelCallable`); `None` for objects of other types, whatever their attributes. It reads
    /// `inputs` states and writes `outputs` numbers.
    ///
    /// `args` are the numbers to which its last argument points.
    pub(super) fn find(
        value: &Bound<'_, PyAny>,
        (inputs, outputs): (usize, usize),
        args: Option<&[f64]>,
        name: &str,
    ) -> PyResult<Option<Self>> {
        let Some((address, user_data)) = address(value, name)? else { return Ok(None) };
        if address == 0 {
            return Err(PyValueError::new_err(format!("{name}: the address of the compiled function is 0")));
        }
        let parameters = match (args, user_data) {
            (Some(_), Some(_)) => {
                return Err(PyValueError::new_err(format!(
                    "args: {name} is a LowLevelCallable with user_data, which takes their place; give one of the two"
                )));
            }
            (None, Some(user_data)) => Parameters::Foreign(user_data),
            (args, None) => Parameters::Owned(args.unwrap_or_default().to_vec()),
        };
        // SAFETY: an address is not 0, hence a valid value of a function pointer type, which has the size of usize on
        // all platforms that NumPy supports. That a function of this signature is there is the caller's promise; the
        // types were compared as far as the object declares them (`check_types`).
        let function = unsafe { std::mem::transmute::<usize, Signature>(address) };
        Ok(Some(Self { function, inputs, outputs, parameters, owner: value.clone().unbind() }))
    }

    /// `out <- f(t, y)`.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub(super) fn call(&self, t: f64, y: &[f64], out: &mut [f64]) {
        assert_eq!((y.len(), out.len()), (self.inputs, self.outputs), "lengths of a compiled function");
        let parameters = match &self.parameters {
            Parameters::Owned(values) => values.as_ptr(),
            Parameters::Foreign(address) => *address as *const f64,
        };
        // SAFETY: `y` and `out` are valid for the lengths that were agreed on when the function was found, just
        // checked, and do not overlap; the parameters live as long as `self`, or as the LowLevelCallable does, which
        // `owner` keeps alive together with the machine code. The function is trusted to keep to its signature, as
        // documented for every argument that takes one.
        unsafe { (self.function)(t, y.as_ptr(), out.as_mut_ptr(), parameters) }
    }

    pub(super) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.owner)
    }
}

/// Address of a compiled function, and of its `user_data`.
fn address(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<(usize, Option<usize>)>> {
    if is_instance(value, "ctypes", "_CFuncPtr")? {
        return Ok(Some((address_of_ctypes(value, name)?, None)));
    }
    if is_instance(value, "numba.core.ccallback", "CFunc")? {
        let function = value.getattr("ctypes")?;
        if !is_instance(&function, "ctypes", "_CFuncPtr")? {
            return Err(PyTypeError::new_err(format!(
                "{name}: expected a numba.cfunc with a function of ctypes"
            )));
        }
        return Ok(Some((address_of_ctypes(&function, name)?, None)));
    }
    if !is_instance(value, "scipy._lib._ccallback", "LowLevelCallable")? {
        return Ok(None);
    }
    let tuple = value.cast::<PyTuple>()?;
    let signature: String = value.getattr("signature")?.extract()?;
    let plain = signature.replace("const ", "").replace(' ', "");
    if plain.replace("void*", "double*") != "void(double,double*,double*,double*)" {
        return Err(PyTypeError::new_err(format!(
            "{name}: expected a compiled function of signature {SIGNATURE}, got {signature}"
        )));
    }
    // The `__getitem__` of SciPy's class raises, that of tuple does not.
    let item = tuple.get_item(0)?;
    let capsule = item.cast::<PyCapsule>()?;
    let capsule_name = CString::new(signature)?;
    let address = capsule.pointer_checked(Some(&capsule_name))?.as_ptr() as usize;
    let user_data = capsule.context()? as usize;
    Ok(Some((address, (user_data != 0).then_some(user_data))))
}

/// Whether a value has a type of a module; false if the module has not been imported.
fn is_instance(value: &Bound<'_, PyAny>, module: &str, class: &str) -> PyResult<bool> {
    let modules = value.py().import("sys")?.getattr("modules")?.cast_into::<PyDict>()?;
    match modules.get_item(module)? {
        Some(module) => value.is_instance(&module.getattr(class)?),
        None => Ok(false),
    }
}

/// Address of a ctypes function.
fn address_of_ctypes(function: &Bound<'_, PyAny>, name: &str) -> PyResult<usize> {
    check_types(function, name)?;
    let ctypes = function.py().import("ctypes")?;
    let pointer = ctypes.call_method1("cast", (function, ctypes.getattr("c_void_p")?))?;
    // The value of a null pointer is None.
    Ok(pointer.getattr("value")?.extract::<Option<usize>>()?.unwrap_or(0))
}

/// Compares the declared types of a ctypes function with the signature.
fn check_types(ctypes: &Bound<'_, PyAny>, name: &str) -> PyResult<()> {
    // None if types were not declared.
    let types: Option<Vec<Bound<'_, PyAny>>> = ctypes.getattr("argtypes")?.extract()?;
    let types = types.unwrap_or_default();
    let names = types
        .iter()
        .map(|argument| argument.getattr("__name__")?.extract::<String>())
        .collect::<PyResult<Vec<_>>>()?;
    let is_pointer = |name: &String| name.starts_with("LP_c_double") || name == "c_void_p";
    let right = names.len() == 4
        && names[0] == "c_double"
        && names[1..].iter().all(is_pointer)
        && ctypes.getattr("restype")?.is_none();
    if right {
        return Ok(());
    }
    Err(PyTypeError::new_err(format!(
        "{name}: expected a compiled function of signature {SIGNATURE}, got arguments ({})",
        names.join(", ")
    )))
}
