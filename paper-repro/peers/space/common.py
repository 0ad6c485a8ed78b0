"""Shared tools of the reference scripts.

lagrange(...)  : Lagrange's equations of the second kind in minimal coordinates, from expressions for
                 T(q,u), V(q), Q(q,u,t), built with heyoka's symbolic engine (differentiation only).
taylor(...)    : integrates them by an adaptive Taylor series in 80-bit long double.
store(...)     : merges a problem's entry into tests/data/space.json.
"""
import json, os, math
import numpy as np
import heyoka as hk

LD = np.longdouble
HERE = os.path.dirname(os.path.abspath(__file__))
G = 9.81

# ---------- small vector algebra that works for numbers and for symbolic expressions ----------
def add(a, b): return [x + y for x, y in zip(a, b)]
def sub(a, b): return [x - y for x, y in zip(a, b)]
def scale(s, a): return [s * x for x in a]
def dot(a, b): return sum((x * y for x, y in zip(a, b)), 0.0 * 0.0)
def cross(a, b):
    return [a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]]
def matvec(A, x): return [dot(r, x) for r in A]
def matmul(A, B): return [[dot(r, c) for c in zip(*B)] for r in A]
def transpose(A): return [list(r) for r in zip(*A)]
def rot_x(a, c=hk.cos, s=hk.sin):
    return [[1., 0., 0.], [0., c(a), -s(a)], [0., s(a), c(a)]]
def rot_y(a, c=hk.cos, s=hk.sin):
    return [[c(a), 0., s(a)], [0., 1., 0.], [-s(a), 0., c(a)]]
def rot_z(a, c=hk.cos, s=hk.sin):
    return [[c(a), -s(a), 0.], [s(a), c(a), 0.], [0., 0., 1.]]
EYE = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]

def ex(x): return x if isinstance(x, hk.expression) else hk.expression(LD(x))
def ddt(e, q, u):
    """time derivative of a function of q only"""
    e = ex(e)
    return sum((hk.diff(e, qi) * ui for qi, ui in zip(q, u)), hk.expression(LD(0)))
def velocity(p, q, u): return [ddt(x, q, u) for x in p]
def omega_body(R, q, u):
    """angular velocity in body axes, from  R^T dR/dt = skew(w)"""
    Rd = [[ddt(x, q, u) for x in r] for r in R]
    W = matmul(transpose(R), Rd)
    return [ex(W[2][1]), ex(W[0][2]), ex(W[1][0])]
def omega_world(R, q, u):
    Rd = [[ddt(x, q, u) for x in r] for r in R]
    W = matmul(Rd, transpose(R))
    return [ex(W[2][1]), ex(W[0][2]), ex(W[1][0])]
def kinetic(m, p, J, R, q, u):
    """kinetic energy of a body: mass m, centre p(q), tensor J about the centre in body axes, attitude R(q)"""
    v = velocity(p, q, u)
    T = 0.5 * ex(m) * dot(v, v) if m is not None else ex(0)
    if J is not None:
        w = omega_body(R, q, u)
        T = T + 0.5 * dot(w, matvec(J, w))
    return T

def lagrange(q, u, T, V, Q):
    """accelerations from d/dt dT/du - dT/dq + dV/dq = Q  (M u' = f, solved by symbolic elimination)"""
    n = len(q)
    T, V = ex(T), ex(V)
    p = [hk.diff(T, ui) for ui in u]
    M = [[hk.diff(p[i], u[j]) for j in range(n)] for i in range(n)]
    f = []
    for i in range(n):
        b = sum((hk.diff(p[i], q[j]) * u[j] for j in range(n)), hk.expression(LD(0)))
        f.append(ex(Q[i]) - b + hk.diff(T, q[i]) - hk.diff(V, q[i]))
    # Gauss elimination without exchange (M is positive definite)
    A = [row[:] + [f[i]] for i, row in enumerate(M)]
    for k in range(n):
        for i in range(k + 1, n):
            r = A[i][k] / A[k][k]
            A[i] = [A[i][j] - r * A[k][j] if j > k else A[i][j] for j in range(n + 1)]
    a = [None] * n
    for i in reversed(range(n)):
        s = A[i][n]
        for j in range(i + 1, n):
            s = s - A[i][j] * a[j]
        a[i] = s / A[i][i]
    return a

def taylor(sys, x0, times, tol, pars=(), var=False, maxsteps=0):
    """states (long double) at the given times (start 0). var: also first order sensitivities to pars:
    then the answer is (states, sens) with sens[k][i][j] = d x_i(t_k) / d par_j."""
    n = len(sys)
    s = hk.var_ode_sys(sys, hk.var_args.params, order=1) if var else sys
    ta = hk.taylor_adaptive(s, [LD(x) for x in x0], pars=[LD(p) for p in pars], tol=LD(tol),
                            fp_type=LD, compact_mode=True)
    out, sens = [], []
    for t in times:
        oc = ta.propagate_until(LD(t))
        assert oc[0] == hk.taylor_outcome.time_limit, oc
        out.append(np.array(ta.state[:n]))
        if var:
            S = np.zeros((n, len(pars)), dtype=LD)
            for i in range(n):
                for j in range(len(pars)):
                    mi = [0] * (len(pars)); mi[j] = 1
                    S[i, j] = ta.state[ta.get_vslice(order=1, component=i).start + j]
            sens.append(S)
    return (out, sens) if var else out

def evaluate(exprs, vars_, x, pars=None, t=None):
    """value of expressions at numbers, in long double"""
    cf = hk.cfunc([ex(e) for e in exprs], vars=vars_, fp_type=LD, compact_mode=True)
    kw = {}
    if cf.nparams: kw['pars'] = np.array([LD(p) for p in pars[:cf.nparams]], dtype=LD)
    if t is not None: kw['time'] = LD(t)
    return cf(np.array([LD(v) for v in x], dtype=LD), **kw)

# ---------- JSON ----------
def plain(x):
    if isinstance(x, dict): return {k: plain(v) for k, v in x.items()}
    if isinstance(x, (list, tuple)): return [plain(v) for v in x]
    if isinstance(x, np.ndarray): return [plain(v) for v in x]
    if isinstance(x, (np.floating,)): return float(x)
    if isinstance(x, (np.integer,)): return int(x)
    return x
def store(key, entry):
    path = os.path.join(HERE, '..', '..', '..', 'tests', 'data', 'space.json')
    d = json.load(open(path)) if os.path.exists(path) else {}
    d[key] = plain(entry)
    d = {k: d[k] for k in sorted(d)}
    with open(path + '.new', 'w') as f: json.dump(d, f, indent=1)
    os.replace(path + '.new', path)
def maxdiff(a, b): return float(np.max(np.abs(np.array(a, dtype=LD) - np.array(b, dtype=LD))))
