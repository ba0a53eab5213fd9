import lissom
from fuzz import values as v

watched = "fun"


def call():
    return lissom.jacobian(
        fun=v.callback(lambda x: x * x, "nonsense", "digits", 0),
        x=v.array([1.0, 2.0]),
    )
