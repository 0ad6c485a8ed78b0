"""MuJoCo: a chain of two rods and one rod, connected by an equality constraint `connect`, which is soft in MuJoCo.

Two ways: the semi-implicit Euler method with `mjd_transitionFD`, which computes difference quotients of each step, and an adjoint by hand; and RK4,
which `mjd_transitionFD` does not support, with difference quotients of whole motions.
"""

import mujoco
import numpy as np
from mujoco import rollout

import task

EULER_STEPS, RK4_STEPS = 10_000, 1_700
WIDTH = 1e-5  # m or N m, of difference quotients
STEP_WIDTH = 1e-6  # of those of a step


# begin
def linkage(coupler, steps, is_rk4, time_constant=0.002):
    """The model, and data with the pose at the start; `time_constant`, s, is that of errors of the constraint."""
    h = task.DURATION / steps

    def rod(name, x, length, inner=""):
        mass = task.DENSITY * length
        return f"""<body name="{name}" pos="{x} 0 0"><joint name="{name}" axis="0 0 1"/>
            <inertial pos="{length / 2} 0 0" mass="{mass}" diaginertia="1e-4 {mass * length**2 / 12} {mass * length**2 / 12}"/>{inner}</body>"""

    model = mujoco.MjModel.from_xml_string(f"""<mujoco><compiler angle="radian"/>
        <option gravity="0 {-task.GRAVITY} 0" timestep="{h}" integrator="{"RK4" if is_rk4 else "Euler"}" tolerance="1e-12"/>
        <worldbody>{rod("crank", 0.0, task.CRANK, rod("coupler", task.CRANK, coupler))}{rod("rocker", task.GROUND, task.ROCKER)}</worldbody>
        <equality><connect body1="coupler" body2="rocker" anchor="{coupler} 0 0" solref="{time_constant} 1" solimp="0.9999 0.9999 0.001"/></equality>
        <actuator><motor joint="crank"/></actuator></mujoco>""")
    model.eq_data[0, 3:6] = task.ROCKER, 0.0, 0.0  # the anchor in the rocker, which the compiler computes for the pose of the file
    data = mujoco.MjData(model)
    angle, rocker = task.closure(task.START, coupler)
    data.qpos[:] = task.START, angle - task.START, rocker
    return model, data


def value(torques, coupler, steps, is_rk4):
    return task.cost(rocker_angles(*linkage(coupler, steps, is_rk4), [torques])[0])


def rocker_angles(model, data, histories):
    """The rocker's angle at the end for each history of the torque; all steps of all motions are a loop in C."""
    steps = round(task.DURATION / model.opt.timestep)
    start = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    control = np.array([task.middle_torques(torques, steps) for torques in histories])[:, :, None]
    states, _ = rollout.rollout(model, data, np.tile(start, (len(histories), 1)), control)
    return states[:, -1, 1 + 2]  # the time is first


def by_length(torques, coupler, steps, is_rk4):
    return (value(torques, coupler + WIDTH, steps, is_rk4) - value(torques, coupler - WIDTH, steps, is_rk4)) / (2 * WIDTH)
# end


# begin
def gradient_by_steps(torques, coupler, steps):
    model, data = linkage(coupler, steps, is_rk4=False)
    by_state, by_torque = np.empty((steps, 6, 6)), np.empty((steps, 6, 1))
    for step, torque in enumerate(task.middle_torques(torques, steps)):
        data.ctrl[0] = torque
        mujoco.mjd_transitionFD(model, data, STEP_WIDTH, True, by_state[step], by_torque[step], None, None)
        mujoco.mj_step(model, data)
    slope, by_middle = np.zeros(6), np.zeros(steps)
    slope[2] = data.qpos[2] - task.TARGET
    for step in reversed(range(steps)):
        by_middle[step] = by_torque[step, :, 0] @ slope
        slope = by_state[step].T @ slope
    return task.cost(data.qpos[2]), task.middles_to_knots(by_middle), by_length(torques, coupler, steps, is_rk4=False)
# end


# begin
def gradient_by_motions(torques, coupler, steps):
    histories = [torques, *(torques + sign * WIDTH * knot for knot in np.eye(len(torques)) for sign in (1, -1))]
    cost, *changed = task.cost(rocker_angles(*linkage(coupler, steps, is_rk4=True), histories))
    changed = np.array(changed).reshape(-1, 2)
    return cost, (changed[:, 0] - changed[:, 1]) / (2 * WIDTH), by_length(torques, coupler, steps, is_rk4=True)
# end


def way(gradient, steps, is_rk4):
    return lambda: (lambda torques, coupler: value(torques, coupler, steps, is_rk4), lambda torques, coupler: gradient(torques, coupler, steps))


if __name__ == "__main__":
    task.main([
        ("RK4, difference quotients of motions", RK4_STEPS, way(gradient_by_motions, RK4_STEPS, True)),
        ("Euler, `mjd_transitionFD`", EULER_STEPS, way(gradient_by_steps, EULER_STEPS, False)),
    ])
