robot = {
    "scene": {"gravity": [0.0, 0.0, 0.0]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "revolute", "axis": [0.0, 1.0, 0.0]},
            "rod": {
                "segment": [
                    {
                        "length": 0.2,
                        "radius": 0.01,
                        "young_modulus": 127323954.47351627,
                        "shear_modulus": 50929581.789406516,
                        "density": 3183.098861837907,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 0.2,
                        "radius": 0.01,
                        "young_modulus": 127323954.47351627,
                        "shear_modulus": 50929581.789406516,
                        "density": 3183.098861837907,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 0.2,
                        "radius": 0.01,
                        "young_modulus": 127323954.47351627,
                        "shear_modulus": 50929581.789406516,
                        "density": 3183.098861837907,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 0.2,
                        "radius": 0.01,
                        "young_modulus": 127323954.47351627,
                        "shear_modulus": 50929581.789406516,
                        "density": 3183.098861837907,
                        "modes": {"bend_y": 4},
                    },
                    {
                        "length": 0.2,
                        "radius": 0.01,
                        "young_modulus": 127323954.47351627,
                        "shear_modulus": 50929581.789406516,
                        "density": 3183.098861837907,
                        "modes": {"bend_y": 4},
                    },
                ]
            },
        },
    ],
    "loop": [
        {
            "name": "pin",
            "kind": {"type": "revolute", "axis": [0.0, 1.0, 0.0]},
            "a": {"link": "a"},
            "b": {"position": [0.9545049170563281, 0.0, 0.22208188425734365]},
        },
    ],
}
question = {"ask": "same_equilibrium", "of": "loops", "change": ["units", "in milliseconds"], "seed": 0}
