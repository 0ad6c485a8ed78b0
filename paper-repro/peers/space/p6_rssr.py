"""6. RSSR four-bar.  Crank: revolute about world z at the origin, B = 0.2 (cos a, sin a, 0).
Rocker: revolute about world y through P = (0.5, 0.1, 0.3), C = P + 0.5 (-sin b, 0, -cos b)  (R = Ry(b), b about +y,
b = 0 hangs straight down).  Coupler: ball joints at B and C, length L = 0.6, |C - B| = L.
All centres at half length.  Coupler axisymmetric: no moment acts about its own line, so its spin along its line stays
the initial one, zero: omega = n x n'.
Closure solved for the rocker angle:  with D = P - B:  Dx sin b + Dz cos b = -(L^2 - |D|^2 - 0.25)/(2*0.5),
   b = atan2(Dx, Dz) - acos(rhs / sqrt(Dx^2 + Dz^2)).
First: Lagrange in the crank angle alone; second: absolute coordinates."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

RC, RR, L0 = 0.2, 0.5, 0.6
P = [0.5, 0.1, 0.3]
MC, MK, MR = 0.3, 0.8, 0.6                      # crank, coupler, rocker
JC, JK0, JR = MC*RC**2/12, MK*L0**2/12, MR*RR**2/12
JAX = 1e-5                                      # every rod along itself
TORQUE, DAMP = 0.5, 0.05
A0, RATE0 = 0.5, 2.0
TIMES = [0.25, 0.5]
a = hk.make_vars("a"); q = [a]; u = [hk.make_vars("ua")]; work = hk.make_vars("work")

def system(torque, L, JK):
    B = [LD(RC)*hk.cos(a), LD(RC)*hk.sin(a), ex(0)]
    D = [ex(P[i]) - B[i] for i in range(3)]
    rhs = -(L*L - dot(D, D) - LD(RR)**2)/(2*LD(RR))
    b = hk.atan2(D[0], D[2]) - hk.acos(rhs/hk.sqrt(D[0]*D[0] + D[2]*D[2]))
    C = [P[0] - LD(RR)*hk.sin(b), ex(P[1]), P[2] - LD(RR)*hk.cos(b)]
    vB, vC = velocity(B, q, u), velocity(C, q, u); ub = ddt(b, q, u)
    vm = scale(0.5, add(vB, vC)); dn = sub(vC, vB)
    T = (0.5*(LD(MC)*LD(RC)**2/4 + LD(JC))*u[0]**2 + 0.5*(LD(MR)*LD(RR)**2/4 + LD(JR))*ub**2
         + 0.5*LD(MK)*dot(vm, vm) + 0.5*JK*dot(dn, dn)/(L*L))
    V = LD(G)*(LD(MK)*0.5*(B[2] + C[2]) + LD(MR)*0.5*(LD(P[2]) + C[2]))
    Q = [torque - LD(DAMP)*u[0]]
    acc = lagrange(q, u, T, V, Q)
    return [(a, u[0]), (u[0], acc[0]), (work, Q[0]*u[0])], T, V, b, ub, B, C
def fixed(): return system(hk.par[0], hk.par[1], ex(JK0))
def follow(): return system(hk.par[0], hk.par[1], LD(MK)*hk.par[1]**2/LD(12))
P0 = [TORQUE, L0]; V_ = [a] + u

def outputs(b, ub): return [a, b, u[0], ub]
def main():
    x0 = [A0, RATE0, 0.0]; res = {}; wt = wr = 0
    for name, make in (('tensor_fixed', fixed), ('tensor_follows', follow)):
        sys, T, V, b, ub, B, C = make()
        x, S = taylor(sys, x0, TIMES, 1e-18, P0, var=True); y = taylor(sys, x0, TIMES, 1e-15, P0)
        wt = max(wt, max(maxdiff(i, j) for i, j in zip(x, y)))
        out = outputs(b, ub); D = []
        for k in range(len(TIMES)):     # d out/d par = d out/d x * S + explicit
            Jx = evaluate([hk.diff(o, v) for o in out for v in V_], V_, x[k][:2], P0).reshape(4, 2)
            Jp = evaluate([hk.diff(o, hk.par[j]) for o in out for j in range(2)], V_, x[k][:2], P0).reshape(4, 2)
            D.append(Jx @ S[k][:2] + Jp)
        for j in range(2):
            E = []
            for h in (1e-3, 5e-4, 2.5e-4):
                o = []
                for s in (1, -1):
                    pp = [LD(p) for p in P0]; pp[j] += s*LD(h)*LD(P0[j]); xs = taylor(sys, x0, TIMES, 1e-19, pp)
                    o.append((pp[j], [evaluate(out, V_, z[:2], pp) for z in xs]))
                E.append(np.array([(i-k)/(o[0][0]-o[1][0]) for i, k in zip(o[0][1], o[1][1])]))
            r1 = (4*E[1]-E[0])/3; r2 = (4*E[2]-E[1])/3; r = (16*r2-r1)/15
            wr = max(wr, max(maxdiff(r[k], D[k][:, j])/float(np.max(np.abs(D[k][:, j]))) for k in range(len(TIMES))))
        res[name] = dict(sys=sys, T=T, V=V, out=out, B=B, C=C, x=x, D=D)
    F = res['tensor_fixed']; x = F['x']; sys = F['sys']
    val = lambda s, es: evaluate(es, V_, s[:2], P0)
    T0, V0 = val(x0, [F['T'], F['V']]); o0 = val(x0, F['out']); B0 = val(x0, F['B']); C0 = val(x0, F['C'])
    vals = []; bal = 0
    for k, t in enumerate(TIMES):
        o = val(x[k], F['out']); Tk, Vk = val(x[k], [F['T'], F['V']]); bal = max(bal, abs(float(Tk+Vk-T0-V0-x[k][2])))
        vals.append(dict(t=t, crank=o[0], rocker=o[1], crank_rate=o[2], rocker_rate=o[3], B=val(x[k], F['B']), C=val(x[k], F['C']),
                         kinetic=Tk, potential=Vk, energy=Tk+Vk, work=x[k][2]))
    # second formulation
    nz = np.array([0, 0, 1.0])
    def loads(t, r, R, v, w):
        Mz = TORQUE - DAMP*(R[0] @ w[0])[2]
        return [np.zeros(3)]*3, [R[0].T @ (Mz*nz), np.zeros(3), np.zeros(3)]
    S = Absolute([(MC, np.diag([JAX, JC, JC])), (MK, np.diag([JAX, JK0, JK0])), (MR, np.diag([JR, JR, JAX]))],
        [('ball', 0, [-RC/2, 0, 0], -1, [0, 0, 0]), ('perp', 0, [1, 0, 0], -1, [0, 0, 1]), ('perp', 0, [0, 1, 0], -1, [0, 0, 1]),
         ('ball', 1, [-L0/2, 0, 0], 0, [RC/2, 0, 0]), ('ball', 1, [L0/2, 0, 0], 2, [0, 0, -RR/2]),
         ('ball', 2, [0, 0, RR/2], -1, P), ('perp', 2, [1, 0, 0], -1, [0, 1, 0]), ('perp', 2, [0, 0, 1], -1, [0, 1, 0])], loads)
    f = lambda z: np.array(z, float)
    B, C = f(B0), f(C0); al, be, ua, ub = f(o0)
    Ra = np.array(rot_z(al, np.cos, np.sin)); Rr = np.array(rot_y(be, np.cos, np.sin))
    n = (C-B)/L0; e2 = np.cross(nz, n); e2 /= np.linalg.norm(e2); Rk = np.column_stack([n, e2, np.cross(n, e2)])
    vB = np.cross(ua*nz, B); wy = np.array([0, ub, 0]); vC = np.cross(wy, C-np.array(P)); dn = (vC-vB)/L0; Wk = np.cross(n, dn)
    y0 = state([B/2, (B+C)/2, (np.array(P)+C)/2], [Ra, Rk, Rr], [vB/2, (vB+vC)/2, vC/2], [Ra.T @ (ua*nz), Rk.T @ Wk, Rr.T @ wy])
    assert S.residual(y0) < 1e-13
    A = S.acc(0, y0); acc0 = val(x0, [sys[1][1]])[0]
    ab = S.run(y0, TIMES); other = 0
    for k in range(len(TIMES)):
        r, R, v, w = S.split(ab[k]); o = val(x[k], F['out'])
        mine = [np.arctan2(R[0][1, 0], R[0][0, 0]), np.arctan2(R[2][0, 2], R[2][0, 0]), (R[0] @ w[0])[2], (R[2] @ w[2])[1]]
        mine[0] += 2*np.pi*np.round((float(o[0])-mine[0])/(2*np.pi)); other = max(other, maxdiff(mine, o))
    e = dict(parameters=dict(crank=dict(mass=MC, length=RC, J_diag=[JAX, JC, JC]), coupler=dict(mass=MK, length=L0, J_diag=[JAX, JK0, JK0]),
             rocker=dict(mass=MR, length=RR, J_diag=[JR, JR, JAX]), rocker_point=P, torque=TORQUE, damping=DAMP, g=[0, 0, -G]),
             start=dict(crank=o0[0], rocker=o0[1], crank_rate=o0[2], rocker_rate=o0[3], B=B0, C=C0, coupler_omega_world=Wk, kinetic=T0, potential=V0,
                        energy=T0+V0, crank_acceleration=acc0), values=vals,
             derivatives=dict(order='[crank, rocker, crank_rate, rocker_rate]', held='start: crank angle and crank rate',
               **{n: [dict(t=t, by_torque=res[n]['D'][k][:, 0], by_coupler_length=res[n]['D'][k][:, 1]) for k, t in enumerate(TIMES)] for n in res}),
             accuracy=dict(two_tolerances=wt, second_formulation=other, start_acceleration_difference=abs(float(acc0)-A[5]), power_balance=bal,
                           derivatives_vs_richardson_relative=wr))
    store('6_rssr', e); print(e['accuracy']); print(e['start']); print(vals); print(e['derivatives'])
if __name__ == '__main__': main()
