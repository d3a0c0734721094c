# SPDX-License-Identifier: LGPL-2.1-or-later
"""The formulas of SOFA's integrators, springs and elements on dense matrices: references that share no code with Stroma."""
import numpy as np


def conjugate_gradients(A, b, iterations, tolerance, threshold, first):
    x, r = np.zeros_like(b), b.copy()
    before = 0.0
    for k in range(1, iterations + 1):
        rho = r @ r
        if np.sqrt(rho) <= tolerance * np.linalg.norm(b) and not (first and k == 1):
            break
        p = r.copy() if k == 1 else r + rho / before * p
        q = A @ p
        if abs(p @ q) <= threshold and not (first and k == 1):
            break
        x, r, before = x + rho / (p @ q) * p, r - rho / (p @ q) * q, rho
    return x


def euler(x, mass, forces, steps, h, v=None, held=(), theta=1.0, rayleigh_mass=0.0, rayleigh_stiffness=0.0, cg=None,
          textbook=False):
    """forces(x, v) gives f and K = df/dx, shapes (n, 3) and (3n, 3n); mass: (n, n). Returns x after `steps`."""
    x = np.array(x, float)
    n = len(x)
    v = np.zeros_like(x) if v is None else np.array(v, float)
    M = np.kron(np.asarray(mass, float), np.eye(3))
    free = np.repeat([i not in held for i in range(n)], 3)
    for step in range(steps):
        f, K = forces(x, v)
        flat = v.ravel()
        b = h * (f.ravel() + (theta * h + rayleigh_stiffness) * K @ flat - rayleigh_mass * M @ flat)
        A = (1 + theta * h * rayleigh_mass) * M - theta * h * (theta * h + rayleigh_stiffness) * K
        b[~free] = 0
        dv = np.zeros(3 * n)
        if cg:
            P = np.diag(free.astype(float))
            dv = cg(P @ A @ P, b, step == 0) if callable(cg) else conjugate_gradients(P @ A @ P, b, *cg, first=step == 0)
        else:
            dv[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
        v = v + dv.reshape(-1, 3)
        x = x + h * (v - (1 - theta) * dv.reshape(-1, 3) if textbook else v)
    return x


def multistep(x, mass, forces, steps, h, order, held=(), rayleigh_mass=0.0, rayleigh_stiffness=0.0, iterations=1, rest_below=0.0):
    """Backward differentiation as SOFA has it: the first step is of order 1, and Newton's method begins at x + h v with v, and is
    over there where |r2| <= rest_below. The unknowns are velocities; the residual r1 of positions is taken into the equation of
    momentum."""
    x = np.array(x, float)
    n = len(x)
    v, older = np.zeros_like(x), None
    M = np.kron(np.diag(np.asarray(mass, float)), np.eye(3))
    free = np.repeat([i not in held for i in range(n)], 3)
    for _ in range(steps):
        share, w = (0.0, h) if order == 1 or older is None else (1 / 3, 2 * h / 3)
        way, change = (np.zeros_like(x), np.zeros_like(x)) if older is None else (x - older[0], v - older[1])
        x1, v1 = x + h * v, v.copy()
        for iteration in range(iterations):
            f, K = forces(x1, v1)
            force = f.ravel() - rayleigh_mass * M @ v1.ravel() + rayleigh_stiffness * K @ v1.ravel()
            r1 = (x1 - x - share * way - w * v1).ravel()
            r2 = M @ (v1 - v - share * change).ravel() - w * force
            if iteration == 0 and np.linalg.norm(r2[free]) <= rest_below:
                break
            A = (1 + w * rayleigh_mass) * M - w * (rayleigh_stiffness + w) * K
            r1[~free] = 0
            d = np.zeros(3 * n)
            d[free] = np.linalg.solve(A[np.ix_(free, free)], (-r2 - w * K @ r1)[free])
            v1, x1 = v1 + d.reshape(-1, 3), x1 + (w * d - r1).reshape(-1, 3)
        older, x, v = (x, v), x1, v1
    return x


def swept(W, g, blocks, l, most=1000, tolerance=1e-3, scaled=True, verified=False, sor=1.0, gradients=False,
          turns=()):
    """g + W l = 0 by SOFA's sweeps, with its ends. The blocks `turns` have a tolerance of 1e-4 of their own."""
    limit = tolerance * (len(g) if scaled and not verified else 1)

    def sweep(l):
        moved = []
        for number, block in enumerate(blocks):
            part = np.ix_(block, block)
            change = -np.linalg.solve(W[part], g[block] + W[block] @ l)
            l[block] += change
            moved += [np.linalg.norm(row * change) * (limit / 1e-4 if number in turns else 1) for row in W[part]]
        return moved
    if gradients:
        first = l.copy()
        sweep(l)
        d = first - l
        p = -d
    for i in range(gradients, most):
        before = l.copy()
        moved = sweep(l)
        if sor != 1:
            l[:] = sor * l + (1 - sor) * before
        if max(moved) <= limit if verified else sum(moved) < limit:
            break
        if gradients:
            new = before - l
            beta = new @ new / (d @ d)
            d = new
            if beta > 1:
                p = np.zeros_like(p)
            else:
                l += beta * p
                p = beta * p - d
    return i + 1


def together(*fields):
    def all_of(x, v):
        parts = [field(x, v) for field in fields]
        return sum(f for f, K in parts), sum(K for f, K in parts)
    return all_of


def gravity(weights, g):
    def field(x, v):
        return np.outer(weights, g), np.zeros((x.size, x.size))
    return field


def load(forces):
    def field(x, v):
        f = np.zeros_like(x)
        for node, force in forces.items():
            f[node] += force
        return f, np.zeros((x.size, x.size))
    return field


def springs(pairs, rest, k, d=0.0, per_length=True, acts=lambda stretch: True):
    """Explicit damping, whose tension is in the tangent too; constants over the length at rest."""
    rest = np.array(rest, float)

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for a, b in pairs:
            length = np.linalg.norm(rest[b] - rest[a])
            ks, ds = (k / length, d / length) if per_length else (k, d)
            e = x[b] - x[a]
            now = np.linalg.norm(e)
            if not acts(now - length):
                continue
            n = e / now
            t = (ks * (now - length) + ds * (v[b] - v[a]) @ n) / now
            f[a] += t * e
            f[b] -= t * e
            block = (ks - t) * np.outer(n, n) + t * np.eye(3)
            for i, j, sign in ((a, a, -1), (b, b, -1), (a, b, 1), (b, a, 1)):
                K[3 * i:3 * i + 3, 3 * j:3 * j + 3] += sign * block
        return f, K
    return field


def of_springs(lists):
    """(a, b, k, d, L) of each; the damping is explicit, and its tension is in the tangent."""
    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for a, b, k, d, L in lists:
            e = x[b] - x[a]
            now = np.linalg.norm(e)
            n = e / now
            t = (k * (now - L) + d * (v[b] - v[a]) @ n) / now
            f[a] += t * e
            f[b] -= t * e
            block = (k - t) * np.outer(n, n) + t * np.eye(3)
            for i, j, sign in ((a, a, -1), (b, b, -1), (a, b, 1), (b, a, 1)):
                K[3 * i:3 * i + 3, 3 * j:3 * j + 3] += sign * block
        return f, K
    return field


def of_rest(points, rest, k):
    """Springs of some nodes to their places at rest."""
    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for i in points:
            f[i] = -k * (x[i] - rest[i])
            K[3 * i:3 * i + 3, 3 * i:3 * i + 3] = -k * np.eye(3)
        return f, K
    return field


def stiffness(E, nu):
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    D = np.diag([2 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    return D


def polar(A):
    U, S, V = np.linalg.svd(A)
    return U @ V


def tetrahedra(cells, rest, E, nu, rotation=lambda now, then: np.eye(3)):
    """f = R K (X - R^T x), K_e with R held. rotation(edges now, edges then) maps the rest shape's axes to the present."""
    rest, D = np.array(rest, float), stiffness(E, nu)

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for cell in cells:
            X = rest[list(cell)]
            then, now = (X[1:] - X[0]).T, (x[list(cell)][1:] - x[cell[0]]).T
            G = np.vstack([[0, 0, 0], np.linalg.inv(then)])
            G[0] = -G[1:].sum(axis=0)
            B = np.zeros((6, 12))
            for i, (a, b, c) in enumerate(G):
                B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
            R = np.kron(np.eye(4), rotation(now, then))
            Ke = abs(np.linalg.det(then)) / 6 * B.T @ D @ B
            where = np.ravel([[3 * n, 3 * n + 1, 3 * n + 2] for n in cell])
            f.ravel()[where] += R @ Ke @ (X.ravel() - R.T @ x[list(cell)].ravel())
            K[np.ix_(where, where)] -= R @ Ke @ R.T
        return f, K
    return field


def edge_polar(now, then):
    return polar(now) @ polar(then).T


def mean_edges(x):
    """Of a hexahedron in VTK's order, as columns."""
    ends = (((0, 1), (3, 2), (4, 5), (7, 6)), ((0, 3), (1, 2), (4, 7), (5, 6)), ((0, 4), (1, 5), (2, 6), (3, 7)))
    return np.column_stack([np.mean([x[b] - x[a] for a, b in four], axis=0) for four in ends])


def prisms(cells, rest, E, nu, turn, points):
    """f = R K (X - R^T x) with K by one or three points of the triangle at the two heights of Gauss, and R = turn(now, then)."""
    rest, D = np.array(rest, float), stiffness(E, nu)
    triangle = {2: [(1 / 3, 1 / 3, 1 / 2)], 6: [(1 / 6, 1 / 6, 1 / 6), (2 / 3, 1 / 6, 1 / 6), (1 / 6, 2 / 3, 1 / 6)]}[points]
    shapes = []
    for cell in cells:
        X, Ke = rest[list(cell)], np.zeros((18, 18))
        for a, b, weight in triangle:
            for z in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
                L, slopes = np.array([1 - a - b, a, b]), np.array([[-1, -1], [1, 0], [0, 1]])
                dN = np.vstack([np.column_stack([slopes * (1 + s * z) / 2, L * s / 2]) for s in (-1, 1)])
                J = dN.T @ X
                B = np.zeros((6, 18))
                for i, (p, q, r) in enumerate(dN @ np.linalg.inv(J).T):
                    B[:, 3 * i:3 * i + 3] = [[p, 0, 0], [0, q, 0], [0, 0, r], [q, p, 0], [0, r, q], [r, 0, p]]
                Ke += weight * abs(np.linalg.det(J)) * B.T @ D @ B
        shapes.append((list(cell), X, Ke))

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for cell, X, Ke in shapes:
            R = turn(x[cell], X)
            T = np.kron(np.eye(6), R)
            where = np.ravel([[3 * n, 3 * n + 1, 3 * n + 2] for n in cell])
            f.ravel()[where] += T @ Ke @ (X - x[cell] @ R).ravel()
            K[np.ix_(where, where)] -= T @ Ke @ T.T
        return f, K
    return field


def hexahedra(cells, rest, E, nu, turn=None):
    """f = R K (R_0^T X - R^T x) with R and R_0 the polar factors of the mean edges, K of the shape in R_0. turn(now, then) stands for
    R R_0^T."""
    rest, D = np.array(rest, float), stiffness(E, nu)
    sides = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], float)
    shapes = []
    for cell in cells:
        X = rest[list(cell)] @ polar(mean_edges(rest[list(cell)]))
        Ke = np.zeros((24, 24))
        for point in sides / np.sqrt(3):
            one = 1 + sides * point
            dN = sides * np.column_stack([one[:, 1] * one[:, 2], one[:, 0] * one[:, 2], one[:, 0] * one[:, 1]]) / 8
            J = dN.T @ X
            B = np.zeros((6, 24))
            for i, (a, b, c) in enumerate(dN @ np.linalg.inv(J).T):
                B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
            Ke += abs(np.linalg.det(J)) * B.T @ D @ B
        shapes.append((list(cell), X, Ke))

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for cell, X, Ke in shapes:
            R = polar(mean_edges(x[cell])) if turn is None else turn(x[cell], rest[cell]) @ polar(mean_edges(rest[cell]))
            T = np.kron(np.eye(8), R)
            where = np.ravel([[3 * n, 3 * n + 1, 3 * n + 2] for n in cell])
            f.ravel()[where] += T @ Ke @ (X - x[cell] @ R).ravel()
            K[np.ix_(where, where)] -= T @ Ke @ T.T
        return f, K
    return field


def frame(x):
    """Of the first edge and the plane."""
    a = (x[1] - x[0]) / np.linalg.norm(x[1] - x[0])
    n = np.cross(x[1] - x[0], x[2] - x[0])
    n /= np.linalg.norm(n)
    return np.column_stack([a, np.cross(n, a), n])


def fibres(along, across, nu, c, s):
    """Plane stress with fibres at the cosine c and the sine s to the first axis, written out in their powers."""
    nu_t = nu * across / along
    q11, q12, q22 = (each / (1 - nu * nu_t) for each in (along, nu * across, across))
    q66 = along / (2 * (1 + nu))
    d11 = c**4 * q11 + 2 * c**2 * s**2 * (q12 + 2 * q66) + s**4 * q22
    d12 = c**2 * s**2 * (q11 + q22 - 4 * q66) + (c**4 + s**4) * q12
    d22 = s**4 * q11 + 2 * c**2 * s**2 * (q12 + 2 * q66) + c**4 * q22
    d16 = s * c**3 * (q11 - q12 - 2 * q66) + s**3 * c * (q12 - q22 + 2 * q66)
    d26 = s**3 * c * (q11 - q12 - 2 * q66) + s * c**3 * (q12 - q22 + 2 * q66)
    d66 = c**2 * s**2 * (q11 + q22 - 2 * q12 - 2 * q66) + (c**4 + s**4) * q66
    return np.array([[d11, d12, d16], [d12, d22, d26], [d16, d26, d66]])


def membrane(triangles, rest, E, nu, current, law=None):
    """f = R A0 B^T D B (u0 - R^T x), B of the present shape in R (current) or of the shape at rest. law(corners, axes) gives
    the D of a triangle, in the axes of its rest shape."""
    rest = np.array(rest, float)
    D = E / (1 - nu * nu) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for t in triangles:
            R, R0 = frame(x[list(t)]), frame(rest[list(t)])
            D_t = law(rest[list(t)], R0) if law else D
            now, then = (x[list(t)] - x[t[0]]) @ R, (rest[list(t)] - rest[t[0]]) @ R0
            area = (then[1, 0] * then[2, 1] - then[1, 1] * then[2, 0]) / 2
            shape = now if current else then
            G = np.vstack([[0, 0], np.linalg.inv((shape[1:, :2]).T)])
            G[0] = -G[1:].sum(axis=0)
            B = np.zeros((3, 9))
            for i, (a, b) in enumerate(G):
                B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [b, a, 0]]
            Ke = area * B.T @ D_t @ B
            where = np.ravel([[3 * n, 3 * n + 1, 3 * n + 2] for n in t])
            T = np.kron(np.eye(3), R)
            f.ravel()[where] += T @ Ke @ (then - now).ravel()
            K[np.ix_(where, where)] -= T @ Ke @ T.T
        return f, K
    return field


