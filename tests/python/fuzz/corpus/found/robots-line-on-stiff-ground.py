robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "revolute", "axis": [0.0, 1.0, 0.0]},
            "rod": {
                "segment": [
                    {
                        "length": 20.0,
                        "radius": 0.05,
                        "young_modulus": 20371832715.7626,
                        "poisson_ratio": 0.5,
                        "density": 12978.996378543961,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 20.0,
                        "radius": 0.05,
                        "young_modulus": 20371832715.7626,
                        "poisson_ratio": 0.5,
                        "density": 12978.996378543961,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 20.0,
                        "radius": 0.05,
                        "young_modulus": 20371832715.7626,
                        "poisson_ratio": 0.5,
                        "density": 12978.996378543961,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 20.0,
                        "radius": 0.05,
                        "young_modulus": 20371832715.7626,
                        "poisson_ratio": 0.5,
                        "density": 12978.996378543961,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 20.0,
                        "radius": 0.05,
                        "young_modulus": 20371832715.7626,
                        "poisson_ratio": 0.5,
                        "density": 12978.996378543961,
                        "modes": {"bend_y": 4},
                    },
                ]
            },
        },
    ],
    "contact": [
        {
            "name": "ground",
            "a": "a",
            "b": {"kind": "half_space", "point": [0.0, 0.0, -0.049999]},
            "stiffness": 1000000000.0,
        },
    ],
}
question = {"ask": "verdict", "of": "ground"}
