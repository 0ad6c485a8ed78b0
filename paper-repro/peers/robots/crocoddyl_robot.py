"""Crocoddyl (C++): Euler (q_{i+1} from v_{i+1}) and Runge-Kutta. No damping: its forward dynamics has none.

The states come from `rollout`, which also computes what `calcDiff` needs, and the derivatives of all steps from `calcDiff`; both are loops in C++.
The cost and the backward sweep lambda_i = Fx^T lambda_{i+1}, dJ/dtau = sum Fu^T lambda_{i+1} are added in numpy.
"""

import crocoddyl
import numpy as np
import pinocchio

import task


class Problem:
    def __init__(self, joints, path, integrate, dt=task.DT):
        self.model = pinocchio.buildModelFromUrdf(path)
        state = crocoddyl.StateMultibody(self.model)
        is_free = self.model.existJointName("root_joint")
        actuation = crocoddyl.ActuationModelFloatingBase(state) if is_free else crocoddyl.ActuationModelFull(state)
        costs = crocoddyl.CostModelSum(state, actuation.nu)
        dynamics = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)
        # Without this, crocoddyl 3.2.1 with pinocchio 4.1.0 computes accelerations without gravity, and derivatives with it.
        dynamics.armature = np.zeros(state.nv)
        self.names = names = list(self.model.names)[-actuation.nu :]
        self.start = np.array([joints[name][0] for name in names])
        x = state.zero()
        self.angles, self.speeds = slice(self.model.nq - actuation.nu, self.model.nq), slice(-actuation.nu, None)
        x[self.angles] = self.start
        step, end = integrate(dynamics, dt), integrate(dynamics, 0.0)
        self.shooting = crocoddyl.ShootingProblem(x, [step] * task.STEPS, end)
        self.shooting.nthreads = 1
        self.controls = [np.array([joints[name][1] for name in names])] * task.STEPS

    def simulate(self):
        return self.shooting.rollout(self.controls)

    def derivatives(self):
        states = self.simulate()
        self.shooting.calcDiff(states, self.controls)
        return states

    def cost(self, states):
        return task.cost(states[-1][self.angles], states[-1][self.speeds], self.start)

    def gradient(self):
        states = self.derivatives()
        value, by_q, by_v = self.cost(states)
        slope = np.zeros(2 * self.model.nv)
        slope[self.model.nv - len(by_q) : self.model.nv], slope[self.speeds] = by_q, by_v
        gradient = np.zeros(len(by_q))
        for data in reversed(self.shooting.runningDatas.tolist()):
            gradient += data.Fu.T @ slope
            slope = data.Fx.T @ slope
        return value, dict(zip(self.names, gradient))


def converged(joints, path, integrate):
    """J with smaller steps; one problem for all of them would need tens of gigabytes."""
    problem = Problem(joints, path, integrate, task.DT / task.FINER)
    for _ in range(task.FINER):
        states = problem.simulate()
        problem.shooting.x0 = states[-1]
    return problem.cost(states)[0]


def results(joints, path):
    euler = lambda model, dt: crocoddyl.IntegratedActionModelEuler(model, dt)
    fourth = lambda model, dt: crocoddyl.IntegratedActionModelRK(model, crocoddyl.RKType.four, dt)
    finer = converged(joints, path, fourth)
    for scheme, integrate in (("semi-implicit Euler", euler), ("RK4", fourth)):
        problem = Problem(joints, path, integrate)
        library = [task.time_us(problem.simulate), task.time_us(problem.derivatives)]
        yield task.result(scheme, *problem.gradient(), [library[0], task.time_us(problem.gradient)], library, finer, damping=0.0)


task.main(results)
