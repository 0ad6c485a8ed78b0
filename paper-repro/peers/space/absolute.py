"""Second formulation: Newton-Euler in absolute coordinates, constraints at acceleration level (index 1).

Each body has centre r (world), unit quaternion p=(w,x,y,z) (R(p) maps body to world), velocity v (world),
angular velocity w (BODY axes).   m v' = F + Phi_v^T l,   J w' + w x J w = M + Phi_w^T l,   Phi'' = 0.
Solved by least squares for l, so redundant but consistent constraints are allowed.
Body number -1 is the ground.
"""
import numpy as np
from scipy.integrate import solve_ivp

def sk(a): return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0.]])
def cr(a, b):
    return np.array([a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0]])
def rot(p):
    w, x, y, z = p / np.sqrt(p @ p)
    return np.array([[w*w+x*x-y*y-z*z, 2*(x*y-w*z), 2*(x*z+w*y)],
                     [2*(x*y+w*z), w*w-x*x+y*y-z*z, 2*(y*z-w*x)],
                     [2*(x*z-w*y), 2*(y*z+w*x), w*w-x*x-y*y+z*z]])
def quat(R):
    """unit quaternion of a rotation matrix"""
    K = np.array([[R[0,0]+R[1,1]+R[2,2], R[2,1]-R[1,2], R[0,2]-R[2,0], R[1,0]-R[0,1]],
                  [R[2,1]-R[1,2], R[0,0]-R[1,1]-R[2,2], R[0,1]+R[1,0], R[0,2]+R[2,0]],
                  [R[0,2]-R[2,0], R[0,1]+R[1,0], R[1,1]-R[0,0]-R[2,2], R[1,2]+R[2,1]],
                  [R[1,0]-R[0,1], R[0,2]+R[2,0], R[1,2]+R[2,1], R[2,2]-R[0,0]-R[1,1]]])
    w, v = np.linalg.eigh(K); p = v[:, -1]
    return p if p[0] >= 0 else -p

