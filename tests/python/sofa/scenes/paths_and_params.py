# SPDX-License-Identifier: LGPL-2.1-or-later
"""Parameters from JSON and YAML beside the scene, command-line arguments that are not there, pathlib, environment, logging."""
import argparse
import json
import logging
import os
import pathlib
import sys

import numpy as np
import Sofa

logging.basicConfig(level=logging.INFO)
log = logging.getLogger(__name__)
HERE = pathlib.Path(__file__).resolve().parent
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--young", type=float, default=None)
parser.add_argument("--steps", type=int, default=10)
args, unknown = parser.parse_known_args(sys.argv[1:])


def load_params(file):
    with open(file, "r") as stream:
        return json.load(stream)


def createScene(root):
    params = {"material": {"young": 2e3, "poisson": 0.4}, "points": load_params(HERE / "mesh" / "cable.json")}
    try:
        import yaml
        params.update(yaml.safe_load("dt: 0.01\ngravity: [0, -9.81, 0]\n"))
    except ImportError:
        params.update(dt=0.01, gravity=[0, -9.81, 0])
    log.info("parameters %s", sorted(params))
    root.dt, root.gravity = params["dt"], params["gravity"]
    root.addObject("DefaultAnimationLoop")
    n = root.addChild(Sofa.Core.Node("body"))
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=50, tolerance=1e-9, threshold=1e-9)
    n.addObject("MeshVTKLoader", name="loader", filename=str(HERE / "mesh/finger.vtk"), scale3d=[1e-2] * 3)
    n.addObject("MeshTopology", src=n.loader.getLinkPath())
    n.addObject("MechanicalObject", name="dofs")
    n.addObject("UniformMass", totalMass=os.environ.get("MASS_OF_THE_BODY", 0.2))
    material = {"youngModulus": args.young or params["material"]["young"], "poissonRatio": params["material"]["poisson"]}
    n.addObject("TetrahedronFEMForceField", method="large", **material)
    n.addObject("FixedProjectiveConstraint", indices=np.where(n.loader.position.value[:, 0] < 1e-6)[0].tolist())
    follow = n.addChild("line")
    follow.addObject("MechanicalObject", position=np.array(params["points"]) * 1e-2)
    follow.addObject("BarycentricMapping")
    assert HERE.name == "scenes" and os.path.exists(os.path.join(HERE, "mesh"))
