from uwsim.missions import wait


def mission(vehicle):
    vehicle.release()
    vehicle.set_effort(surge=0.3)
    for _ in range(20):
        yield wait(0.5)