class Absolute:
    def __init__(self, bodies, constraints, loads=None, g=(0, 0, -9.81)):
        """bodies: list of (mass, tensor); constraints: list of
        ('ball', A, a, B, b)     points a of A and b of B (from the centres, body axes) coincide  (3)
        ('perp', A, a, B, b)     (R_A a).(R_B b) stays constant  (1)
        ('plane', A, a, B, b, n) (x_A(a) - x_B(b)) . R_B n stays constant  (1)
        loads(t, r, R, v, w) -> forces (world) and moments (body), lists of arrays"""
        self.m = [float(b[0]) for b in bodies]; self.J = [np.array(b[1], float) for b in bodies]
        self.nb = len(bodies); self.cons = constraints; self.loads = loads; self.g = np.array(g, float)
        self.Minv = np.zeros((6*self.nb, 6*self.nb))
        for i in range(self.nb):
            self.Minv[6*i:6*i+3, 6*i:6*i+3] = np.eye(3)/self.m[i]
            self.Minv[6*i+3:6*i+6, 6*i+3:6*i+6] = np.linalg.inv(self.J[i])
    def split(self, y):
        y = np.asarray(y).reshape(self.nb, 13)
        return y[:, 0:3], [rot(p) for p in y[:, 3:7]], y[:, 7:10], y[:, 10:13]
    def rows(self, r, R, v, w):
        """constraint Jacobian (in v, w) and -(d/dt Jacobian) u"""
        n = 6*self.nb; J = []; c = []
        I = np.eye(3); Z = np.zeros(3)
        def pt(i, s):      # point, velocity, w x (w x s), world
            s = np.array(s, float)
            if i < 0: return s, Z, Z
            ws = cr(w[i], s)
            return r[i] + R[i] @ s, v[i] + R[i] @ ws, R[i] @ cr(w[i], ws)
        def vec(i, a):     # direction, rate, quadratic part of second rate
            a = np.array(a, float)
            if i < 0: return a, Z, Z
            wa = cr(w[i], a)
            return R[i] @ a, R[i] @ wa, R[i] @ cr(w[i], wa)
        for k in self.cons:
            if k[0] == 'ball':
                _, A, a, B, b = k
                row = np.zeros((3, n)); _, _, qa = pt(A, a); _, _, qb = pt(B, b)
                if A >= 0: row[:, 6*A:6*A+3] += I; row[:, 6*A+3:6*A+6] -= R[A] @ sk(a)
                if B >= 0: row[:, 6*B:6*B+3] -= I; row[:, 6*B+3:6*B+6] += R[B] @ sk(b)
                J.append(row); c.append(qb - qa)
            elif k[0] == 'perp':
                _, A, a, B, b = k
                row = np.zeros((1, n)); xa, da, qa = vec(A, a); xb, db, qb = vec(B, b)
                if A >= 0: row[0, 6*A+3:6*A+6] -= xb @ R[A] @ sk(a)
                if B >= 0: row[0, 6*B+3:6*B+6] -= xa @ R[B] @ sk(b)
                J.append(row); c.append(np.array([-(qa @ xb + 2*da @ db + xa @ qb)]))
            else:
                _, A, a, B, b, nn = k
                row = np.zeros((1, n)); pa, va, qa = pt(A, a); pb, vb, qb = pt(B, b); x, dx, qx = vec(B, nn)
                d, vd = pa - pb, va - vb
                if A >= 0: row[0, 6*A:6*A+3] += x; row[0, 6*A+3:6*A+6] -= x @ R[A] @ sk(a)
                if B >= 0:
                    row[0, 6*B:6*B+3] -= x; row[0, 6*B+3:6*B+6] += x @ R[B] @ sk(b)
                    row[0, 6*B+3:6*B+6] -= d @ R[B] @ sk(nn)
                J.append(row); c.append(np.array([-((qa - qb) @ x + 2*vd @ dx + d @ qx)]))
        if not J: return np.zeros((0, n)), np.zeros(0)
        return np.vstack(J), np.concatenate(c)
    def acc(self, t, y):
        r, R, v, w = self.split(y)
        f = np.zeros(6*self.nb)
        for i in range(self.nb):
            f[6*i:6*i+3] = self.m[i]*self.g
            f[6*i+3:6*i+6] = -cr(w[i], self.J[i] @ w[i])
        if self.loads:
            F, M = self.loads(t, r, R, v, w)
            for i in range(self.nb):
                f[6*i:6*i+3] += F[i]; f[6*i+3:6*i+6] += M[i]
        A, c = self.rows(r, R, v, w)
        a0 = self.Minv @ f
        if len(c):
            S = A @ self.Minv @ A.T
            if not hasattr(self, 'full'): self.full = np.linalg.matrix_rank(S, tol=1e-9*np.abs(S).max()) == len(c)
            rhs = c - A @ a0
            if self.full:
                l = np.linalg.solve(S, rhs); l += np.linalg.solve(S, rhs - S @ l)
            else:
                U, s, Vt = np.linalg.svd(S); k = s > 1e-10*s[0]
                l = Vt[k].T @ ((U[:, k].T @ rhs) / s[k])
            a0 = a0 + self.Minv @ (A.T @ l)
        return a0
    def rhs(self, t, y):
        a = self.acc(t, y); y = y.reshape(self.nb, 13); d = np.zeros((self.nb, 13))
        for i in range(self.nb):
            p, w = y[i, 3:7], y[i, 10:13]
            d[i, 0:3] = y[i, 7:10]
            d[i, 3] = -0.5*(p[1]*w[0] + p[2]*w[1] + p[3]*w[2])
            d[i, 4] = 0.5*(p[0]*w[0] + p[2]*w[2] - p[3]*w[1])
            d[i, 5] = 0.5*(p[0]*w[1] + p[3]*w[0] - p[1]*w[2])
            d[i, 6] = 0.5*(p[0]*w[2] + p[1]*w[1] - p[2]*w[0])
            d[i, 7:10] = a[6*i:6*i+3]; d[i, 10:13] = a[6*i+3:6*i+6]
        return d.ravel()
    def energy(self, y):
        r, R, v, w = self.split(y)
        T = sum(0.5*self.m[i]*v[i] @ v[i] + 0.5*w[i] @ self.J[i] @ w[i] for i in range(self.nb))
        V = -sum(self.m[i]*self.g @ r[i] for i in range(self.nb))
        return T, V
    def residual(self, y):
        """velocity-level residual, for checking a start"""
        r, R, v, w = self.split(y); A, _ = self.rows(r, R, v, w)
        return np.max(np.abs(A @ np.hstack([v, w]).ravel())) if len(A) else 0.0
    def run(self, y0, times, rtol=1e-13, atol=1e-14):
        s = solve_ivp(self.rhs, (0, times[-1]), y0, method='DOP853', rtol=rtol, atol=atol, t_eval=times)
        assert s.success, s.message
        self.nfev = s.nfev
        return [s.y[:, k] for k in range(len(times))]

def state(r, R, v, w):
    return np.concatenate([np.concatenate([r[i], quat(np.array(R[i])), v[i], w[i]]) for i in range(len(r))]).astype(float)
