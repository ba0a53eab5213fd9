import lissom

works = True


def call():
    return lissom.solve_ivp(
        fun=lambda t, y: -y,
        t_span=(0.0, 1.0),
        y0=[1.0],
    )
