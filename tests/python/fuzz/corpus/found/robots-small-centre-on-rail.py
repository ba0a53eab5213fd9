robot = {
    "scene": {"gravity": [0.0, 0.0, -9.81]},
    "link": [
        {
            "name": "a",
            "joint": {"type": "prismatic", "axis": [0.0, 0.0, 1.0]},
            "position": [0.0, 0.0, 3.0],
            "body": {"mass": 1.0, "centre": [0.0, 0.0, 0.001]},
        },
    ],
    "tendon": [
        {
            "name": "t0",
            "path": [{"point": [0.0, 0.0, 5.0]}, {"link": "a", "point": [0.0, 0.0, 0.0]}],
            "length": 1.0,
            "stiffness": 1000.0,
        },
    ],
}
question = {"ask": "reached", "of": "cords"}
