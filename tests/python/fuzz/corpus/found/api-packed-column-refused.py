import lissom
from fuzz import values as v

layouts = True


def call(array=v.array):
    return lissom.Fluid(
        density=1000.0,
        drag_coefficients=array([1.0, 0.1], "packed"),
    )
