"""7. Furuta pendulum.  Arm: revolute about world z at the origin, angle a (counter-clockwise), arm along its x axis.
Pendulum: revolute at the arm's end about the arm's x axis, angle b about +x; b = 0 hangs straight down.
Its own frame: z axis along the rod (upwards from the free end to the joint when b = 0); R_pendulum = Rz(a) Rx(b);
rod centre at R (0,0,-l/2) from the joint.  First: Lagrange, second: absolute coordinates, third: pinocchio."""
import numpy as np, heyoka as hk
from common import *
from absolute import Absolute, state

ARM_M, ARM_L, ARM_J = 0.4, 0.3, 0.003       # J about the vertical through the arm's centre (at half length)
PEN_M, PEN_L, PEN_JAX = 0.15, 0.25, 1e-5    # J transversal = m l^2 / 12, along the rod 1e-5
DAMP_A, DAMP_B = 0.002, 0.002
TORQ, FREQ = 0.05, 3.0                      # torque 0.05 sin(3 t) on the arm about z (reaction on the ground)
PEN_J = PEN_M*PEN_L**2/12
START = [0.0, 0.4, 0.0, 0.0]                # a, b, a', b'
TIMES = [0.5, 1.0]

q = hk.make_vars("a", "b"); u = hk.make_vars("ua", "ub"); work = hk.make_vars("work")
a, b = q

def system(l, ma, Jp, Ja):
    """l pendulum length, ma arm mass, Jp transversal tensor of the pendulum, Ja arm tensor"""
    R1 = rot_z(a); R2 = matmul(R1, rot_x(b))
    p1 = matvec(R1, [ARM_L/2, 0., 0.])
    end = matvec(R1, [ARM_L, 0., 0.])
    p2 = add(end, matvec(R2, [0., 0., -0.5*l]))
    v1 = velocity(p1, q, u)
    T = 0.5*ma*dot(v1, v1) + 0.5*Ja*u[0]**2
    v2 = velocity(p2, q, u); w2 = omega_body(R2, q, u)
    T = T + 0.5*LD(PEN_M)*dot(v2, v2) + 0.5*(Jp*w2[0]**2 + Jp*w2[1]**2 + LD(PEN_JAX)*w2[2]**2)
    V = LD(PEN_M)*LD(G)*p2[2]
    tau = LD(TORQ)*hk.sin(LD(FREQ)*hk.time)
    Q = [tau - LD(DAMP_A)*u[0], -LD(DAMP_B)*u[1]]
    acc = lagrange(q, u, T, V, Q)
    sys = [(q[0], u[0]), (q[1], u[1]), (u[0], acc[0]), (u[1], acc[1]), (work, Q[0]*u[0] + Q[1]*u[1])]
    return sys, T, V, p2

def fixed():   # tensors keep their values when length or mass change (the centres stay at half length)
    return system(hk.par[0], hk.par[1], ex(PEN_J), ex(ARM_J))
def scaled():  # tensors follow m l^2 / 12
    return system(hk.par[0], hk.par[1], LD(PEN_M)*hk.par[0]**2/LD(12), hk.par[1]*LD(ARM_L)**2/LD(12))

