robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "spherical"},
            "body": {
                "mass": 1.0,
                "centre": [0.0222, 0.0075, -0.0089],
                "inertia": [
                    [0.63321, 0.05374, 0.04534],
                    [0.05374, 0.4657, -0.24883],
                    [0.04534, -0.24883, 0.25635],
                ],
            },
            "q0": [1.802, 1.315, 0.357],
        },
    ],
}
question = {"ask": "frequencies", "of": "balls", "start": True}
