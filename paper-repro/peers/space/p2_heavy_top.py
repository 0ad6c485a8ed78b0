"""2. Heavy top (Geradin-Cardona numbers).  Fixed point O = origin, gravity (0,0,-9.81).
First formulation: Euler's equations about the fixed point in body axes with the rotation matrix as state:
   R' = R skew(w),   J_O w' = c x (m R^T g) - w x J_O w,   J_O = J + m(|c|^2 I - c c^T).
Second: absolute coordinates (quaternion) with a ball joint.  Third: pinocchio's acceleration."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

m = 15.0
c = [0.0, 1.0, 0.0]                       # centre of mass in body axes, from O
J = [0.234375, 0.46875, 0.234375]         # about the centre, body axes
cc = np.array(c)
JO = np.diag(J) + m*(cc @ cc*np.eye(3) - np.outer(cc, cc))

Rs = [hk.make_vars(f"r{i}0", f"r{i}1", f"r{i}2") for i in range(3)]
w = hk.make_vars("w0", "w1", "w2")
rhs = []
for i in range(3):
    for j in range(3):                    # (R skew(w))_ij
        k, l = (j+1) % 3, (j+2) % 3       # column j of skew(w): +w_l at row k, -w_k at row l
        rhs.append((Rs[i][j], Rs[i][k]*w[l] - Rs[i][l]*w[k]))
gb = [-m*G*Rs[2][i] for i in range(3)]    # weight in body axes
L = [LD(JO[i, i])*w[i] for i in range(3)]
M = sub(cross(c, gb), cross(w, L))
for i in range(3): rhs.append((w[i], M[i]/LD(JO[i, i])))

times = [0.5, 1.0]
def energies(x):
    x = np.array(x, dtype=LD); ww = x[9:12]
    return 0.5*sum(LD(JO[i, i])*ww[i]**2 for i in range(3)), LD(m)*LD(G)*x[6+1]*LD(c[1])

def variant(w0):
    x0 = list(np.eye(3).ravel()) + list(w0)
    a = taylor(rhs, x0, times, 1e-19); b = taylor(rhs, x0, times, 1e-16)
    tolerance = max(maxdiff(p, q) for p, q in zip(a, b))
    # second formulation
    S = Absolute([(m, np.diag(J))], [('ball', 0, list(-cc), -1, [0, 0, 0])])
    y0 = state([cc], [np.eye(3)], [np.cross(w0, cc)], [np.array(w0, float)])
    ab = S.run(y0, times)
    other = 0.0
    vals = []
    for k, t in enumerate(times):
        Rk = a[k][:9].reshape(3, 3); r, R2, v2, w2 = S.split(ab[k])
        other = max(other, maxdiff(Rk, R2[0]), maxdiff(Rk @ cc, r[0]), maxdiff(a[k][9:], w2[0])/max(1, abs(w0[1])))
        T, V = energies(a[k])
        vals.append(dict(t=t, R=Rk, omega_body=a[k][9:], centre=Rk @ cc, centre_velocity=Rk @ np.cross(a[k][9:], cc),
                         kinetic=T, potential=V, energy=T+V,
                         orthogonality_error=float(np.max(np.abs(Rk.T @ Rk - np.eye(3))))))
    T0, V0 = energies(np.array(x0))
    drift = max(abs(float(v['energy']-T0-V0)) for v in vals)/abs(float(T0+V0))
    acc0 = S.acc(0, y0)
    import pinocchio as pin
    mod = pin.Model(); j = mod.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), 'o')
    mod.appendBodyToJoint(j, pin.Inertia(m, cc, np.diag(J)), pin.SE3.Identity())
    dat = mod.createData(); mod.gravity.linear = np.array([0, 0, -G])
    worst = 0
    for st in [np.array(x0, dtype=LD)] + a:       # the same state for both, relative to the largest acceleration
        R = st[:9].reshape(3, 3).astype(float); ww = st[9:].astype(float); p = pin.Quaternion(R).coeffs()
        al = pin.aba(mod, dat, p, ww, np.zeros(3))
        mine = np.linalg.solve(JO, np.cross(c, R.T @ [0, 0, -m*G]) - np.cross(ww, JO @ ww))
        worst = max(worst, np.max(np.abs(al-mine))/np.max(np.abs(mine)))
    return dict(omega0_body=list(w0), start=dict(R=np.eye(3), centre=c, centre_velocity=np.cross(w0, cc),
                kinetic=T0, potential=V0, energy=T0+V0, angular_acceleration_body=acc0[3:6]),
                values=vals, accuracy=dict(two_tolerances=tolerance, second_formulation=other, energy_relative=drift,
                pinocchio_acceleration_relative=worst))

if __name__ == '__main__':
    e = dict(parameters=dict(mass=m, centre_body=c, J_centre_body_diag=J, J_fixed_point_diag=np.diag(JO), g=[0, 0, -G]),
             fast=variant((0., 150., -4.61538)), slow=variant((0., 20., -2.)))
    store('2_heavy_top', e)
    for k in ('fast', 'slow'):
        print(k, e[k]['accuracy'])
        for v in e[k]['values']: print(v['t'], v['centre'], v['omega_body'], float(v['energy']))