P0 = [PEN_L, ARM_M]
def main():
    e = dict(parameters=dict(arm=dict(mass=ARM_M, length=ARM_L, J_vertical_centre=ARM_J),
             pendulum=dict(mass=PEN_M, length=PEN_L, J_diag=[PEN_J, PEN_J, PEN_JAX]), damping=[DAMP_A, DAMP_B],
             torque='0.05*sin(3*t)', g=[0, 0, -G]), order='[a, b, a_rate, b_rate]')
    sens = {}; first = None; worst_tol = 0; worst_fd = 0
    for name, make in (('tensors_fixed', fixed), ('tensors_follow', scaled)):
        sys, T, V, p2 = make()
        x0 = START + [0.0]
        x, S = taylor(sys, x0, TIMES, 1e-18, P0, var=True)
        y, S2 = taylor(sys, x0, TIMES, 1e-15, P0, var=True)
        worst_tol = max(worst_tol, max(maxdiff(i, j) for i, j in zip(x, y)))
        tolS = max(maxdiff(i, j) for i, j in zip(S, S2))
        # check of the variational derivatives: central differences with Richardson
        for j in range(2):
            D = []
            for h in (1e-3, 5e-4, 2.5e-4):
                P = [LD(p) for p in P0]; P[j] += LD(h)*LD(P0[j]); pl = taylor(sys, x0, TIMES, 1e-19, P)
                N = [LD(p) for p in P0]; N[j] -= LD(h)*LD(P0[j]); mi = taylor(sys, x0, TIMES, 1e-19, N)
                D.append(np.array([(i-k)/(P[j]-N[j]) for i, k in zip(pl, mi)]))
            r1 = (4*D[1]-D[0])/3; r2 = (4*D[2]-D[1])/3; r = (16*r2-r1)/15
            worst_fd = max(worst_fd, max(maxdiff(r[k][:4], S[k][:4, j])/np.max(np.abs(S[k][:4, j])).astype(float) for k in range(len(TIMES))))
        sens[name] = [dict(t=t, by_pendulum_length=S[k][:4, 0], by_arm_mass=S[k][:4, 1]) for k, t in enumerate(TIMES)]
        sens[name+'_two_tolerances'] = tolS
        if first is None: first = (sys, T, V, p2, x)
    sys, T, V, p2, x = first
    allv = q + u
    en = lambda s: evaluate([T, V], allv, s[:4], P0)
    T0, V0 = en(START)
    vals = []; bal = 0
    for k, t in enumerate(TIMES):
        Tk, Vk = en(x[k]); bal = max(bal, abs(float(Tk+Vk-T0-V0-x[k][4])))
        vals.append(dict(t=t, a=x[k][0], b=x[k][1], a_rate=x[k][2], b_rate=x[k][3], kinetic=Tk, potential=Vk, energy=Tk+Vk, work=x[k][4],
                         pendulum_centre=evaluate(p2, allv, x[k][:4], P0)))
    # second formulation
    def loads(t, r, R, v, w):
        tau = TORQ*np.sin(FREQ*t); w0 = R[0] @ w[0]; w1 = R[1] @ w[1]
        ex_ = R[0][:, 0]; rel = (w1-w0) @ ex_
        M0 = np.array([0, 0, tau - DAMP_A*w0[2]]) + DAMP_B*rel*ex_; M1 = -DAMP_B*rel*ex_
        return [np.zeros(3)]*2, [R[0].T @ M0, R[1].T @ M1]
    S = Absolute([(ARM_M, np.diag([1e-5, ARM_J, ARM_J])), (PEN_M, np.diag([PEN_J, PEN_J, PEN_JAX]))],
        [('ball', 0, [-ARM_L/2, 0, 0], -1, [0, 0, 0]), ('perp', 0, [1, 0, 0], -1, [0, 0, 1]), ('perp', 0, [0, 1, 0], -1, [0, 0, 1]),
         ('ball', 1, [0, 0, PEN_L/2], 0, [ARM_L/2, 0, 0]), ('perp', 1, [0, 1, 0], 0, [1, 0, 0]), ('perp', 1, [0, 0, 1], 0, [1, 0, 0])], loads)
    Rb = np.array(rot_x(0.4, np.cos, np.sin))
    y0 = state([np.array([ARM_L/2, 0, 0]), np.array([ARM_L, 0, 0]) + Rb @ [0, 0, -PEN_L/2]], [np.eye(3), Rb], np.zeros((2, 3)), np.zeros((2, 3)))
    ab = S.run(y0, TIMES); other = 0
    for k in range(len(TIMES)):
        r, R, v, w = S.split(ab[k])
        B = R[0].T @ R[1]
        mine = [np.arctan2(R[0][1, 0], R[0][0, 0]), np.arctan2(B[2, 1], B[1, 1]), (R[0] @ w[0])[2], (R[1] @ w[1]-R[0] @ w[0]) @ R[0][:, 0]]
        other = max(other, maxdiff(mine, x[k][:4]))
    # pinocchio: accelerations along the way
    import pinocchio as pin
    mod = pin.Model(); I3 = np.eye(3)
    j = mod.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), 'arm')
    mod.appendBodyToJoint(j, pin.Inertia(ARM_M, np.array([ARM_L/2, 0, 0]), np.diag([1e-5, ARM_J, ARM_J])), pin.SE3.Identity())
    j = mod.addJoint(j, pin.JointModelRX(), pin.SE3(I3, np.array([ARM_L, 0, 0])), 'pen')
    mod.appendBodyToJoint(j, pin.Inertia(PEN_M, np.array([0, 0, -PEN_L/2]), np.diag([PEN_J, PEN_J, PEN_JAX])), pin.SE3.Identity())
    dat = mod.createData(); mod.gravity.linear = np.array([0, 0, -G]); wp = 0
    for t, s in [(0.0, np.array(START))] + list(zip(TIMES, x)):
        s = np.array(s, float)
        al = pin.aba(mod, dat, s[:2], s[2:4], np.array([TORQ*np.sin(FREQ*t)-DAMP_A*s[2], -DAMP_B*s[3]]))
        mine = evaluate([sys[2][1], sys[3][1]], allv, s[:4], P0, t); wp = max(wp, maxdiff(al, mine))
        if t == 0: acc0 = mine
    e['start'] = dict(a=0.0, b=0.4, a_rate=0.0, b_rate=0.0, kinetic=T0, potential=V0, energy=T0+V0, accelerations=acc0)
    e['values'] = vals; e['derivatives'] = sens
    e['accuracy'] = dict(two_tolerances=worst_tol, second_formulation=other, power_balance=bal, pinocchio_acceleration=wp,
                         derivatives_vs_richardson_relative=worst_fd)
    store('7_furuta', e)
    print(e['accuracy']); print(vals[-1]); print(sens)
if __name__ == '__main__': main()
