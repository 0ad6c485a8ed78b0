"""4. Bricard mechanism (IFToMM / La Coruna A04 geometry): six revolutes, five moving rods P0P1..P4P5, the sixth link P5P0 is the ground.
Start (at rest):  P0 (0,0,0)  P1 (1,0,0)  P2 (1,-1,0)  P3 (1,-1,1)  P4 (0,-1,1)  P5 (0,0,1);   gravity (0,-9.81,0).
Joint axes at the start: P0 y, P1 z, P2 x, P3 y, P4 z, P5 x.  Body frames = world axes at the start.
Rods: mass 1, centre halfway, tensor 1/12 transversal, 1/600 along the rod.
R1 = Ry(q1), R2 = R1 Rz(q2), R3 = R2 Rx(q3), R4 = R3 Ry(q4), R5 = R4 Rz(q5), I = R5 Rx(q6).
The one-parameter motion is q = (d, e, d, e, d, e) with  f(d,e) = sin d + sin e + sin d sin e = 0  (checked below to 1e-18).
First: along the curve f = 0 with  d' = f_e u, e' = -f_d u,  T = M(d,e) u^2/2:   M u' = -(X M) u^2/2 - X V,   X = f_e d/dd - f_d d/de.
Second: absolute coordinates, 30 constraints of rank 29, least squares."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state
MASS, JT, JA = 1.0, 1/12, 1/600
PTS = [[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]]
AXES = [[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]]
GV = [0.0, -9.81, 0.0]; TIMES = [0.5, 1.0, 2.0, 5.0]
DIR = [[float(b-a) for a, b in zip(PTS[k], PTS[k+1])] for k in range(5)]
JB = [np.eye(3)*JT + (JA-JT)*np.outer(d, d) for d in map(np.array, DIR)]
d, e, uu = hk.make_vars("d", "e", "u")
q = [d, e]
f = hk.sin(d) + hk.sin(e) + hk.sin(d)*hk.sin(e)
fd, fe = hk.diff(f, d), hk.diff(f, e)
tang = [fe, -fd]                                     # tangent of the curve: derivative per unit u
ROT = [rot_y, rot_z, rot_x, rot_y, rot_z, rot_x]
R = [[ex(v) for v in r] for r in EYE]; P = [ex(0)]*3; M = ex(0); V = ex(0); joints = [P]; centres = []
for k in range(5):
    R = matmul(R, ROT[k](q[k % 2])); c = add(P, matvec(R, scale(0.5, DIR[k]))); P = add(P, matvec(R, DIR[k]))
    joints.append(P); centres.append(c)
    vc = [ddt(x, q, tang) for x in c]
    Rd = [[ddt(x, q, tang) for x in row] for row in R]; W = matmul(transpose(R), Rd); w = [W[2][1], W[0][2], W[1][0]]
    M = M + LD(MASS)*dot(vc, vc) + sum((LD(JB[k][i][i])*w[i]*w[i] for i in range(3)), ex(0)); V = V - LD(MASS)*sum((LD(GV[i])*c[i] for i in range(3)), ex(0))
R6 = matmul(R, rot_x(e)); P6 = add(P, matvec(R6, [0., 0., -1.]))
closure = P6 + [R6[i][j] - EYE[i][j] for i in range(3) for j in range(3)]
X = lambda g: hk.diff(g, d)*fe - hk.diff(g, e)*fd
acc = -(0.5*X(M)*uu*uu + X(V))/M
sys = [(d, fe*uu), (e, -fd*uu), (uu, acc)]
A_ = [d, e, uu]
def main():
    x0 = [0.0, 0.0, 0.0]; val = lambda s, es: evaluate(es, A_, s)
    x = taylor(sys, x0, TIMES, 1e-18); y = taylor(sys, x0, TIMES, 1e-15)
    TV = [0.5*M*uu*uu, V]; T0, V0 = val(x0, TV); P3v = [ddt(p, q, [t*uu for t in tang]) for p in joints[3]]
    vals = []; drift = clo = 0
    for k, t in enumerate(TIMES):
        Tk, Vk = val(x[k], TV); drift = max(drift, abs(float(Tk+Vk-T0-V0))); clo = max(clo, float(np.max(np.abs(val(x[k], closure)))))
        vals.append(dict(t=t, P3=val(x[k], joints[3]), P3_velocity=val(x[k], P3v), P1=val(x[k], joints[1]), P2=val(x[k], joints[2]), P4=val(x[k], joints[4]),
                         d=x[k][0], e=x[k][1], rates=val(x[k], [fe*uu, -fd*uu]), kinetic=Tk, potential=Vk, energy=Tk+Vk))
    # closure all along (sampled) and the range of the angles
    smp = taylor(sys, x0, [0.05*i for i in range(1, 101)], 1e-15); rng = [float(min(s[0] for s in smp)), float(max(s[0] for s in smp)), float(min(s[1] for s in smp)), float(max(s[1] for s in smp))]
    clo = max([clo] + [float(np.max(np.abs(val(s, closure)))) for s in smp])
    # second
    half = [0.5*np.array(v) for v in DIR]; cons = []
    perp = {0: [1, 2], 1: [0, 2], 2: [0, 1]}
    for k in range(6):
        A, B = k-1, (k if k < 5 else -1)
        a = half[A] if A >= 0 else np.array(PTS[0], float); b = -half[B] if B >= 0 else np.array(PTS[5], float)
        cons.append(('ball', A, list(a), B, list(b))); i = int(np.argmax(AXES[k]))
        for o in perp[i]: cons.append(('perp', A, list(np.eye(3)[o]), B, AXES[k]))
    S = Absolute([(MASS, J) for J in JB], cons, g=GV)
    y0 = state([np.array(PTS[k], float)+half[k] for k in range(5)], [np.eye(3)]*5, np.zeros((5, 3)), np.zeros((5, 3)))
    a0 = S.acc(0, y0); mine0 = float(val(x0, [acc])[0]); tang0 = val(x0, tang)
    ddd, dee = mine0*float(tang0[0]), mine0*float(tang0[1])
    dA = abs(a0[4]-ddd)
    ab = S.run(y0, TIMES); other = []
    for k in range(len(TIMES)):
        r, R_, v, w = S.split(ab[k]); other.append(maxdiff(r[2]+R_[2] @ half[2], vals[k]['P3']))
    E = [sum(S.energy(s)) for s in ab]
    out = dict(parameters=dict(mass=MASS, J_transversal=JT, J_along=JA, points=PTS, axes_at_start=AXES, g=GV),
               start=dict(at_rest=True, accelerations_d_e=[ddd, dee], P3=PTS[3], P3_acceleration=(a0[12:15] + np.cross(a0[15:18], half[2])), kinetic=0.0, potential=V0, energy=V0), values=vals,
               accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, y)), second_formulation_P3=other, second_formulation_energy=max(abs(z-float(V0)) for z in E),
                             second_formulation_evaluations=S.nfev, energy_absolute=drift, closure=clo, start_acceleration_difference=dA, range_d_e=rng))
    store('4_bricard', out); print(out['accuracy']); print(out['start'])
    for v in vals: print(v)
if __name__ == '__main__': main()
