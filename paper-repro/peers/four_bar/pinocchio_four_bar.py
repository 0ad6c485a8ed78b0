"""Pinocchio: a chain of three rods whose end is held at D; `constraintDynamics` and its analytic derivatives, RK4 and its adjoint by hand.

The loop is cut at D, because the derivatives of 4.1.0 are wrong if both sides of the cut move (cut at C: only the column of the crank's angle). The
derivatives with respect to the length are a central difference: the library has none with respect to placements of joints.
"""

import numpy as np
import pinocchio as pin

import task

STEPS = 240
WIDTH = 1e-5  # m, of the difference quotient
BAUMGARTE = 5.0  # 1/s


# begin
class FourBar:
    def __init__(self, coupler):
        self.model = model = pin.Model()
        model.gravity.linear = np.array([0.0, -task.GRAVITY, 0.0])
        at = lambda x: pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        crank = self.rod(0, at(0.0), task.CRANK)
        rocker = self.rod(self.rod(crank, at(task.CRANK), coupler), at(coupler), task.ROCKER)
        loop = pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, rocker, at(task.ROCKER), 0, at(task.GROUND), pin.ReferenceFrame.LOCAL)
        loop.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(BAUMGARTE**2, 2 * BAUMGARTE))
        self.data, self.loops = model.createData(), [loop]
        self.loop_data = [loop.createData()]
        self.settings = pin.ProximalSettings(1e-14, 1e-14, 1e-10, 20)  # regularised: the third equation of the planar loop is 0 = 0
        pin.initConstraintDynamics(model, self.data, self.loops, self.loop_data)
        angle, of_rocker = task.closure(task.START, coupler)
        self.start = np.array([task.START, angle - task.START, of_rocker - np.pi - angle, 0.0, 0.0, 0.0])

    def rod(self, parent, placement, length):
        joint = self.model.addJoint(parent, pin.JointModelRZ(), placement, f"joint {self.model.njoints}")
        mass = task.DENSITY * length
        inertia = pin.Inertia(mass, np.array([length / 2, 0.0, 0.0]), np.diag([0.0, 1.0, 1.0]) * mass * length**2 / 12)
        self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        return joint

    def rate(self, x, torque):
        applied = np.array([torque, 0.0, 0.0])
        a = pin.constraintDynamics(self.model, self.data, x[:3], x[3:], applied, self.loops, self.loop_data, self.settings)
        return np.concatenate([x[3:], a])

    def slopes(self):
        """Derivatives of the last rate with respect to the state and the torque."""
        a_q, a_v, a_torque = pin.computeConstraintDynamicsDerivatives(self.model, self.data, self.loops, self.loop_data, self.settings)[:3]
        return np.block([[np.zeros((3, 3)), np.eye(3)], [a_q, a_v]]), np.concatenate([np.zeros(3), a_torque[:, 0]])

    def motion(self, torques, slopes=None):
        """The state at the end, by RK4; appends derivatives of the stages to a list."""
        h, x = task.DURATION / STEPS, self.start
        for before, middle, after in torques:
            total, k = np.zeros(6), np.zeros(6)
            for weight, shift, torque in ((1, 0.0, before), (2, 0.5, middle), (2, 0.5, middle), (1, 1.0, after)):
                k = self.rate(x + shift * h * k, torque)
                total += weight * k
                if slopes is not None:
                    slopes.append(self.slopes())
            x = x + h / 6 * total
        return x


def rocker(x):
    return x[:3].sum() + np.pi  # from D to C


def value(torques, coupler):
    return task.cost(rocker(FourBar(coupler).motion(task.stage_torques(torques, STEPS))))


def gradient(torques, coupler):
    h, slopes = task.DURATION / STEPS, []
    end = FourBar(coupler).motion(task.stage_torques(torques, STEPS), slopes)
    by_x, by_stage = np.zeros(6), np.zeros((STEPS, 3))
    by_x[:3] = rocker(end) - task.TARGET
    for step in reversed(range(STEPS)):
        change, by_next = by_x.copy(), np.zeros(6)
        for stage, weight, shift, at in ((3, 1, 1.0, 2), (2, 2, 0.5, 1), (1, 2, 0.5, 1), (0, 1, 0.0, 0)):
            f_x, f_torque = slopes[4 * step + stage]
            by_k = h / 6 * weight * by_x + by_next
            by_stage[step, at] += f_torque @ by_k
            by_shifted = f_x.T @ by_k
            change += by_shifted
            by_next = shift * h * by_shifted
        by_x = change
    by_length = (value(torques, coupler + WIDTH) - value(torques, coupler - WIDTH)) / (2 * WIDTH)
    return task.cost(rocker(end)), task.to_knots(by_stage), by_length
# end


if __name__ == "__main__":
    task.main([("RK4", STEPS, lambda: (value, gradient))])
