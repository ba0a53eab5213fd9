robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "spherical"},
            "body": {
                "mass": 1.0,
                "centre": [0.1, -0.2, 0.3],
                "inertia": [[0.3, 0.0, 0.0], [0.0, 0.35, 0.0], [0.0, 0.0, 0.4]],
            },
            "load": [{"force": [5.0, -8.0, 3.0]}],
            "q0": [0.961, -4.909, 3.314],
            "support": [{"stiffness": 20.0, "position": [0.5, 0.5, -0.5]}],
        },
    ],
}
question = {"ask": "balance", "of": "balls", "method": "newton", "start": True}
