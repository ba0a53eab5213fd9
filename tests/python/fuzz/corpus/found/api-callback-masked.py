import lissom
from fuzz import values as v

watched = "fun"


def call():
    return lissom.root(
        fun=v.callback(lambda x: x * x - 2.0, "nonsense", "masked", 0),
        x0=v.array([1.0, 2.0]),
    )
