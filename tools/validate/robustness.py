# SPDX-License-Identifier: LGPL-2.1-or-later
"""The artificial torque (figure 3 of Nesme et al. 2005)."""
import os

import numpy as np

import stroma_run as sr

FREE = "scenes/validation/free_body.xml"
VARIANTS = [("large", 0, 0), ("large", 1, 0), ("polar", 0, 0), ("polar", 1, 0), ("polar", 1, 1), ("svd", 0, 0), ("svd", 1, 0)]


def settings(method, update_b, update_v, fem):
    return [f"{fem}.method={method}", f"{fem}.updateStiffnessMatrix={'true' if update_b else 'false'}",
            f"{fem}.updateVolume={'true' if update_v else 'false'}"]


def variant_name(method, update_b, update_v):
    return method + (", B and V" if update_v else ", B" if update_b else "")


def torque(stroma, out):
    x = stroma.run(FREE, steps=0)["frames"]["body.dofs"][0]
    bent = x.copy()
    angle = 6 * x[:, 0]
    bent[:, 1], bent[:, 2] = (np.cos(angle) * x[:, 1] - np.sin(angle) * x[:, 2],
                              np.sin(angle) * x[:, 1] + np.cos(angle) * x[:, 2])
    bent[:, 2] += 5 * x[:, 0]**2
    place = [f"/body/dofs.{name}=" + "  ".join(" ".join(f"{v:.9g}" for v in p) for p in points)
             for name, points in (("position", bent), ("rest_position", x))]
    rows = []
    for variant in [("small", 0, 0)] + VARIANTS + [("nodal", 0, 0)]:
        result = stroma.run(FREE, settings(*variant, "/body/fem") + place, steps=400, every=1)
        frames, mass = result["frames"]["body.dofs"], 0.25 / len(x)
        velocity = np.diff(frames, axis=0)
        place_after = frames[1:]  # symplectic Euler: x1 = x0 + h v1, so x1 cross v1 is the momentum of the step itself
        momentum = np.linalg.norm(np.cross(place_after, velocity).sum(axis=1), axis=1)
        scale = (np.linalg.norm(place_after, axis=2) * np.linalg.norm(velocity, axis=2)).sum(axis=1)
        drift = np.linalg.norm((frames - frames[0]).mean(axis=1), axis=1).max() / 0.16
        rows.append([variant_name(*variant), f"{momentum.max() / scale.max():.1e}", f"{momentum.max() * mass / 2e-4:.1e}",
                     f"{drift:.1e}", "" if result["code"] == 0 else result["message"]])
    header = ["method", "angular momentum / sum |x||v|", "angular momentum [kg m2/s]", "drift of the centre / length", "end"]
    sr.write_csv(os.path.join(out, "torque.csv"), header, rows)
    return ("### The artificial torque (figure 3)\n\nA free block starts bent and twisted, at rest. Angular momentum and drift "
            "that it gains are its own forces' doing.\n\n" + sr.markdown(header, rows))


def run(stroma, out, report):
    report.append("## The laws of motion\n\n" + torque(stroma, out))
