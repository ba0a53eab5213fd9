from fuzz import values as v

layouts = True


def call(array=v.array):
    return v.planar().inverse_dynamics(
        q=array([0.1, 0.2], "packed"),
        qd=array([0.3, -0.1], "unaligned"),
        qdd=array([-0.2, 0.5], "packed_big_endian"),
    )
