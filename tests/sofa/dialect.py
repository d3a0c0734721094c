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
from reference import turn_of
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


X4 = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5]])
X4_TEXT = "0 0 0  2 0 0  0 3 0  0 0 1.5"
CUBE = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(2)], float)
CORNERS = [0, 1, 3, 2, 4, 5, 7, 6]
WATCH = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><CollisionResponse response="PenalityContactForceField"/>'
         '<MinProximityIntersection alarmDistance="0.5" contactDistance="0.2"/>')
PLACES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def shapes_at(xi):
    """N and its slopes in a cell of the unit size, corners in the order of cells."""
    factors = np.where(PLACES == 1, xi, 1 - np.asarray(xi))
    slopes = np.array([[(1 if place[axis] else -1) * np.prod(np.delete(row, axis)) for axis in range(3)]
                       for place, row in zip(PLACES, factors)])
    return factors.prod(axis=1), slopes


def placed(content, link, files=None):
    body = f'<Node name="a"><MechanicalObject name="dofs" position="@../{link}"/><UniformMass totalMass="1"/></Node>'
    run = Run(node(content + EXACT + body), 1, files)
    return run.x("a.dofs")


def voxels(container, content):
    loader = '<VoxelGridLoader name="loader" filename="a.raw" resolution="2 1 1"/>'
    return Run(root(EXACT + loader + f'<{container} src="@loader"/><MechanicalObject name="dofs"/>' + content), 10, {"a.raw": b"12"})


TWO = ('<Node name="{0}">{1}<MechanicalObject name="dofs" position="{2}" velocity="{3}"/><UniformMass totalMass="{4}"/></Node>')
CUBE_PLACES = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
CHAIN = np.array([[0, 0, 0], [1, 0, 0], [2, 0.3, 0], [2.5, 1, 0.2]])
CHAIN_NODES = '<MechanicalObject name="dofs" position="' + " ".join(str(c) for p in CHAIN for c in p) + '"/><UniformMass totalMass="4"/>'
LINKS = [(0, 1), (1, 2), (2, 3)]


def numbers_of(values):
    return " ".join(repr(float(value)) for value in np.ravel(values))


def oriented(axis, angle):
    return turn_of(np.array(axis) / np.linalg.norm(axis) * angle)


SWINGING = [np.array([[0, 0, 0], [1, 0.1, 0.2], [2, -0.1, 0.1], [2.9, 0.3, -0.2]]),
            np.array([[0.1, 0.2, -0.3], [0.5, 0, 1], [0, -1, 0.3], [-0.4, 0.6, 0.2]])]
HANGING = [np.array([[2.9, 0.3, -0.2], [3.8, 0.2, 0.3], [4.5, -0.4, 0.1]]), np.array([[0.3, -0.2, 0.5], [0, 1, -1], [0.4, 0.4, 0.2]])]
SWINGING_SPRINGS = [(0, 1, 80, 2, 1.1), (1, 2, 60, 1, 0.9), (2, 3, 70, 1.5, 1.2)]
HANGING_SPRINGS = [(0, 1, 90, 1, 1.0), (1, 2, 50, 2, 0.8)]
DAMPED = '<EulerImplicitSolver rayleighStiffness="0.02" rayleighMass="0.1"/>'
DAMPED_SOLVERS = (DAMPED + '<CGLinearSolver iterations="400" tolerance="1e-14" threshold="1e-30"/>', DAMPED + '<SparseLDLSolver/>')


def damped_system(x, v, mass, lists, h=0.01, rm=0.1, rk=0.02, g=10.0):
    """A and b of an implicit step of nodes on springs (a, b, k, d, L), whose damping is not in the matrix."""
    f, K = np.outer(mass, [0, -g, 0]), np.zeros((x.size, x.size))
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
    M, flat = np.diag(np.repeat(mass, 3)), v.ravel()
    return (1 + h * rm) * M - h * (h + rk) * K, h * (f.ravel() + (h + rk) * K @ flat - rm * M @ flat)


FREE_LOOP = '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-14"/>'


def springs_of(lists):
    return '<SpringForceField spring="' + "  ".join(numbers_of(spring) for spring in lists) + '"/>'


def two_bodies(between, solver, apart=0, loop=""):
    bodies = ""
    for name, (x, v), mass, lists, more in (("one", SWINGING, 0.5, SWINGING_SPRINGS, '<FixedProjectiveConstraint indices="0"/>'),
                                            ("two", HANGING, 0.3, HANGING_SPRINGS, "")):
        x = x + apart if name == "two" else x
        bodies += (f'<Node name="{name}"><MechanicalObject name="dofs" position="{numbers_of(x)}" velocity="{numbers_of(v)}"/>'
                   f'<UniformMass vertexMass="{mass}"/>{springs_of(lists)}{more}</Node>')
    return root(loop + f'<Node name="bodies">{solver}{bodies}{between}</Node>')


def both_bodies(apart=0):
    lists = SWINGING_SPRINGS + [(a + 4, b + 4, *rest) for a, b, *rest in HANGING_SPRINGS]
    return np.vstack([SWINGING[0], HANGING[0] + apart]), np.vstack([SWINGING[1], HANGING[1]]), [0.5] * 4 + [0.3] * 3, lists


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
