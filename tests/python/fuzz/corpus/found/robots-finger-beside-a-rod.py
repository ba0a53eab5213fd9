robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "rod": {
                "segment": [
                    {
                        "length": 0.1,
                        "radius": 0.005,
                        "young_modulus": 1000000.0,
                        "shear_modulus": 400000.0,
                        "density": 1000.0,
                        "modes": {"bend_y": 4},
                    }
                ]
            },
        },
        {
            "name": "other",
            "position": [0.0, 1.0, 0.0],
            "rod": {
                "segment": [
                    {
                        "length": 10.0,
                        "radius": 0.05,
                        "young_modulus": 1000000.0,
                        "shear_modulus": 400000.0,
                        "density": 1e-09,
                        "modes": {"bend_y": 2},
                    }
                ]
            },
        },
    ],
    "loop": [
        {
            "name": "pin",
            "kind": {"type": "spherical"},
            "a": {"link": "a"},
            "b": {"position": [0.05, 0.0, 0.06]},
        },
    ],
}
question = {"ask": "reached", "of": "loops"}
