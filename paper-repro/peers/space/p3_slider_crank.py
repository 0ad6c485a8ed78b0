"""3. Spatial slider-crank.  Crank: revolute about world x at A = (0, 0.1, 0.12), angle th about +x, th = 0 points along +z:
   B = A + 0.08 (0, -sin th, cos th).   Slider S = (x, 0, 0), x > 0, |S - B| = 0.3:  x = sqrt(0.09 - By^2 - Bz^2).
Rod: centre halfway between B and S, line n = (S - B)/0.3.
 ball-ball : spin along n zero at the start, hence always (axisymmetric, no moment about n): omega = n x n'.
 universal : ball at B, universal joint at S: slider axis e = z, rod axis f perpendicular to n and e, f = e x n/|e x n|
             (the rod's spin along n is then s = f'.(n x f), imposed by the joint).
Crank tensor about its centre, own frame x = rotation axis, z = along the crank: diag(1e-4, 1e-4, 1e-5); centre at distance c from A.
First: Lagrange in th alone; second: absolute coordinates."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

A = [0.0, 0.1, 0.12]; RC, L = 0.08, 0.3
MC, MR, MS = 0.12, 0.5, 2.0
JC = [1e-4, 1e-4, 1e-5]                # crank, own frame (x rotation axis, z along the crank), about its centre
JT, JA = 4e-3, 4e-4                    # rod transversal, along itself, about its centre
JS = [1e-3, 1e-3, 1e-3]                # slider (does not rotate: no effect)
RATE = 6.0; TIMES = [0.25, 0.5, 1.0]
th = hk.make_vars("th"); q = [th]; u = [hk.make_vars("w")]
B = [ex(A[0]), A[1] - LD(RC)*hk.sin(th), A[2] + LD(RC)*hk.cos(th)]
xs = hk.sqrt(LD(L)**2 - B[1]*B[1] - B[2]*B[2]); S_ = [xs, ex(0), ex(0)]
n = [(s - b)/LD(L) for s, b in zip(S_, B)]
e = [ex(0), ex(0), ex(1)]
vB, vS = velocity(B, q, u), velocity(S_, q, u); vm = scale(0.5, add(vB, vS)); dn = velocity(n, q, u)
en = cross(e, n); f = [x/hk.sqrt(dot(en, en)) for x in en]
spin = dot(velocity(f, q, u), cross(n, f))
def system(c, grav, universal):
    T = (0.5*(LD(MC)*LD(c)**2 + LD(JC[0]))*u[0]**2 + 0.5*LD(MR)*dot(vm, vm) + 0.5*LD(JT)*dot(dn, dn) + 0.5*LD(MS)*vS[0]**2)
    if universal: T = T + 0.5*LD(JA)*spin**2
    V = LD(grav)*(LD(MC)*(A[2] + LD(c)*hk.cos(th)) + 0.5*LD(MR)*B[2])
    acc = lagrange(q, u, T, V, [0.])
    return [(th, u[0]), (u[0], acc[0])], T, V
V_ = q + u
def variant(c, grav, universal):
    sys, T, V = system(c, grav, universal); x0 = [0.0, RATE]
    x = taylor(sys, x0, TIMES, 1e-18); y = taylor(sys, x0, TIMES, 1e-15); val = lambda s, es: evaluate(es, V_, s)
    T0, V0 = val(x0, [T, V]); vals = []; drift = 0
    for k, t in enumerate(TIMES):
        Tk, Vk = val(x[k], [T, V]); o = val(x[k], [xs, vS[0]]); drift = max(drift, abs(float(Tk+Vk-T0-V0)))
        vals.append(dict(t=t, crank=x[k][0], crank_rate=x[k][1], slider=o[0], slider_rate=o[1], B=val(x[k], B), kinetic=Tk, potential=Vk, energy=Tk+Vk))
    # second formulation
    fl = lambda z: np.array(val(x0, z), float)
    Bn, Sn, nn, dnn, fn, vBn, vSn = map(fl, (B, S_, n, dn, f, vB, vS)); sp = float(val(x0, [spin])[0]) if universal else 0.0
    cons = [('ball', 0, [0, 0, -c], -1, A), ('perp', 0, [0, 1, 0], -1, [1, 0, 0]), ('perp', 0, [0, 0, 1], -1, [1, 0, 0]),
            ('ball', 1, [-L/2, 0, 0], 0, [0, 0, RC-c]), ('ball', 1, [L/2, 0, 0], 2, [0, 0, 0]),
            ('plane', 2, [0, 0, 0], -1, [0, 0, 0], [0, 1, 0]), ('plane', 2, [0, 0, 0], -1, [0, 0, 0], [0, 0, 1]),
            ('perp', 2, [0, 1, 0], -1, [1, 0, 0]), ('perp', 2, [0, 0, 1], -1, [1, 0, 0]), ('perp', 2, [0, 1, 0], -1, [0, 0, 1])]
    if universal: cons.append(('perp', 1, [0, 1, 0], 2, [0, 0, 1]))
    S = Absolute([(MC, np.diag(JC)), (MR, np.diag([JA, JT, JT])), (MS, np.diag(JS))], cons, g=(0, 0, -grav))
    Rk = np.column_stack([nn, fn, np.cross(nn, fn)]); W = np.cross(nn, dnn) + sp*nn; ux = np.array([1., 0, 0])
    rc = np.array(A) + np.array([0, 0, c])
    y0 = state([rc, (Bn+Sn)/2, Sn], [np.eye(3), Rk, np.eye(3)], [np.cross(RATE*ux, [0, 0, c]), (vBn+vSn)/2, vSn], [RATE*ux, Rk.T @ W, np.zeros(3)])
    assert S.residual(y0) < 1e-13
    acc0 = val(x0, [sys[1][1]])[0]; dA = abs(float(acc0)-S.acc(0, y0)[3]); ab = S.run(y0, TIMES); other = 0
    for k in range(len(TIMES)):
        r, R, v, w = S.split(ab[k]); a = np.arctan2(R[0][2, 1], R[0][1, 1]); a += 2*np.pi*np.round((float(x[k][0])-a)/2/np.pi)
        other = max(other, maxdiff([a, w[0][0], r[2][0], v[2][0]], [vals[k]['crank'], vals[k]['crank_rate'], vals[k]['slider'], vals[k]['slider_rate']]))
    return dict(crank_centre_from_A=c, g=[0, 0, -grav], rod_slider='universal' if universal else 'ball', values=vals,
                start=dict(crank=0.0, crank_rate=RATE, slider=Sn[0], slider_rate=vSn[0], B=Bn, rod_omega_world=W, rod_velocity=(vBn+vSn)/2,
                           kinetic=T0, potential=V0, energy=T0+V0, crank_acceleration=acc0),
                accuracy=dict(two_tolerances=max(maxdiff(i, j) for i, j in zip(x, y)), second_formulation=other, energy_absolute=drift, start_acceleration_difference=dA))
if __name__ == '__main__':
    out = dict(parameters=dict(A=A, crank_length=RC, rod_length=L, mass_crank=MC, mass_rod=MR, mass_slider=MS, J_crank_diag=JC,
               J_rod_diag_x_along=[JA, JT, JT], J_slider_diag=JS))
    for name, c, g, uni in (('no_gravity', 0.04, 0.0, False), ('gravity', 0.04, G, False), ('no_gravity_centre_at_A', 0.0, 0.0, False),
                            ('gravity_centre_at_A', 0.0, G, False), ('gravity_universal', 0.04, G, True), ('no_gravity_universal', 0.04, 0.0, True)):
        out[name] = variant(c, g, uni); v = out[name]['values'][-1]
        print(name, out[name]['accuracy'], v['crank'], v['crank_rate'], v['slider'])
    store('3_slider_crank', out)
