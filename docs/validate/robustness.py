# SPDX-License-Identifier: LGPL-2.1-or-later
"""The artificial torque (figure 3 of Nesme et al. 2005)."""
import os

import numpy as np

import one_element
import stroma_run as sr
import variants

FREE = "scenes/validation/free_body.xml"
VARIANTS = [("small", 0, 0), ("large", 0, 0), ("large", 1, 0), ("polar", 0, 0), ("polar", 1, 0), ("polar", 1, 1),
            ("svd", 0, 0), ("svd", 1, 0)]
ONLY = {"tetrahedra": [("nodal", 0, 0)], "hexahedra": []}

WHY = """### Which of the forces can make a torque

The forces of an element make none where the sum of f_i x_i^T is symmetric. With the gradients g_i of the rest shape and
F = sum x_i g_i^T, a tetrahedron of constant B has f_i = -V_0 R sigma g_i, so the sum is -V_0 R sigma (R^T F)^T R^T.

- Polar: R^T F = S is symmetric. sigma = lambda tr(S - I) I + 2 mu (S - I) is a polynomial in S, so sigma S is symmetric. **By polar
  a tetrahedron of an isotropic law makes no torque, though its B is not updated, until it inverts.** Once inverted, polar flips an
  axis of the rest frame, and R^T F is symmetric no more. That of svd still is.
- QR (large): R^T F is triangular in the frame of the edges at rest. With R = I (small) it is F. Neither is symmetric in general.
- An updated B has the gradients of the present shape, whose sum x_i g_i^T is a multiple of I. That leaves the symmetric
  R sigma R^T for any R and any law.

The paper (section 3.1) proves that an updated B is enough and concludes that it is needed. For tetrahedra with svd, and with polar
until one inverts, it is not.

A hexahedron has one R, that of its mean edges, but another F_p at each integration point: R^T F_p = S_p + W_p with W_p skew.
Its sum is -sum w_p R sigma_p (S_p - W_p) R^T with sigma_p made of S_p alone, and sigma_p S_p is symmetric as before. What remains is
the skew part of sum w_p sigma_p W_p, that is 1/2 sum w_p (sigma_p W_p + W_p sigma_p). It is not zero in general once the
deformation varies over the cell. In a box the W_p sum to zero, so that the torque is of second order in what varies over the cell.
In a distorted cell it need not be.

"""


def momentum_row(stroma, cells, variant, place):
    result = stroma.run(variants.scene(FREE, cells), variants.settings(*variant, "/body/fem") + place, steps=400, every=1)
    frames = result["frames"]["body.dofs"]
    mass, velocity = 0.25 / frames.shape[1], np.diff(frames, axis=0)
    place_after = frames[1:]  # symplectic Euler: x1 = x0 + h v1, so x1 cross v1 is the momentum of the step itself
    momentum = np.linalg.norm(np.cross(place_after, velocity).sum(axis=1), axis=1)
    scale = (np.linalg.norm(place_after, axis=2) * np.linalg.norm(velocity, axis=2)).sum(axis=1)
    drift = np.linalg.norm((frames - frames[0]).mean(axis=1), axis=1).max() / 0.16
    return [cells, variants.name(*variant), f"{momentum.max() / scale.max():.1e}", f"{momentum.max() * mass / 2e-4:.1e}",
            f"{drift:.1e}", "" if result["code"] == 0 else result["message"]]


def bent_and_twisted(stroma):
    """Overrides that start the block bent: nodes are those of the grid with both kinds of cell."""
    x = stroma.run(FREE, steps=0)["frames"]["body.dofs"][0]
    bent = x.copy()
    angle = 6 * x[:, 0]
    bent[:, 1], bent[:, 2] = (np.cos(angle) * x[:, 1] - np.sin(angle) * x[:, 2],
                              np.sin(angle) * x[:, 1] + np.cos(angle) * x[:, 2])
    bent[:, 2] += 5 * x[:, 0]**2
    return [f"/body/dofs.{name}=" + "  ".join(" ".join(f"{v:.9g}" for v in p) for p in points)
            for name, points in (("position", bent), ("rest_position", x))]


def torque(stroma, out):
    place = bent_and_twisted(stroma)
    rows = [momentum_row(stroma, cells, variant, place)
            for cells in variants.SUFFIXES for variant in VARIANTS + ONLY[cells]]
    header = ["cells", "method", "angular momentum / sum |x||v|", "angular momentum [kg m2/s]", "drift of the centre / length",
              "end"]
    sr.write_csv(os.path.join(out, "torque.csv"), header, rows)
    header[2] = header[2].replace("|", "\\|")
    return ("### The artificial torque (figure 3)\n\nA free block starts bent and twisted, at rest: 32 cells of a grid, each five "
            "tetrahedra or one hexahedron. Angular momentum and drift that it gains are its own forces' doing.\n\n" +
            sr.markdown(header, rows))


def of_one_element():
    shapes = [("tetrahedron", one_element.TETRAHEDRON, False), ("tetrahedron, inverted", one_element.TETRAHEDRON, True),
              ("hexahedron, box", one_element.BOX, False), ("hexahedron, distorted", one_element.DISTORTED, False)]
    compared = variants.CONSTANT_B + variants.UPDATED_B
    rows = [[name] + [f"{one_element.largest_torque(rest, method, update_b, inverted):.1e}"
                      for method, update_b, _ in compared]
            for name, rest, inverted in shapes]
    return (WHY + f"Checked apart from the simulator, by the formulas in Python (`docs/validate/one_element.py`): the largest "
            f"\\|sum x_i cross f_i\\| / sum \\|x_i\\|\\|f_i\\| of {one_element.DRAWS} random shapes of one element. When what varies over "
            f"the box is halved, its torque becomes {one_element.halving():.2f} times less.\n\n" +
            sr.markdown(["element"] + [variants.name(*variant) for variant in compared], rows))


def run(stroma, out, report):
    report.append("## The laws of motion\n\n" + torque(stroma, out) + "\n" + of_one_element())
