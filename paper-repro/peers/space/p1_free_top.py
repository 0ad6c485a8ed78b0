"""1. Free rigid body, no gravity.  R' = R skew(w), J w' = -w x J w (w in body axes), r' = v.
First: Taylor series with the rotation matrix; second: quaternion, DOP853; check: energy and R J w are constant."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state
J = [0.2, 0.35, 0.5]; M = 1.3; V0 = [0.3, -0.2, 0.1]; TIMES = [1.0, 2.0]
Rs = [hk.make_vars(f"r{i}0", f"r{i}1", f"r{i}2") for i in range(3)]; w = hk.make_vars("w0", "w1", "w2"); r = hk.make_vars("x", "y", "z")
sys = []
for i in range(3):
    for j in range(3):
        k, l = (j+1) % 3, (j+2) % 3; sys.append((Rs[i][j], Rs[i][k]*w[l] - Rs[i][l]*w[k]))
L = [LD(J[i])*w[i] for i in range(3)]; M_ = cross(L, w)
for i in range(3): sys.append((w[i], M_[i]/LD(J[i])))
def variant(w0):
    x0 = list(np.eye(3).ravel()) + list(w0)
    x = taylor(sys, x0, TIMES, 1e-19); y = taylor(sys, x0, TIMES, 1e-16)
    S = Absolute([(M, np.diag(J))], [], g=(0, 0, 0)); ab = S.run(state([np.zeros(3)], [np.eye(3)], [np.array(V0)], [np.array(w0)]), TIMES)
    JJ = np.array(J, dtype=LD); H0 = JJ*np.array(w0, dtype=LD); lin = 0.5*LD(M)*sum(LD(v)**2 for v in V0); T0 = 0.5*np.sum(JJ*np.array(w0, dtype=LD)**2) + lin
    vals = []; other = dE = dH = 0
    for k, t in enumerate(TIMES):
        R = x[k][:9].reshape(3, 3); ww = x[k][9:]; p = [LD(v)*LD(t) for v in V0]; rr, R2, v2, w2 = S.split(ab[k])
        other = max(other, maxdiff(R, R2[0]), maxdiff(ww, w2[0]), maxdiff(p, rr[0])); T = 0.5*np.sum(JJ*ww**2) + lin; H = R @ (JJ*ww)
        dE = max(dE, abs(float(T-T0))); dH = max(dH, maxdiff(H, H0))
        vals.append(dict(t=t, R=R, omega_body=ww, position=p, kinetic=T, angular_momentum_world=H))
    return dict(start=dict(R=np.eye(3), omega_body=list(w0), position=[0., 0., 0.], velocity=V0, kinetic=T0, angular_momentum_world=H0), values=vals,
                accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, y)), second_formulation=other, energy_absolute=dE, angular_momentum_absolute=dH))
if __name__ == '__main__':
    e = dict(parameters=dict(mass=M, J_diag=J, g=[0, 0, 0]), general=variant((1.0, 0.05, 2.0)), near_unstable=variant((0.05, 3.0, 0.02)))
    store('1_free_top', e)
    for k in ('general', 'near_unstable'): print(k, e[k]['accuracy'], e[k]['values'][-1]['omega_body'], e[k]['values'][-1]['R'])
