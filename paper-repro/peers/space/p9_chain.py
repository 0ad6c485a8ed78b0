"""9. Two links in space with universal joints (revolute about the parent's x, then about the new y), full tensors.
R1 = Rx(q0) Ry(q1),   R2 = R1 Rx(q2) Ry(q3);  the cross pieces between are massless.
Joint 1 at the origin; link 1 centre at R1 c1; joint 2 at R1 d1; link 2 centre at R1 d1 + R2 c2.
No damping, gravity.  First: Lagrange; second: absolute coordinates (a massless cross replaced by the
condition: parent x axis perpendicular to child y axis); third: pinocchio."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

M1, M2 = 1.7, 0.9
C1 = [0.05, -0.03, -0.22]; D1 = [0.1, 0.04, -0.45]; C2 = [-0.04, 0.06, -0.18]
J1 = [[0.031, 0.004, -0.003], [0.004, 0.027, 0.002], [-0.003, 0.002, 0.012]]       # about own centre, body axes
J2 = [[0.014, -0.002, 0.001], [-0.002, 0.011, 0.0015], [0.001, 0.0015, 0.006]]
START = [0.5, -0.3, 0.7, 0.4, 1.2, -0.8, 0.6, 2.0]      # q0..q3, rates
TIMES = [0.25, 0.5]
STATES = [                                              # five "random" states q0..q3, u0..u3
 [0.31, -0.72, 0.55, 0.18, 1.3, -2.1, 0.7, 3.2],
 [-1.24, 0.42, -0.93, 0.77, -0.6, 1.9, 2.4, -1.1],
 [2.05, 0.88, 0.21, -1.02, 2.2, 0.4, -3.1, 1.6],
 [-0.45, -1.1, 1.62, -0.37, -1.7, -0.9, 1.2, 0.3],
 [0.93, 0.15, -2.3, 0.64, 0.2, 3.4, -1.5, -2.6]]
q = hk.make_vars("q0", "q1", "q2", "q3"); u = hk.make_vars("u0", "u1", "u2", "u3")
R1 = matmul(rot_x(q[0]), rot_y(q[1])); R2 = matmul(R1, matmul(rot_x(q[2]), rot_y(q[3])))
p1 = matvec(R1, C1); p2 = add(matvec(R1, D1), matvec(R2, C2))
T = kinetic(M1, p1, J1, R1, q, u) + kinetic(M2, p2, J2, R2, q, u)
V = LD(G)*(LD(M1)*p1[2] + LD(M2)*p2[2])
acc = lagrange(q, u, T, V, [0., 0., 0., 0.])
sys = list(zip(q, u)) + list(zip(u, acc))

def num(s):
    """attitudes, centres and velocities of both links from a minimal state"""
    c, sn = np.cos, np.sin; s = np.array(s, float); A = np.array(rot_x(s[0], c, sn)); B = np.array(rot_y(s[1], c, sn))
    C = np.array(rot_x(s[2], c, sn)); D = np.array(rot_y(s[3], c, sn))
    Ra = A @ B; Rb = Ra @ C @ D; ux, uy = np.array([1., 0, 0]), np.array([0, 1., 0])
    W1 = s[4]*ux + s[5]*(A @ uy); W2 = W1 + s[6]*(Ra @ ux) + s[7]*(Ra @ C @ uy)
    r1 = Ra @ C1; j = Ra @ D1; r2 = j + Rb @ C2
    return [r1, r2], [Ra, Rb], [np.cross(W1, r1), np.cross(W1, j) + np.cross(W2, r2-j)], [Ra.T @ W1, Rb.T @ W2]
def minimal(S, y):
    r, R, v, w = S.split(y)
    def ang(R):  # R = Rx(a) Ry(b):  R[0] = (cos b, 0, sin b), column 1 = (0, cos a, sin a)
        return [np.arctan2(R[2, 1], R[1, 1]), np.arctan2(R[0, 2], R[0, 0])]
    a1 = ang(R[0]); a2 = ang(R[0].T @ R[1])
    W1 = R[0] @ w[0]; rel = R[0].T @ (R[1] @ w[1] - W1)
    f = lambda W, a: [W[0], np.array([0, np.cos(a), np.sin(a)]) @ W]
    return a1 + a2 + f(W1, a1[0]) + f(rel, a2[0])

def main():
    S = Absolute([(M1, J1), (M2, J2)],
        [('ball', 0, [-x for x in C1], -1, [0, 0, 0]), ('perp', 0, [0, 1, 0], -1, [1, 0, 0]),
         ('ball', 1, [-x for x in C2], 0, list(np.array(D1)-np.array(C1))), ('perp', 1, [0, 1, 0], 0, [1, 0, 0])])
    import pinocchio as pin
    mod = pin.Model(); I3 = np.eye(3); Id = pin.SE3.Identity()
    j = mod.addJoint(0, pin.JointModelRX(), Id, 'a'); j = mod.addJoint(j, pin.JointModelRY(), Id, 'b')
    mod.appendBodyToJoint(j, pin.Inertia(M1, np.array(C1), np.array(J1)), Id)
    j = mod.addJoint(j, pin.JointModelRX(), pin.SE3(I3, np.array(D1)), 'c'); j = mod.addJoint(j, pin.JointModelRY(), Id, 'd')
    mod.appendBodyToJoint(j, pin.Inertia(M2, np.array(C2), np.array(J2)), Id)
    dat = mod.createData(); mod.gravity.linear = np.array([0, 0, -G])
    allv = q + u; wp = wa = 0; rnd = []
    for s in [START] + STATES:
        a = evaluate(acc, allv, s); TV = evaluate([T, V], allv, s)
        al = pin.aba(mod, dat, np.array(s[:4]), np.array(s[4:]), np.zeros(4)); wp = max(wp, maxdiff(a, al)/float(np.max(np.abs(a))))
        y = state(*num(s)); assert S.residual(y) < 1e-12; A = S.acc(0, y)     # compare d(omega)/dt by pushing a through a small quadrature-free check:
        # body angular accelerations from the minimal ones, by the derivative of omega_body
        w = omega_body(R1, q, u) + omega_body(R2, q, u)
        wd = [sum((hk.diff(x, q[i])*u[i] + hk.diff(x, u[i])*ex(a[i]) for i in range(4)), ex(0)) for x in w]
        wdn = evaluate(wd, allv, s); wa = max(wa, maxdiff(wdn, np.concatenate([A[3:6], A[9:12]]))/float(np.max(np.abs(wdn))))
        rnd.append(dict(q=s[:4], u=s[4:], acceleration=a, kinetic=TV[0], potential=TV[1]))
    x = taylor(sys, START, TIMES, 1e-18); z = taylor(sys, START, TIMES, 1e-15)
    ab = S.run(state(*num(START)), TIMES); T0, V0 = evaluate([T, V], allv, START)
    vals = []; other = drift = 0
    for k, t in enumerate(TIMES):
        Tk, Vk = evaluate([T, V], allv, x[k]); drift = max(drift, abs(float(Tk+Vk-T0-V0)))
        m = minimal(S, ab[k]); other = max(other, maxdiff(m, x[k]))
        vals.append(dict(t=t, q=x[k][:4], u=x[k][4:], kinetic=Tk, potential=Vk, energy=Tk+Vk, centre2=evaluate(p2, q, x[k][:4])))
    e = dict(parameters=dict(mass=[M1, M2], centre1=C1, joint2_in_1=D1, centre2=C2, J1=J1, J2=J2, g=[0, 0, -G]),
             start=rnd[0], random_states=rnd[1:], values=vals,
             accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, z)), second_formulation=other, energy_absolute=drift,
                           pinocchio_acceleration_relative=wp, absolute_acceleration_relative=wa))
    store('9_chain', e); print(e['accuracy']); print(vals[-1]); print(rnd[1])
if __name__ == '__main__': main()
