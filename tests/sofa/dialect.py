# SPDX-License-Identifier: LGPL-2.1-or-later
"""What tests of scenes in SOFA's dialect share: a scene that runs, and what it says. Usage of each: test_dialect_PART.py STROMA [WORD].

Where STROMA_TEST_SCENES names a folder, the scenes that leave a way of SOFA out are kept there: docs/plots/quirk_pictures.py draws them."""
import gzip
import json
import os
import sys
import tempfile

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from started import Started

STROMA = Started(sys.argv[1])
CASES = []


def case(function):
    CASES.append(function)
    return function


RUNS = []


def states_in(folder):
    """The last positions of each recorded state."""
    states = {}
    for file in os.listdir(folder) if os.path.isdir(folder) else []:
        if file.endswith(".state.gz"):
            with gzip.open(os.path.join(folder, file), "rt") as lines:
                rows = [line for line in lines if line.strip().startswith("X=")]
            states[file[:-9]] = np.array(rows[-1].split("=")[1].split(), float)
    return states


def keep(quirk, given):
    folder = os.environ.get("STROMA_TEST_SCENES")
    if not folder or any(isinstance(text, bytes) for text in (given["scene"], *given["files"].values())):
        return
    number = sum(file.startswith(quirk + ".") for file in os.listdir(folder))
    with open(os.path.join(folder, f"{quirk}.{number}.json"), "w", encoding="utf-8") as out:
        json.dump(given, out)


class Run:
    def __init__(self, scene, steps, files=None, args=(), name="scene.scn", command="run"):
        with tempfile.TemporaryDirectory() as folder:
            for file, text in {name: scene, **(files or {})}.items():
                path = os.path.join(folder, file)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "wb") as out:
                    out.write(text if isinstance(text, bytes) else text.encode())
            record = {"run": ["-n", str(steps), "--record", "out"], "migrate": ["-o", "native.xml"]}.get(command, [])
            environment = {**os.environ, "STROMA_DATA_PATH": os.path.join(folder, "data")}
            done = STROMA.run([command, name, *record, *args], folder, env=environment)
            self.code, self.text = done.returncode, done.stdout + done.stderr
            self.states = states_in(os.path.join(folder, "out"))
            if command == "run" and self.code == 0:
                RUNS.append(self)
            self.given = scene, steps, files, args, name
            if command == "run" and args[:1] == ["--without-quirk"] and len(args) == 2:
                keep(args[1], {"scene": scene, "steps": steps, "files": files or {}, "name": name})
            self.native = {}
            if command == "migrate" and self.code == 0:
                done = STROMA.run(["run", "native.xml", "-n", str(steps), "--record", "out"], folder, env=environment)
                assert done.returncode == 0, done.stderr
                self.native = states_in(os.path.join(folder, "out"))

    @classmethod
    def of_native(cls, scene, steps):
        """Of a scene that is none of SOFA's, and is not migrated."""
        run = cls(scene, steps, name="scene.xml")
        if run in RUNS:
            RUNS.remove(run)
        return run

    def x(self, name="dofs", width=3):
        if name not in self.states:
            raise AssertionError(f"no state {name} of {sorted(self.states)}:\n{self.text}")
        return self.states[name].reshape(-1, width)

    def says(self, *words):
        for word in words:
            assert word in self.text, f"'{word}' is not said:\n{self.text}"

    def fails(self, code, *words):
        assert self.code == code, f"exit code {self.code} instead of {code}:\n{self.text}"
        self.says(*words)


def node(content, attributes=""):
    return f'<Node name="root" gravity="0 0 0" dt="0.01" {attributes}>{content}</Node>'


def agree(a, b, tolerance=1e-9):
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape, f"{a.shape} instead of {b.shape}"
    size = max(np.abs(b).max(), 1e-12)
    error = np.abs(a - b).max() / size
    assert error <= tolerance, f"differs by {error:.3g} of {size:.3g}:\n{a}\n{b}"


def differ(a, b, least):
    error = np.abs(np.asarray(a) - np.asarray(b)).max()
    assert error > least, f"differs by {error:.3g} only: the flag does nothing"


EXACT = '<EulerImplicitSolver/><SparseLDLSolver/>'
BODY = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>'
FALL = 'gravity="0 -10 0"'


def fallen(steps, h=0.01, g=10.0):
    return -g * h * h * steps * (steps + 1) / 2


def falls(run, name="dofs", steps=10, h=0.01, g=10.0, start=0):
    agree(run.x(name)[:, 1], np.add(start, np.full(len(run.x(name)), fallen(steps, h, g))))


def root(content, attributes=FALL):
    return f'<Node name="root" dt="0.01" {attributes}>{content}</Node>'


def migrated_scenes_give_the_same_numbers():
    """All of the above that ran, once more as native scenes."""
    runs = list(RUNS)
    for run in runs:
        scene, steps, files, args, name = run.given
        migrated = Run(scene, steps, files, [word for word in args if word not in ("--dialect", "sofa")], name, "migrate")
        assert migrated.code == 0, migrated.text
        assert sorted(migrated.native) == sorted(run.states), (migrated.text, scene)
        for state, x in run.states.items():
            assert np.array_equal(migrated.native[state], x), f"{state} of {scene}"


def main():
    """Runs the cases, and then all of them that ran once more as native scenes."""
    case(migrated_scenes_give_the_same_numbers)
    word = sys.argv[2] if len(sys.argv) > 2 else ""
    failed = 0
    chosen = [function for function in CASES if word in function.__name__]
    for function in chosen:
        try:
            function()
            print("ok    ", function.__name__, flush=True)
        except Exception as error:  # a case that fails must not hide the others
            failed += 1
            print("FAILED", function.__name__, f"{type(error).__name__}: {error}", flush=True)
    print(f"{len(chosen) - failed} of {len(chosen)} cases passed")
    sys.exit(1 if failed or not chosen else 0)
