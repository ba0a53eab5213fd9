robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "free"},
            "body": {
                "mass": 1.0,
                "centre": [0.0, 0.0, 0.0],
                "inertia": [[0.07, 0.0, 0.0], [0.0, 0.07, 0.0], [0.0, 0.0, 0.07]],
            },
            "q0": [0.0, 0.0, 1.0, 0.3, -0.5, 0.9],
        },
    ],
    "loop": [
        {
            "name": "pin",
            "kind": {"type": "spherical"},
            "a": {"link": "a", "position": [0.0, 0.0, 1.0]},
            "b": {"position": [0.0, 0.0, 2.0]},
        },
    ],
}
question = {"ask": "reached", "of": "loops", "start": True}
