import numpy as np

problem = {
    "kind": "ivp",
    "fun": lambda t, y: (
        1 / ((t - 0.9826) ** 2 + 1e-4) * np.ones(1)
        + -0.726 * np.sin(31.76 * t) * np.ones(1)
        + 1e308 * np.ones(1)
    ),
    "t_span": (0.0, 1.0),
    "y0": [-0.640235],
    "method": "rk45",
    "rtol": 0.01,
    "atol": 0.01,
    "options": {"dense_output": True},
}
