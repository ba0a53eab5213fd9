import numpy as np

import lissom

forbidden = "y0: np.array(['0.1', '0.2'])"


def call():
    return lissom.solve_ivp(
        fun=lambda t, y: -y,
        t_span=(0.0, 1.0),
        y0=np.array(["0.1", "0.2"]),
    )
