"""CVODE without Python in the inner loop.

scikit-sundae accepts only Python functions. Here its SUNDIALS libraries are called through ctypes, with
right-hand sides and Jacobians compiled by numba.
"""

import ctypes
from ctypes import POINTER, byref, c_double, c_int, c_int64, c_long, c_void_p
from pathlib import Path

import numba
import numpy as np
from numba import types

ADAMS, BDF = 1, 2
NORMAL = 1
UNLIMITED_STEPS = -1


def _load():
    # Importing the package loads the libraries, so that they find each other.
    import sksundae
    import sksundae.cvode

    folder = Path(sksundae.__file__).parent.parent / "scikit_sundae.libs"

    def library(name):
        return ctypes.CDLL(str(next(folder.glob(f"libsundials_{name}-*"))))

    core, cvode, vector = library("core"), library("cvode"), library("nvecserial")
    matrix, solver = library("sunmatrixdense"), library("sunlinsoldense")
    prototypes = [
        (core, "SUNContext_Create", c_int, [c_int, POINTER(c_void_p)]),
        (core, "N_VGetArrayPointer", c_void_p, [c_void_p]),
        (vector, "N_VNew_Serial", c_void_p, [c_int64, c_void_p]),
        (matrix, "SUNDenseMatrix", c_void_p, [c_int64, c_int64, c_void_p]),
        (matrix, "SUNDenseMatrix_Data", c_void_p, [c_void_p]),
        (solver, "SUNLinSol_Dense", c_void_p, [c_void_p, c_void_p, c_void_p]),
        (cvode, "CVodeCreate", c_void_p, [c_int, c_void_p]),
        (cvode, "CVodeInit", c_int, [c_void_p, c_void_p, c_double, c_void_p]),
        (cvode, "CVodeReInit", c_int, [c_void_p, c_double, c_void_p]),
        (cvode, "CVodeSStolerances", c_int, [c_void_p, c_double, c_double]),
        (cvode, "CVodeSetMaxNumSteps", c_int, [c_void_p, c_long]),
        (cvode, "CVodeSetStopTime", c_int, [c_void_p, c_double]),
        (cvode, "CVodeSetLinearSolver", c_int, [c_void_p, c_void_p, c_void_p]),
        (cvode, "CVodeSetJacFn", c_int, [c_void_p, c_void_p]),
        (cvode, "CVode", c_int, [c_void_p, c_double, c_void_p, POINTER(c_double), c_int]),
        (cvode, "CVodeGetNumSteps", c_int, [c_void_p, POINTER(c_long)]),
        (cvode, "CVodeGetNumRhsEvals", c_int, [c_void_p, POINTER(c_long)]),
    ]
    functions = {}
    for lib, name, result, arguments in prototypes:
        function = getattr(lib, name)
        function.restype, function.argtypes = result, arguments
        functions[name] = function
    return functions


def _returning_doubles(function):
    """The function with a result type that numba accepts as an array."""
    address = ctypes.cast(function, c_void_p).value
    return ctypes.CFUNCTYPE(POINTER(c_double), c_void_p)(address)


class CompiledCvode:
    """A problem solved by CVODE; construction and compilation are not part of a run."""

    def __init__(self, problem, method):
        self.problem = problem
        self.sundials = s = _load()
        n = problem.y0.size
        self.context = c_void_p()
        self._check(s["SUNContext_Create"](0, byref(self.context)), "SUNContext_Create")
        self.y = s["N_VNew_Serial"](n, self.context)
        self.data = np.ctypeslib.as_array((c_double * n).from_address(s["N_VGetArrayPointer"](self.y)))
        self.data[:] = problem.y0
        self.memory = s["CVodeCreate"](method, self.context)
        array_pointer = _returning_doubles(s["N_VGetArrayPointer"])
        matrix_data = _returning_doubles(s["SUNDenseMatrix_Data"])
        write = numba.njit(problem.write)

        @numba.cfunc(types.int32(types.double, types.voidptr, types.voidptr, types.voidptr))
        def rhs(t, y, dydt, user_data):
            write(
                t,
                numba.carray(array_pointer(y), (n,), np.float64),
                numba.carray(array_pointer(dydt), (n,), np.float64),
                None,
            )
            return 0

        self.rhs = rhs
        self._check(s["CVodeInit"](self.memory, rhs.address, problem.t_span[0], self.y), "CVodeInit")
        self._check(s["CVodeSetMaxNumSteps"](self.memory, UNLIMITED_STEPS), "CVodeSetMaxNumSteps")
        matrix = s["SUNDenseMatrix"](n, n, self.context)
        solver = s["SUNLinSol_Dense"](self.y, matrix, self.context)
        self._check(s["CVodeSetLinearSolver"](self.memory, solver, matrix), "CVodeSetLinearSolver")
        if problem.write_jacobian is not None:
            write_jacobian = numba.njit(problem.write_jacobian)

            @numba.cfunc(types.int32(types.double, *[types.voidptr] * 7))
            def jacobian(t, y, f, matrix, user_data, scratch_1, scratch_2, scratch_3):
                rows = np.empty(n * n)
                write_jacobian(t, numba.carray(array_pointer(y), (n,), np.float64), rows, None)
                columns = numba.carray(matrix_data(matrix), (n * n,), np.float64)
                for i in range(n):
                    for j in range(n):
                        columns[j * n + i] = rows[i * n + j]
                return 0

            self.jacobian = jacobian
            self._check(s["CVodeSetJacFn"](self.memory, jacobian.address), "CVodeSetJacFn")

    @staticmethod
    def _check(flag, name):
        if flag < 0:
            raise RuntimeError(f"{name} failed with flag {flag}")

    def run(self, rtol, atol):
        """Final state, evaluations, steps."""
        s, (t0, t_end) = self.sundials, self.problem.t_span
        self.data[:] = self.problem.y0
        self._check(s["CVodeReInit"](self.memory, t0, self.y), "CVodeReInit")
        self._check(s["CVodeSStolerances"](self.memory, rtol, atol), "CVodeSStolerances")
        self._check(s["CVodeSetStopTime"](self.memory, t_end), "CVodeSetStopTime")
        t, steps, evaluations = c_double(), c_long(), c_long()
        self._check(s["CVode"](self.memory, t_end, self.y, byref(t), NORMAL), "CVode")
        s["CVodeGetNumSteps"](self.memory, byref(steps))
        s["CVodeGetNumRhsEvals"](self.memory, byref(evaluations))
        return self.data.copy(), evaluations.value, steps.value
