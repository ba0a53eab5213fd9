from fuzz import values as v


def call():
    return v.moving().pose(
        q=v.array([0.1, 0.2]),
        X=0.1,
        t=1.7976931348623157e308,
    )
