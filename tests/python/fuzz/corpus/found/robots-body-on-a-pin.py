robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "free"},
            "body": {
                "mass": 1.0,
                "centre": [0.0, 0.0, 0.001],
                "inertia": [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]],
            },
        },
    ],
    "loop": [
        {
            "name": "pin",
            "kind": {"type": "spherical"},
            "a": {"link": "a"},
            "b": {"position": [0.0, 0.0, 1.0]},
        },
    ],
}
question = {"ask": "reached", "of": "loops"}
