# SPDX-License-Identifier: LGPL-2.1-or-later
"""Options of a command line that is another one's, sizes as arrays of several types, a file beside the run, a main() of its own."""
import argparse
import os
import sys

import numpy as np
import Sofa
import SofaRuntime

SofaRuntime.importPlugin("SofaComponentAll")


def parse():
    parser = argparse.ArgumentParser(description="beam")
    parser.add_argument("--young", type=float, default=1e4)
    parser.add_argument("--cells", type=int, nargs=3, default=[8, 3, 3])
    known, _ = parser.parse_known_args(sys.argv[1:])
    return known


def createScene(root, young=None):
    args = parse()
    young = young or args.young
    root.dt = 0.02
    root.gravity = [0., 0., -9.81]
    root.addObject("DefaultAnimationLoop")
    beam = root.addChild("beam")
    beam.addObject("EulerImplicitSolver", rayleighStiffness=0.1, rayleighMass=0.1)
    beam.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    grid = beam.addObject("RegularGridTopology", name="grid", n=args.cells, min=np.zeros(3), max=np.array([1, .2, .2]))
    beam.addObject("MechanicalObject", name="dofs", template="Vec3d", showObject=True)
    beam.addObject("UniformMass", totalMass=np.float32(0.4))
    beam.addObject("HexahedronFEMForceField", name="fem", youngModulus=young, poissonRatio=0.45, method="large")
    beam.addObject("BoxROI", box=[-1e-3, -1, -1, 1e-3, 1, 1], drawBoxes=1)
    beam.addObject("FixedConstraint", indices="@BoxROI.indices")
    tip = np.argmax(np.linalg.norm(grid.position.value, axis=1))
    beam.addObject("Monitor", indices=int(tip), ExportPositions=True, fileName=os.path.join(os.getcwd(), "tip"), listening=True)
    return root


def main():
    root = Sofa.Core.Node("root")
    createScene(root)
    Sofa.Simulation.init(root)
    for _ in range(3):
        Sofa.Simulation.animate(root, root.dt.value)
    print(root.beam.dofs.position.value[-1])


if __name__ == "__main__":
    main()
