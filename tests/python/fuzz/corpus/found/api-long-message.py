import numpy as np

import lissom
from fuzz import values as v


def call():
    return lissom.statics(
        model=v.planar(),
        load_steps=np.broadcast_to(0.5, (10**5,)),
    )
