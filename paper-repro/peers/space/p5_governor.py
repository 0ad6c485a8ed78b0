"""5. Stiff flyball governor (IFToMM / La Coruna A05 geometry).  z up, all coordinates in the frame turning with the shaft (angle p about z).
Shaft on the z axis from 0 to 1 (revolute with the ground about z).  Rod 1 hinged at A = (0.05, 0, 1), rod 2 at B = (-0.05, 0, 1),
hinge axes = shaft y.  Rod 1 direction (cos b1, 0, -sin b1), rod 2 direction (-cos b2, 0, -sin b2), length 1, point mass 5 at the far end.
Slider: prismatic on the shaft, centre (0,0,s), turning with the shaft.  Spring-dampers from the rods' middles to (+-0.05, 0, s).
Force along each: tension K (l - 0.5) + C l'.   Start: p = 0, b1 = b2 = 30 deg, s = 0.5, p' = 2 pi, others 0 (the springs are then unstretched).
First: Lagrange in (p, b1, b2, s); second: absolute coordinates."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state
H, X, LR, PM = 1.0, 0.05, 1.0, 5.0
MSH, JSH = 0.3, [0.3*(1+1e-4)/12, 0.3*(1+1e-4)/12, 0.3*2e-4/12]
MRD, JRD = 0.3, [0.3*2e-4/12, 0.3*(1+1e-4)/12, 0.3*(1+1e-4)/12]   # x along the rod, without the point mass
MSL, JSL = 3.0, [0.005, 0.005, 0.005]
K, C, REST = 8e5, 4e4, 0.5
B0 = float(np.pi/6); S0 = 0.5; RATE = float(2*np.pi)
START = [0.0, B0, B0, S0, RATE, 0.0, 0.0, 0.0]; TIMES = [0.1, 0.5, 1.0, 2.0]
q = list(hk.make_vars("p", "b1", "b2", "s")); u = list(hk.make_vars("up", "ub1", "ub2", "us")); work = hk.make_vars("work")
p, b1, b2, s = q
Rz = rot_z(p)
def dirs(b, sg): return [sg*hk.cos(b), ex(0), -hk.sin(b)]
bodies = []; springs = []
for b, sg in ((b1, 1.), (b2, -1.)):
    R = matmul(Rz, rot_y(sg*b)); d = matvec(Rz, dirs(b, sg)); hinge = matvec(Rz, [ex(sg*X), ex(0), ex(H)])
    bodies.append((MRD, add(hinge, scale(LR/2, d)), [[JRD[0], 0., 0.], [0., JRD[1], 0.], [0., 0., JRD[2]]], R))
    bodies.append((PM, add(hinge, scale(LR, d)), None, None))
    dx = LD(LR/2)*hk.cos(b); dz = LD(H) - LD(LR/2)*hk.sin(b) - s; springs.append(hk.sqrt(dx*dx + dz*dz))   # in the shaft plane
T = 0.5*LD(JSH[2])*u[0]**2 + 0.5*LD(JSL[2])*u[0]**2 + 0.5*LD(MSL)*u[3]**2
V = LD(MSH)*LD(G)*LD(H/2) + LD(MSL)*LD(G)*s
for m, pos, J, R in bodies:
    T = T + kinetic(m, pos, J, R, q, u); V = V + LD(m)*LD(G)*pos[2]
Q = [ex(0)]*4; power = ex(0)
for l in springs:
    V = V + 0.5*LD(K)*(l - LD(REST))**2
    ld = ddt(l, q, u); power = power - LD(C)*ld*ld
    Q = [Q[i] - LD(C)*ld*hk.diff(l, q[i]) for i in range(4)]
acc = lagrange(q, u, T, V, Q)
sys = list(zip(q, u)) + list(zip(u, acc)) + [(work, power)]
allv = q + u
hz = hk.diff(T, u[0])
def main():
    x0 = START + [0.0]
    x = taylor(sys, x0, TIMES, 1e-18); y = taylor(sys, x0, TIMES, 1e-15); val = lambda st, es: evaluate(es, allv, st[:8])
    T0, V0, h0 = val(x0, [T, V, hz]); vals = []; bal = dh = asym = 0
    for k, t in enumerate(TIMES):
        Tk, Vk, h = val(x[k], [T, V, hz]); bal = max(bal, abs(float(Tk+Vk-T0-V0-x[k][8]))); dh = max(dh, abs(float(h-h0))); asym = max(asym, abs(float(x[k][1]-x[k][2])))
        vals.append(dict(t=t, shaft_angle=x[k][0], rod_angles=x[k][1:3], slider=x[k][3], shaft_rate=x[k][4], rod_rates=x[k][5:7], slider_rate=x[k][7],
                         spring_length=val(x[k], [springs[0]])[0], kinetic=Tk, potential=Vk, energy=Tk+Vk, damper_work=x[k][8]))
    # second: rod + point mass merged
    m = MRD+PM; c = np.array([(MRD*LR/2 + PM*LR)/m, 0, 0]); off = lambda mm, d: mm*(d @ d*np.eye(3)-np.outer(d, d)); e1 = np.array([1., 0, 0])
    J = np.diag(JRD) + off(MRD, c-LR/2*e1) + off(PM, c-LR*e1)
    def loads(t, r, R, v, w):
        F = [np.zeros(3) for _ in range(4)]; M = [np.zeros(3) for _ in range(4)]
        for rod, sg in ((2, 1.), (3, -1.)):
            a = sg*(LR/2*e1 - c); b = np.array([sg*X, 0, 0])
            pa = r[rod] + R[rod] @ a; va = v[rod] + R[rod] @ np.cross(w[rod], a); pb = r[1] + R[1] @ b; vb = v[1] + R[1] @ np.cross(w[1], b)
            d = pb-pa; l = np.sqrt(d @ d); n = d/l; f = (K*(l-REST) + C*(n @ (vb-va)))*n
            F[rod] += f; M[rod] += np.cross(a, R[rod].T @ f); F[1] -= f; M[1] -= np.cross(b, R[1].T @ f)
        return F, M
    S = Absolute([(MSH, np.diag(JSH)), (MSL, np.diag(JSL)), (m, J), (m, J)],
        [('ball', 0, [0, 0, -H/2], -1, [0, 0, 0]), ('perp', 0, [1, 0, 0], -1, [0, 0, 1]), ('perp', 0, [0, 1, 0], -1, [0, 0, 1]),
         ('plane', 1, [0, 0, 0], 0, [0, 0, 0], [1, 0, 0]), ('plane', 1, [0, 0, 0], 0, [0, 0, 0], [0, 1, 0]),
         ('perp', 1, [1, 0, 0], 0, [0, 0, 1]), ('perp', 1, [0, 1, 0], 0, [0, 0, 1]), ('perp', 1, [1, 0, 0], 0, [0, 1, 0]),
         ('ball', 2, list(-c), 0, [X, 0, H/2]), ('perp', 2, [1, 0, 0], 0, [0, 1, 0]), ('perp', 2, [0, 0, 1], 0, [0, 1, 0]),
         ('ball', 3, list(c), 0, [-X, 0, H/2]), ('perp', 3, [1, 0, 0], 0, [0, 1, 0]), ('perp', 3, [0, 0, 1], 0, [0, 1, 0])], loads)
    Ry = lambda a: np.array(rot_y(a, np.cos, np.sin)); W = np.array([0, 0, RATE])
    Rs = [np.eye(3), np.eye(3), Ry(B0), Ry(-B0)]
    rs = [np.array([0, 0, H/2]), np.array([0, 0, S0]), np.array([X, 0, H]) + Rs[2] @ c, np.array([-X, 0, H]) - Rs[3] @ c]
    y0 = state(rs, Rs, [np.cross(W, r) for r in rs], [R.T @ W for R in Rs]); assert S.residual(y0) < 1e-12
    A0 = S.acc(0, y0); acc0 = val(x0, acc); dA = maxdiff([acc0[0], acc0[3]], [A0[5], A0[8]])
    ab = S.run(y0, TIMES, 1e-12, 1e-13); other = 0
    for k in range(len(TIMES)):
        r, R, v, w = S.split(ab[k]); B1 = R[0].T @ R[2]; B2 = R[0].T @ R[3]; Ws = [R[i] @ w[i] for i in range(4)]; yy = R[0][:, 1]
        an = np.arctan2(R[0][1, 0], R[0][0, 0]); an += 2*np.pi*np.round((float(x[k][0])-an)/2/np.pi)
        mine = [an, np.arctan2(B1[0, 2], B1[0, 0]), np.arctan2(-B2[0, 2], B2[0, 0]), r[1][2], Ws[0][2], (Ws[2]-Ws[0]) @ yy, -(Ws[3]-Ws[0]) @ yy, v[1][2]]
        other = max(other, maxdiff(mine, x[k][:8]))
    e = dict(parameters=dict(shaft=dict(mass=MSH, length=H, J_diag=JSH), rod=dict(mass=MRD, length=LR, J_diag_x_along=JRD, point_mass=PM), hinge_offset=X,
             slider=dict(mass=MSL, J_diag=JSL), spring=dict(K=K, C=C, rest=REST), g=[0, 0, -G]),
             start=dict(shaft_angle=0.0, rod_angles=[B0, B0], slider=S0, shaft_rate=RATE, rod_rates=[0.0, 0.0], slider_rate=0.0, accelerations=acc0,
                        kinetic=T0, potential=V0, energy=T0+V0), values=vals,
             accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, y)), second_formulation=other, second_formulation_evaluations=S.nfev, power_balance=bal,
                           momentum_z_absolute=dh, asymmetry=asym, start_acceleration_difference=dA, angular_momentum_z=h0))
    store('5_governor', e); print(e['accuracy']); print(e['start'])
    for v in vals: print(v)
if __name__ == '__main__': main()