# ---- frames: centres and quaternions x y z w, velocities and angular velocities in fixed axes ----

def product(a, b):
    return np.array([*(a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])), a[3] * b[3] - a[:3] @ b[:3]])


def inverse(q):
    return np.array([-q[0], -q[1], -q[2], q[3]])


def turn_of(r):
    angle = np.linalg.norm(r)
    return np.array([*(np.sin(angle / 2) / angle * np.asarray(r)), np.cos(angle / 2)]) if angle > 0 else np.array([0, 0, 0, 1.])


def rotation_vector(q):
    q = -q if q[3] < 0 else q
    sine = np.linalg.norm(q[:3])
    return 2 * np.arctan2(sine, q[3]) / sine * q[:3] if sine > 0 else np.zeros(3)


def axes_of(q):
    return np.array([product(product(q, np.array([*e, 0.])), inverse(q))[:3] for e in np.eye(3)]).T


def first_end_beams(pairs, rest, E, nu, radius):
    """K of Euler and Bernoulli along x, in the axes of the first frame: f = -R K (0, 0, u, w), tangent -R K R^T."""
    area, moment = np.pi * radius ** 2, np.pi * radius ** 4 / 4
    twist = E / (2 * (1 + nu)) * 2 * moment

    def matrix(L):
        one = np.diag([E * area / L, 12 * E * moment / L ** 3, 12 * E * moment / L ** 3, twist / L] + [4 * E * moment / L] * 2)
        c = 6 * E * moment / L ** 2
        one[1, 5] = one[5, 1] = c
        one[2, 4] = one[4, 2] = -c
        two = one.copy()  # of the other end
        two[1, 5] = two[5, 1] = -c
        two[2, 4] = two[4, 2] = c
        between = -np.diag([E * area / L, 12 * E * moment / L ** 3, 12 * E * moment / L ** 3, twist / L] + [-2 * E * moment / L] * 2)
        between[1, 5], between[5, 1], between[2, 4], between[4, 2] = c, -c, -c, c
        return np.block([[one, between], [between.T, two]])

    def field(x, v):
        f, K = np.zeros((len(x), 6)), np.zeros((6 * len(x), 6 * len(x)))
        for a, b in pairs:
            arm, turn = {}, {}
            for name, state in (("now", x), ("rest", rest)):
                arm[name] = axes_of(state[a][3:]).T @ (state[b][:3] - state[a][:3])
                turn[name] = product(inverse(state[a][3:]), state[b][3:])
            Ke = matrix(np.linalg.norm(arm["rest"]))
            d = np.concatenate([np.zeros(6), arm["now"] - arm["rest"], rotation_vector(product(inverse(turn["rest"]), turn["now"]))])
            R = np.kron(np.eye(4), axes_of(x[a][3:]))
            where = np.r_[6 * a:6 * a + 6, 6 * b:6 * b + 6]
            f.ravel()[where] -= R @ Ke @ d
            K[np.ix_(where, where)] -= R @ Ke @ R.T
        return f, K
    return field


def euler_frames(x, inertia, forces, steps, h, held=()):
    """inertia: six numbers of each frame, in fixed axes. Returns frames of seven numbers."""
    x = np.array(x, float)
    v = np.zeros((len(x), 6))
    M = np.diag(np.tile(inertia, len(x)))
    free = np.repeat([i not in held for i in range(len(x))], 6)
    for _ in range(steps):
        f, K = forces(x, v)
        A, b = M - h * h * K, h * (f.ravel() + h * K @ v.ravel())
        dv = np.zeros(v.size)
        dv[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
        v = v + dv.reshape(-1, 6)
        for i in range(len(x)):
            x[i, :3] += h * v[i, :3]
            x[i, 3:] = product(turn_of(h * v[i, 3:]), x[i, 3:])
    return x
