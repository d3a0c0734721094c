# SPDX-License-Identifier: LGPL-2.1-or-later
"""The dragged liver (figures 5 and 6 of Nesme et al. 2005) and the artificial torque (figure 3)."""
import os

import numpy as np

import stroma_run as sr

LIVER, FREE = "scenes/validation/liver_drag.xml", "scenes/validation/free_body.xml"
VARIANTS = [("large", 0, 0), ("large", 1, 0), ("polar", 0, 0), ("polar", 1, 0), ("polar", 1, 1), ("svd", 0, 0), ("svd", 1, 0)]


def settings(method, update_b, update_v, fem):
    return [f"{fem}.method={method}", f"{fem}.updateStiffnessMatrix={'true' if update_b else 'false'}",
            f"{fem}.updateVolume={'true' if update_v else 'false'}"]


def variant_name(method, update_b, update_v):
    return method + (", B and V" if update_v else ", B" if update_b else "")


def drag(stroma, data, out):
    mesh = os.path.join(data, "meshes", "liver.msh")
    rest = stroma.run(LIVER, [f"/organ/loader.filename={mesh}"] if os.path.exists(mesh) else [], steps=0)
    mesh_setting = [f"/organ/loader.filename={mesh}"] if os.path.exists(mesh) else []
    x = rest["frames"]["organ.dofs"][0]
    size = np.linalg.norm(x.max(axis=0) - x.min(axis=0))
    # four nodes spread over one end, and the farthest node dragged through the body past them
    axis = np.argmax(x.max(axis=0) - x.min(axis=0))
    order = np.argsort(x[:, axis])
    held, dragged = order[:4], order[-1]
    path = (x[held].mean(axis=0) - x[dragged]) * 0.8
    path_text = "0 0 0  " + "  ".join([" ".join(f"{v:.9g}" for v in path)] * 2)
    common = mesh_setting + ["/organ/held.indices=" + " ".join(map(str, held)), f"/organ/drag.indices={dragged}",
                             "/organ/drag.movements=" + path_text]
    rows = []
    for variant in VARIANTS:
        result = stroma.run(LIVER, common + settings(*variant, "/organ/fem"), until=30, every=50)
        frames = result["frames"]["organ.dofs"]
        distance = np.linalg.norm(frames - x, axis=2).max(axis=1) / size
        back = np.flatnonzero(distance[4:] < 1e-6)
        rows.append([variant_name(*variant), f"{distance.max():.2f}", f"{distance[-1]:.1e}",
                     f"{4 + back[0]} s" if len(back) else "no", "" if result["code"] == 0 else result["message"]])
        print("   liver", *rows[-1], flush=True)
    header = ["method", "largest displacement / size", "at t = 30 s", "within 1e-6 of the size at", "end"]
    sr.write_csv(os.path.join(out, "liver_drag.csv"), header, rows)
    return (f"### Dragged and released (figures 5 and 6)\n\n{len(x)} nodes, held at four; one node is dragged through the body "
            f"by {np.linalg.norm(path) / size:.2f} of its size in 1 s, held for 2 s and let go.\n\n" + sr.markdown(header, rows))


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


def run(stroma, data, out, report):
    report.append("## Robustness and the laws of motion\n\n" + drag(stroma, data, out) + "\n" + torque(stroma, out))
