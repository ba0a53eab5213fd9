import numpy as np

import lissom
from fuzz import values as v

forbidden = "q: np.array([0.1, 0.2j])"


def call():
    return lissom.linearise(
        model=v.planar(),
        q=np.array([0.1, 0.2j]),
    )
