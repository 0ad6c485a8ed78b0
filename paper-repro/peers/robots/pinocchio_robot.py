"""Pinocchio alone: its forward dynamics (aba) and their derivatives in a loop in Python.

Semi-implicit Euler, with damping D evaluated at the end of the step:
  (M + h D) a = tau - D v - b,  v' = v + h a,  q' = q (+) h v'.
The adjoint of a step, for slopes (lq, lv) at its end:
  mu = lv + h J1^T lq,  dJ/dtau += h a_tau^T mu,  lq <- J0^T lq + h a_q^T mu,  lv <- mu + h (a_v - a_tau D)^T mu,
where J0 and J1 are the derivatives of q (+) h v' with respect to q and h v'.
"""

import numpy as np
import pinocchio

import task


class Robot:
    def __init__(self, joints, path):
        self.model = pinocchio.buildModelFromUrdf(path)
        self.data = self.model.createData()
        self.names = names = [name for name in self.model.names if name in joints]
        self.count = len(names)
        self.is_free = self.model.nq > self.model.nv
        self.start = np.array([joints[name][0] for name in names])
        self.q = pinocchio.neutral(self.model)
        self.q[-self.count :] = self.start
        self.damping, self.torque = np.zeros(self.model.nv), np.zeros(self.model.nv)
        self.damping[-self.count :] = task.DAMPING
        self.torque[-self.count :] = [joints[name][1] for name in names]

        self.model.armature = task.DT * self.damping
        self.calls = []

    def simulate(self):
        model, data, h, q, v = self.model, self.data, task.DT, self.q, np.zeros(self.model.nv)
        self.calls = []
        for _ in range(task.STEPS):
            torque = self.torque - self.damping * v
            self.calls.append((q, v, torque))
            v = v + h * pinocchio.aba(model, data, q, v, torque)
            q = pinocchio.integrate(model, q, h * v)
        return q, v

    def gradient(self):
        model, data, h, q, v = self.model, self.data, task.DT, self.q, np.zeros(self.model.nv)
        steps = []
        for _ in range(task.STEPS):
            a_q, a_v, a_torque = pinocchio.computeABADerivatives(model, data, q, v, self.torque - self.damping * v)
            v = v + h * data.ddq
            change = h * v
            moved = [pinocchio.dIntegrate(model, q, change, by) for by in (pinocchio.ARG0, pinocchio.ARG1)] if self.is_free else None
            steps.append((a_q.copy(), a_v.copy(), a_torque.copy(), moved))
            q = pinocchio.integrate(model, q, change)
        value, by_q, by_v = task.cost(q[-self.count :], v[-self.count :], self.start)
        slope_q, slope_v, gradient = np.zeros(model.nv), np.zeros(model.nv), np.zeros(model.nv)
        slope_q[-self.count :], slope_v[-self.count :] = by_q, by_v
        for a_q, a_v, a_torque, moved in reversed(steps):
            mu = slope_v + h * (moved[1].T @ slope_q if moved else slope_q)
            by_torque = h * (a_torque.T @ mu)
            gradient += by_torque
            slope_q = (moved[0].T @ slope_q if moved else slope_q) + h * (a_q.T @ mu)
            slope_v = mu + h * (a_v.T @ mu) - self.damping * by_torque
        return value, dict(zip(self.names, gradient[-self.count :]))

    def library(self, function):
        """Time of one function of the library for the states of all steps."""
        model, data = self.model, self.data

        def run():
            for q, v, torque in self.calls:
                function(model, data, q, v, torque)

        return task.time_us(run)


def results(joints, path):
    robot = Robot(joints, path)
    times = [task.time_us(robot.simulate), task.time_us(robot.gradient)]
    library = [robot.library(pinocchio.aba), robot.library(pinocchio.computeABADerivatives)]
    yield task.result("semi-implicit Euler", *robot.gradient(), times, library)


task.main(results)
