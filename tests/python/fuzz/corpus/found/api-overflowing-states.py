import lissom
from fuzz import values as v


def call():
    return lissom.solve_ivp(
        fun=v.callback(lambda t, y: -y, "number", "huge", 2),
        t_span=(0.0, 1.0),
        y0=v.array([1.0, 2.0]),
        t_eval=v.array([0.0, 0.5, 1.0]),
    )
