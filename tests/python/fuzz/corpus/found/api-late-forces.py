from fuzz import values as v


def call():
    return v.moving().inverse_dynamics(
        q=v.array([0.1, 0.2]),
        qd=v.array([0.3, -0.1]),
        qdd=v.array([-0.2, 0.5]),
        t=1.7976931348623157e308,
    )
