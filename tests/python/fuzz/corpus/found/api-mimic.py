import lissom

forbidden = "offset: {}"


def call():
    return lissom.Mimic(
        link="a",
        offset={},
    )
