//! Compiled right-hand sides: C functions called by their address, without Python in between.
//!
//! The only unsafe code of the crate, for which there is no safe substitute: a Python callable costs some hundred
//! times more a call than the stepper itself.

#![allow(unsafe_code, reason = "a function that is known by its address can only be called in unsafe code")]

use std::ffi::CString;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods, PyInt, PyTuple};

/// `void f(double t, const double *y, double *out, const double *args)`.
type Signature = unsafe extern "C" fn(f64, *const f64, *mut f64, *const f64);

/// The signature for messages.
const SIGNATURE: &str = "void (double t, const double *y, double *out, const double *args)";

/// Linux (mmap_min_addr), macOS and Windows map nothing below: smaller integers, truth values among them, are no addresses.
const LOWEST_ADDRESS: usize = 1 << 16;

/// A C function with the signature of a right-hand side, and what it needs to be called.
#[derive(Debug)]
pub(super) struct CompiledFunction {
    function: Signature,
    inputs: usize,
    outputs: usize,
    parameters: Parameters,
    // Owns the machine code; never called itself.
    _owner: Py<PyAny>,
}

/// What the last argument points to.
#[derive(Debug)]
enum Parameters {
    /// Numbers of our own.
    Owned(Vec<f64>),
    /// The `user_data` of a `LowLevelCallable`, as an address.
    Foreign(usize),
}

impl CompiledFunction {
    /// The compiled function behind a Python object: one with an integer `address` (`numba.cfunc`), a
    /// `scipy.LowLevelCallable`, a function of ctypes or an address; `None` for other objects. It reads `inputs` states
    /// and writes `outputs` numbers.
    ///
    /// `args`, if any, are the numbers that its last argument points to.
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
        // types were compared as far as the object tells them (`check_types`).
        let function = unsafe { std::mem::transmute::<usize, Signature>(address) };
        Ok(Some(Self { function, inputs, outputs, parameters, _owner: value.clone().unbind() }))
    }

    /// `out <- f(t, y)`.
    ///
    /// # Panics
    /// When a slice has the wrong length.
    pub(super) fn call(&self, t: f64, y: &[f64], out: &mut [f64]) {
        assert_eq!((y.len(), out.len()), (self.inputs, self.outputs), "lengths of a compiled function");
        let parameters = match &self.parameters {
            Parameters::Owned(values) => values.as_ptr(),
            Parameters::Foreign(address) => *address as *const f64,
        };
        // SAFETY: `y` and `out` are valid for the lengths that were agreed on when the function was found, just
        // checked, and do not overlap; the parameters live as long as `self`, or as the LowLevelCallable does, which
        // `_owner` keeps alive together with the machine code. The function is trusted to keep to its signature, as
        // documented for every argument that takes one.
        unsafe { (self.function)(t, y.as_ptr(), out.as_mut_ptr(), parameters) }
    }
}

/// Address of a compiled function, and of its `user_data`.
fn address(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<(usize, Option<usize>)>> {
    if let Some(address) = value.getattr_opt("address")?
        && let Ok(address) = address.extract::<usize>()
    {
        if let Some(function) = value.getattr_opt("ctypes")? {
            check_types(&function, name)?;
        }
        return Ok(Some((address, None)));
    }
    if value.is_instance_of::<PyInt>()
        && let Ok(address) = value.extract::<usize>()
        && address >= LOWEST_ADDRESS
    {
        return Ok(Some((address, None)));
    }
    if let Some(address) = address_of_ctypes(value, name)? {
        return Ok(Some((address, None)));
    }
    let is_low_level = value.get_type().name().is_ok_and(|name| name == "LowLevelCallable");
    let Ok(tuple) = value.cast::<PyTuple>() else { return Ok(None) };
    if !is_low_level {
        return Ok(None);
    }
    let signature: String = value.getattr("signature")?.extract()?;
    let plain = signature.replace("const ", "").replace(' ', "");
    if plain.replace("void*", "double*") != "void(double,double*,double*,double*)" {
        return Err(PyTypeError::new_err(format!(
            "{name}: expected a compiled function of signature {SIGNATURE}, got {signature}"
        )));
    }
    // SciPy's __getitem__ refuses; the tuple itself does not.
    let item = tuple.get_item(0)?;
    let capsule = item.cast::<PyCapsule>()?;
    let capsule_name = CString::new(signature)?;
    let address = capsule.pointer_checked(Some(&capsule_name))?.as_ptr() as usize;
    let user_data = capsule.context()? as usize;
    Ok(Some((address, (user_data != 0).then_some(user_data))))
}

/// Address of a function of ctypes, such as `numba.cfunc.ctypes`.
fn address_of_ctypes(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<usize>> {
    // Spares other callables the import.
    if !value.hasattr("argtypes")? {
        return Ok(None);
    }
    let ctypes = value.py().import("ctypes")?;
    if !value.is_instance(&ctypes.getattr("_CFuncPtr")?)? {
        return Ok(None);
    }
    check_types(value, name)?;
    let pointer = ctypes.call_method1("cast", (value, ctypes.getattr("c_void_p")?))?;
    // The value of a null pointer is None.
    Ok(Some(pointer.getattr("value")?.extract::<Option<usize>>()?.unwrap_or(0)))
}

/// Compares the types of a function of ctypes with the signature.
fn check_types(ctypes: &Bound<'_, PyAny>, name: &str) -> PyResult<()> {
    // None where they were not declared.
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
