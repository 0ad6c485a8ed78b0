"""8. Gyroscope in gimbals.  All three axes meet at the origin.  Outer ring about world z (a), inner ring about the outer
ring's x (b), rotor about the inner ring's y (c):  Ro = Rz(a), Ri = Ro Rx(b), Rr = Ri Ry(c).  Weight (point mass) at (0, 0.1, 0)
of the inner ring.  No friction.  First: Lagrange; second: absolute coordinates (weight merged into the inner ring); third: pinocchio."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

MO, JO = 0.6, [2.0e-3, 2.2e-3, 3.0e-3]      # outer ring, centre at the origin
MI, JI = 0.4, [1.0e-3, 1.5e-3, 9.0e-4]      # inner ring, centre at the origin
MR, JR = 1.5, [1.5e-3, 2.7e-3, 1.5e-3]      # rotor, y = spin axis, centre at the origin
MW, PW = 0.2, [0.0, 0.1, 0.0]               # weight, in the inner ring
START = [0.3, 0.2, 0.0, 0.0, 0.0, 60.0]     # a, b, c, rates (c' relative to the inner ring)
TIMES = [0.5, 1.0]
q = list(hk.make_vars("a", "b", "c")); u = list(hk.make_vars("ua", "ub", "uc"))
Ro = rot_z(q[0]); Ri = matmul(Ro, rot_x(q[1])); Rr = matmul(Ri, rot_y(q[2]))
dg = lambda d: [[d[0], 0., 0.], [0., d[1], 0.], [0., 0., d[2]]]
pw = matvec(Ri, PW); vw = velocity(pw, q, u)
T = 0.5*LD(MW)*dot(vw, vw)
for R, J in ((Ro, JO), (Ri, JI), (Rr, JR)):
    w = omega_body(R, q, u); T = T + 0.5*sum((LD(J[i])*w[i]**2 for i in range(3)), ex(0))
V = LD(MW)*LD(G)*pw[2]
acc = lagrange(q, u, T, V, [0., 0., 0.]); sys = list(zip(q, u)) + list(zip(u, acc)); allv = q + u
hz = sum((x for x in [dot([0., 0., 1.], matvec(R, [LD(J[i])*omega_body(R, q, u)[i] for i in range(3)])) for R, J in ((Ro, JO), (Ri, JI), (Rr, JR))]), LD(MW)*cross(pw, vw)[2])
def main():
    x = taylor(sys, START, TIMES, 1e-18); y = taylor(sys, START, TIMES, 1e-15)
    T0, V0, h0 = evaluate([T, V, hz], allv, START); vals = []; drift = dh = 0
    for k, t in enumerate(TIMES):
        Tk, Vk, hk_ = evaluate([T, V, hz], allv, x[k]); drift = max(drift, abs(float(Tk+Vk-T0-V0))); dh = max(dh, abs(float(hk_-h0)))
        vals.append(dict(t=t, angles=x[k][:3], rates=x[k][3:], weight=evaluate(pw, q, x[k][:3]), kinetic=Tk, potential=Vk, energy=Tk+Vk, momentum_z=hk_))
    # second: inner ring and weight as one body
    mi = MI+MW; ci = MW*np.array(PW)/mi; pt = lambda m, d: m*(d @ d*np.eye(3)-np.outer(d, d))
    Ji = np.diag(JI) + pt(MI, ci) + pt(MW, np.array(PW)-ci)
    S = Absolute([(MO, np.diag(JO)), (mi, Ji), (MR, np.diag(JR))],
        [('ball', 0, [0, 0, 0], -1, [0, 0, 0]), ('perp', 0, [1, 0, 0], -1, [0, 0, 1]), ('perp', 0, [0, 1, 0], -1, [0, 0, 1]),
         ('ball', 1, list(-ci), 0, [0, 0, 0]), ('perp', 1, [0, 1, 0], 0, [1, 0, 0]), ('perp', 1, [0, 0, 1], 0, [1, 0, 0]),
         ('ball', 2, [0, 0, 0], 1, list(-ci)), ('perp', 2, [1, 0, 0], 1, [0, 1, 0]), ('perp', 2, [0, 0, 1], 1, [0, 1, 0])])
    N = lambda f, an: np.array(f(an, np.cos, np.sin))
    def full(s):
        s = np.array(s, float); A = N(rot_z, s[0]); B = A @ N(rot_x, s[1]); C = B @ N(rot_y, s[2])
        wo = s[3]*np.array([0, 0, 1.]); wi = wo + s[4]*A[:, 0]; wr = wi + s[5]*B[:, 1]; r = B @ ci
        return state([np.zeros(3), r, np.zeros(3)], [A, B, C], [np.zeros(3), np.cross(wi, r), np.zeros(3)], [A.T @ wo, B.T @ wi, C.T @ wr])
    y0 = full(START); assert S.residual(y0) < 1e-13; ab = S.run(y0, TIMES); other = 0
    for k in range(len(TIMES)):
        r, R, v, w = S.split(ab[k]); W = [R[i] @ w[i] for i in range(3)]; B = R[0].T @ R[1]; C = R[1].T @ R[2]
        m = [np.arctan2(R[0][1, 0], R[0][0, 0]), np.arctan2(B[2, 1], B[1, 1]), np.arctan2(C[0, 2], C[0, 0])]
        m = [mm + 2*np.pi*np.round((float(x[k][i])-mm)/2/np.pi) for i, mm in enumerate(m)]
        m += [W[0][2], (W[1]-W[0]) @ R[0][:, 0], (W[2]-W[1]) @ R[1][:, 1]]; other = max(other, maxdiff(m, x[k]))
    import pinocchio as pin
    mod = pin.Model(); Id = pin.SE3.Identity(); z3 = np.zeros(3)
    j = mod.addJoint(0, pin.JointModelRZ(), Id, 'a'); mod.appendBodyToJoint(j, pin.Inertia(MO, z3, np.diag(JO)), Id)
    j = mod.addJoint(j, pin.JointModelRX(), Id, 'b'); mod.appendBodyToJoint(j, pin.Inertia(mi, ci, Ji), Id)
    j = mod.addJoint(j, pin.JointModelRY(), Id, 'c'); mod.appendBodyToJoint(j, pin.Inertia(MR, z3, np.diag(JR)), Id)
    dat = mod.createData(); mod.gravity.linear = np.array([0, 0, -G]); wp = 0
    for s in [START] + x:
        s = np.array(s, float); al = pin.aba(mod, dat, s[:3], s[3:], z3); mine = evaluate(acc, allv, s); wp = max(wp, maxdiff(al, mine))
    e = dict(parameters=dict(outer=dict(mass=MO, J_diag=JO), inner=dict(mass=MI, J_diag=JI), rotor=dict(mass=MR, J_diag=JR),
             weight=dict(mass=MW, at_inner=PW), g=[0, 0, -G]),
             start=dict(angles=START[:3], rates=START[3:], accelerations=evaluate(acc, allv, START), kinetic=T0, potential=V0, energy=T0+V0, momentum_z=h0),
             values=vals, accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, y)), second_formulation=other, energy_absolute=drift,
             momentum_z_absolute=dh, pinocchio_acceleration=wp))
    store('8_gimbals', e); print(e['accuracy']); print(vals)
if __name__ == '__main__': main()
