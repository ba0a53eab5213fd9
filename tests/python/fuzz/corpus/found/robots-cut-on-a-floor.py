robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "rod": {
                "segment": [
                    {
                        "length": 0.3,
                        "radius": 0.01,
                        "young_modulus": 1000000.0,
                        "shear_modulus": 400000.0,
                        "density": 1000.0,
                        "modes": {"bend_y": 2},
                    }
                ]
            },
            "q0": [0.0, 0.0],
            "v0": [0.0, 0.0],
        },
    ],
    "contact": [
        {
            "name": "floor",
            "a": "a",
            "b": {"kind": "half_space", "point": [0.0, 0.0, -0.009]},
            "stiffness": 100000.0,
        },
    ],
}
question = {"ask": "cut", "of": "floors", "seed": 0}
