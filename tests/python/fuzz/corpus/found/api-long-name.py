import lissom
from fuzz import values as v


def call():
    return lissom.sensors.Imu(
        robot=v.moving(),
        link="x" * 10**6,
    )
