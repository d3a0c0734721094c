# SPDX-License-Identifier: LGPL-2.1-or-later
"""The torque of one deformed element of Nesme et al. 2005, from the formulas alone: no code of the simulator is used."""
import numpy as np

DRAWS, SHAKE = 200, 0.1
LAMBDA, MU = 1.0, 0.7
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
BOX = CORNERS * [1, 0.7, 0.5]
DISTORTED = BOX + 0.15 * np.random.default_rng(3).standard_normal(BOX.shape)


def gradients(rest, at):
    """Gradients of the shape functions by the local coordinates `at`, shape (nodes, 3)."""
    if len(rest) == 4:
        return np.vstack([-np.ones(3), np.eye(3)])
    terms = 1 + CORNERS * at
    return CORNERS * np.column_stack([terms[:, 1] * terms[:, 2], terms[:, 2] * terms[:, 0], terms[:, 0] * terms[:, 1]]) / 8


def points(rest):
    """Integration points in local coordinates; they weigh the same."""
    return [np.zeros(3)] if len(rest) == 4 else CORNERS / np.sqrt(3)


def frame(edges):
    q, r = np.linalg.qr(edges)
    q = q * np.sign(np.diag(r))
    return q * [1, 1, np.sign(np.linalg.det(q))]


def rotation(method, now, rest):
    """R of the (mean) edges now and at rest, columns."""
    if method == "small":
        return np.eye(3)
    if method == "large":
        return frame(now) @ frame(rest).T
    f = now @ np.linalg.inv(rest)
    u, stretches, v = np.linalg.svd(f)
    mirrored = np.linalg.det(f) < 0
    if method == "svd":  # the smallest stretch turns negative
        return u * [1, 1, -1 if mirrored else 1] @ v
    q = u @ v
    if mirrored:  # the axis of the rest frame that is stretched least
        q[:, np.argmin(np.sum(q * f, axis=0))] *= -1
    return q


def forces(rest, x, method, update_b):
    centre = gradients(rest, np.zeros(3))
    r = rotation(method, x.T @ centre, rest.T @ centre)
    f = np.zeros_like(x)
    for at in points(rest):
        local = gradients(rest, at)
        j0, j = rest.T @ local, x.T @ local
        h = r.T @ j @ np.linalg.inv(j0)
        strain = (h + h.T) / 2 - np.eye(3)
        stress = LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain
        if update_b:  # of the present shape, with the volume at rest
            g = local @ np.linalg.inv(j) * np.linalg.det(j) / np.linalg.det(j0)
        else:
            g = local @ np.linalg.inv(j0) @ r.T
        f -= abs(np.linalg.det(j0)) * g @ r @ stress @ r.T
    return f


def torque(x, f):
    """|sum x cross f| over sum |x||f|, x from the mean of the nodes."""
    x = x - x.mean(axis=0)
    return np.linalg.norm(np.cross(x, f).sum(axis=0)) / (np.linalg.norm(x, axis=1) * np.linalg.norm(f, axis=1)).sum()


def largest_torque(rest, method, update_b, inverted=False):
    """The largest of DRAWS shapes: nodes moved at random by SHAKE, turned; a node pushed through where `inverted`."""
    random = np.random.default_rng(1)
    worst = 0
    for _ in range(DRAWS):
        x = rest + SHAKE * random.standard_normal(rest.shape)
        if inverted:
            x[-1] -= 1.5 * (x[-1] - x[:-1].mean(axis=0))
        x = x @ frame(random.standard_normal((3, 3))).T
        worst = max(worst, torque(x, forces(rest, x, method, update_b)))
    return worst


def halving():
    """How many times less the torque of a box becomes (polar, constant B) when what varies over it is halved, at a mean
    deformation that stays."""
    random = np.random.default_rng(2)
    linear = np.column_stack([np.ones(8), CORNERS])
    varying = random.standard_normal((8, 3))
    varying -= linear @ np.linalg.lstsq(linear, varying, rcond=None)[0]  # leaves the mean edges as they are
    f = np.eye(3) + 0.1 * random.standard_normal((3, 3))
    sums = []
    for size in (0.02, 0.01):
        x = BOX @ f.T + size * varying
        sums.append(np.linalg.norm(np.cross(x, forces(BOX, x, "polar", False)).sum(axis=0)))
    return sums[0] / sums[1]
