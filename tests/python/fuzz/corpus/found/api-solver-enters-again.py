import lissom
from fuzz import values as v


def call():
    return lissom.RK45(
        fun=v.callback(lambda t, y: -y, "recurse", "", 0, lambda: call()),
        t0=0.0,
        y0=v.array([1.0, 2.0]),
        t_bound=1.0,
    )
