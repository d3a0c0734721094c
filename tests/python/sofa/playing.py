# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes of SOFA in Python: loaded by Sofa.Simulation, or by the command."""
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
SCENES = HERE / "scenes"
PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 600))  # seconds: only what hangs takes so long, whatever else a machine does
COMMAND = os.environ.get("STROMA_COMMAND", "stroma")
sys.path.insert(0, str(HERE / "library"))  # libraries that scenes import


def scene(name):
    """The root of a scene, not initialised."""
    import Sofa

    return Sofa.Simulation.load(str(SCENES / f"{name}.py"))


def started(name):
    import Sofa

    root = scene(name)
    Sofa.Simulation.init(root)
    return root


def animate(root, steps):
    import Sofa

    for _ in range(steps):
        Sofa.Simulation.animate(root, root.dt.value)


def run(*words, folder=None, **environment):
    """The command, in a folder of its own: what it returns and says."""
    path = os.pathsep.join([str(HERE / "library"), os.environ.get("PYTHONPATH", "")])
    return subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=PATIENCE, cwd=folder,
                          env={**os.environ, "PYTHONPATH": path, **environment})
