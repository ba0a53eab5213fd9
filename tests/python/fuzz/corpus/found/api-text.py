from fuzz import values as v

forbidden = "q: ['0.1', '0.2']"


def call():
    return v.planar().mass_matrix(
        q=["0.1", "0.2"],
    )
