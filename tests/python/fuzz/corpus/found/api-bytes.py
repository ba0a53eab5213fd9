import lissom

forbidden = "y0: b'0.5'"


def call():
    return lissom.solve_ivp(
        fun=lambda t, y: -y,
        t_span=(0.0, 1.0),
        y0=b"0.5",
    )
