# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes of SOFA in Python: loaded by Sofa.Simulation, or by the command."""
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
SCENES = HERE / "scenes"
PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 600))  # seconds: only what hangs takes so long, whatever else a machine does
COMMAND = os.environ.get("STROMA_COMMAND", "stroma")
sys.path.append(str(HERE.parent.parent / "support"))
from started import Started  # noqa: E402


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


def surroundings(**environment):
    """Of the command in a test."""
    return {**os.environ, **environment}


def run(*words, folder=None, **environment):
    """The command, in a folder of its own: what it returns and says."""
    return subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True, timeout=PATIENCE, cwd=folder,
                          env=surroundings(**environment))


class Waiting(Started):
    """The Python that the command starts, by waiting.py."""

    def __init__(self):
        super().__init__(COMMAND)
        self.forks = True

    def waiting(self, socket_number):
        environment = surroundings(OPENBLAS_NUM_THREADS="1", STROMA_COMMAND_NAME=COMMAND)  # as the command begins
        return subprocess.Popen([sys.executable, HERE / "waiting.py", str(socket_number)], pass_fds=[socket_number], env=environment,
                                stdin=subprocess.DEVNULL)


WAITING = Waiting()


def run_many(*words, folder):
    """As run() does on a scene in Python, for tests of many scenes: the command itself, and the start of Python, are left out."""
    return WAITING.run([str(word) for word in words], str(folder), PATIENCE,
                       surroundings(OPENBLAS_NUM_THREADS="1", STROMA_COMMAND_NAME=COMMAND))


# ---- what any scene must do by the command ----

def runs_ten_steps(name, folder):
    """What the command says of it."""
    done = run_many("run", SCENES / f"{name}.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "10 steps" in done.stdout and "Traceback" not in done.stderr
    assert not re.search("warning: .*: warning: ", done.stderr), "each warning is one"
    return done.stderr


def tells_all_that_is_missing(name, words, folder):
    """In one message, each with its line, and nothing runs."""
    done = run_many("run", SCENES / f"{name}.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    for word in words:
        assert re.search(rf"{name}.py:\d+: error: .*{word}", done.stderr), f"{word}\n{done.stderr}"
    assert f"{len(words)} {'error' if len(words) == 1 else 'errors'}: nothing was run" in done.stderr, done.stderr
