import lissom


def call():
    return lissom.solve_ivp(
        fun=lambda t, y: -y,
        t_span=(0.0, 1.0),
        y0=[1.0, 2.0],
        events=range(10**9),
    )
