"""MuJoCo without contacts: `mj_step` (semi-implicit Euler, damping at the end of the step) and `mjd_transitionFD`, which computes
difference quotients of a step. Constraints are switched off, and with them the limits of the joints.

The steps of a simulation are a loop in C; derivatives and the backward sweep lambda_i = A^T lambda_{i+1} are a loop in Python.
"""

import mujoco
import numpy as np

import task

WIDTH = 1e-6  # of difference quotients


class Robot:
    def __init__(self, joints, path):
        spec = mujoco.MjSpec.from_file(path)
        self.names = names = [joint.name for joint in spec.joints if joint.name in joints]
        for name in names:
            spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT).set_to_motor()
        model = spec.compile()
        model.opt.timestep = task.DT
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        ids = [model.joint(name).id for name in names]
        self.angles, self.speeds = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        model.dof_damping[self.speeds] = task.DAMPING
        self.model, self.data = model, mujoco.MjData(model)
        self.start = np.array([joints[name][0] for name in names])
        self.torque = np.array([joints[name][1] for name in names])

    def reset(self):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self.angles] = self.start
        self.data.ctrl[:] = self.torque

    def simulate(self, steps=task.STEPS):
        self.reset()
        mujoco.mj_step(self.model, self.data, steps)

    def cost(self):
        return task.cost(self.data.qpos[self.angles], self.data.qvel[self.speeds], self.start)

    def derivatives(self, is_centred):
        self.reset()
        nv, steps = self.model.nv, []
        for _ in range(task.STEPS):
            by_state, by_torque = np.empty((2 * nv, 2 * nv)), np.empty((2 * nv, self.model.nu))
            mujoco.mjd_transitionFD(self.model, self.data, WIDTH, is_centred, by_state, by_torque, None, None)
            steps.append((by_state, by_torque))
            mujoco.mj_step(self.model, self.data)
        return steps

    def gradient(self, is_centred):
        steps, nv = self.derivatives(is_centred), self.model.nv
        value, by_q, by_v = self.cost()
        slope, gradient = np.zeros(2 * nv), np.zeros(self.model.nu)
        slope[self.speeds], slope[nv + self.speeds] = by_q, by_v
        for by_state, by_torque in reversed(steps):
            gradient += by_torque.T @ slope
            slope = by_state.T @ slope
        return value, dict(zip(self.names, gradient))


def results(joints, path):
    fine = Robot(joints, path)
    fine.model.opt.timestep /= task.FINER
    fine.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    fine.simulate(task.FINER * task.STEPS)
    robot = Robot(joints, path)
    simulation = task.time_us(robot.simulate)
    for is_centred, name in ((False, "one-sided"), (True, "central")):
        library = [simulation, task.time_us(lambda: robot.derivatives(is_centred))]
        both = task.time_us(lambda: robot.gradient(is_centred))
        yield task.result(f"semi-implicit Euler, {name} differences", *robot.gradient(is_centred), [simulation, both], library, fine.cost()[0])


task.main(results)
