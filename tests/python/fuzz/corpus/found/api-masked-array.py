import numpy as np

import lissom

forbidden = "x0: np.ma.masked_array([0.1, 0.2], [False, True])"


def call():
    return lissom.root(
        fun=lambda x: x * x - 2.0,
        x0=np.ma.masked_array([0.1, 0.2], [False, True]),
    )
