# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma regress` on lists and references as SOFA has them, and `stroma check --sofa` on folders. Usage: test_regression.py STROMA"""
import gzip
import json
import math
import os
import subprocess
import sys
import tempfile
import time

STROMA = os.path.abspath(sys.argv[1])
H, STEPS = 0.01, 11
SCENE = ('<Node name="root" gravity="0 -10 0" dt="0.01"><EulerImplicitSolver/><SparseLDLSolver/>'
         '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
         '<FixedConstraint indices="0"/></Node>')
# a node between two compressed springs: it leaves its place to the side that round-off chooses
CHAOS = ('<Node name="root" gravity="0 0 0" dt="0.01"><EulerImplicitSolver/><SparseLDLSolver/>'
         '<MechanicalObject name="dofs" position="0 0 0  1 1e-13 0  2 0 0"/><UniformMass totalMass="3"/>'
         '<SpringForceField spring="0 1 1000 0 1.5  1 2 1000 0 1.5"/><FixedConstraint indices="0 2"/></Node>')


def positions(step):
    y = -10 * H * H * step * (step + 1) / 2
    return [[0, 0, 0], [1, y, 0], [2, y, 0]]


def frames():
    return {round(k * H, 10): positions(k) for k in range(STEPS)}


def as_text(values):
    return "".join(f"T= {t}\n  X= " + " ".join(f"{c:.6g}" for p in x for c in p) + "\n" for t, x in values.items())


def as_json(values):
    return json.dumps({str(t): x for t, x in values.items()})


def as_csv(values):
    return "# format 1\n# values per point 3\n" + "".join(
        f"{t}," + ",".join(str(c) for p in x for c in p) + "\n" for t, x in values.items())


def run(reference, name, scene=SCENE, more=(), line=f"Mass/fall.scn {STEPS} 1e-4 1 0", where="examples/all.regression-tests"):
    with tempfile.TemporaryDirectory() as folder:
        os.makedirs(os.path.join(folder, "examples/Mass"))
        os.makedirs(os.path.join(folder, "references/Mass"))
        with open(os.path.join(folder, "examples/Mass/fall.scn"), "w") as out:
            out.write(scene)
        files = reference if isinstance(reference, dict) else {name: reference} if reference is not None else {}
        for name, text in files.items():
            with open(os.path.join(folder, "references/Mass", "fall.scn.reference_" + name), "wb") as out:
                out.write(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
        with open(os.path.join(folder, "examples/all.regression-tests"), "w") as out:
            out.write(f"# State\n../references\n{line}\n")
        with open(os.path.join(folder, "examples/someTopology.regression-tests"), "w") as out:
            out.write("../references\nnowhere.scn 10 1e-4\n")
        done = subprocess.run([STROMA, "regress", where, "--json", "out.json", *more], cwd=folder,
                              capture_output=True, text=True, timeout=600)
        text = done.stdout + done.stderr
        path = os.path.join(folder, "out.json")
        result = json.load(open(path))[0] if os.path.exists(path) else {}
        return done.returncode, text, result


def passes(reference, name):
    code, text, result = run(reference, name)
    assert code == 0 and result["verdict"] == "passed", text
    assert result["relative"] < 1e-4 and result["sofa_passes"], text


def fails(reference, name, word):
    code, text, result = run(reference, name)
    assert code == 1 and result["verdict"] == "failed" and word in text, text


passes(as_text(frames()), "0_dofs_mstate.txt")
passes(as_text(frames()), "0_dofs_mstate.txt.gz")
passes(as_json(frames()), "mstate_0_dofs.json.gz")
passes(as_csv(frames()), "mstate_0_dofs.csv.gz")

# what must not pass
fails(None, "", "no reference")
fails(as_json(frames()).replace("-0.001", "NaN", 1), "mstate_0_dofs.json.gz", "JSON")
fails(as_text(frames()).replace(" -0.001 ", " nan ", 1), "0_dofs_mstate.txt.gz", "finite")
fails(as_text(frames()).rsplit(" ", 2)[0], "0_dofs_mstate.txt", "numbers")
fails(as_json({t: x[::-1] for t, x in frames().items()}), "mstate_0_dofs.json.gz", "relative")
fails(as_json({t: [[c + 0.1 for c in p] for p in x] for t, x in frames().items()}), "mstate_0_dofs.json.gz", "relative")
fails(as_json({t: positions(int(t / H + 1.5)) if t else positions(0) for t in frames()}), "mstate_0_dofs.json.gz", "relative")
fails(as_json({t: x[:2] for t, x in frames().items()}), "mstate_0_dofs.json.gz", "numbers")
fails(as_json(frames()), "mstate_0_other.json.gz", "other")

# frames: a body that spins about a fixed axis while it drifts, in closed form; its quaternion passes w = 0 several times
SPIN, DRIFT, TURNS = (3.0, -14.0, 8.0), (0.01, 0, 0), 61
START = (0.0, 0.0, -0.6, -0.8)


def product(a, b):
    (x, y, z, w), (p, q, r, s) = a, b
    return (w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s, w * s - x * p - y * q - z * r)


def turned(t, rate=1.0):
    """exp(rate w t) q(0), without a break."""
    size = sum(c * c for c in SPIN) ** 0.5
    half = rate * size * t / 2
    return product([math.sin(half) * c / size for c in SPIN] + [math.cos(half)], START)


def spinning(frames=1, way=1.0, rate=1.0, sign=lambda q: 1, late=0):
    """A second frame stays where it is."""
    out = {}
    for k in range(TURNS):
        t = (k + late) * H if k else 0
        q = turned(t, rate)
        q = [c * sign(q) for c in q]
        out[round(k * H, 10)] = [[1 + way * DRIFT[0] * t, 2, 3, *q]] + [[0, 0, 5, 0, 0, 0, 1.0]] * (frames - 1)
    return out


def spins(reference, frames=1):
    more = "  0 0 5 0 0 0 1" * (frames - 1), "  0 0 0 0 0 0" * (frames - 1)
    scene = (f'<Node name="root" gravity="0 0 0" dt="{H}"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" '
             f'template="Rigid3" position="1 2 3 0 0 -0.6 -0.8{more[0]}" velocity="{DRIFT[0]} 0 0 {" ".join(map(str, SPIN))}{more[1]}"/>'
             '<UniformMass vertexMass="2 1 0.1 0 0 0 0.1 0 0 0 0.1"/></Node>')
    return run(as_json(reference) if isinstance(reference, dict) else reference, "mstate_0_dofs.json.gz", scene,
               line=f"Mass/fall.scn {TURNS} 1e-4 1 0")


assert any(spinning()[round(k * H, 10)][0][6] < 0 < spinning()[round(k * H + H, 10)][0][6] for k in range(TURNS - 1))
code, text, result = spins(spinning())
assert code == 0 and result["verdict"] == "passed" and result["relative"] < 1e-9 and result["sofa_passes"], text
# q and -q are one orientation, at the start too; to SOFA's own criterion they are two
for sign in (lambda q: -1 if q[3] < 0 else 1, lambda q: -1):
    code, text, result = spins(spinning(sign=sign))
    assert code == 0 and result["relative"] < 1e-9 and result["sofa"] > 1e-2 and not result["sofa_passes"], text
# the angle 1 % off: at the end by 0.099 rad, of at most half a turn; the drift is right
code, text, result = spins(spinning(rate=1.01))
assert code == 1 and result["verdict"] == "failed" and result["relative_of"]["positions"] < 1e-9, text
assert abs(result["largest_of"]["orientations"] - 0.01 * 0.6 * sum(c * c for c in SPIN) ** 0.5) < 1e-6, text
assert result["relative"] == result["relative_of"]["orientations"] > 0.02 and "rad" in text, text
# 6 mm of drift off by 10 %, beside half a turn that is right
code, text, result = spins(spinning(way=1.1))
assert code == 1 and result["relative_of"]["orientations"] < 1e-9 and abs(result["relative"] - 0.1 / 1.1) < 1e-6, text
for wrong, word in ((as_json(spinning()).replace("0.6, ", "NaN, ", 1), "JSON"), (spinning(late=1), "relative"),
                    ({t: [[*x[0][:3], x[0][6], *x[0][3:6]]] for t, x in spinning().items()}, "relative"),
                    ({t: [[*x[0][:3], *(1.1 * c for c in x[0][3:])]] for t, x in spinning().items()}, "quaternion of frame 0 has the length 1.1")):
    code, text, result = spins(wrong)
    assert code == 1 and result["verdict"] == "failed" and word in text, text
assert spins(spinning(2), 2)[0] == 0
code, text, result = spins({t: x[::-1] for t, x in spinning(2).items()}, 2)
assert code == 1 and result["verdict"] == "failed", text

# SOFA numbers the states that an integrator moves, from the top down, and those that follow only if the list asks for them; its newer
# program leaves the outermost node's own out. Here all have one name, and most one size
def named(y, n=1):
    return f'<MechanicalObject name="dofs" position="{"  ".join(f"{i} {y} 0" for i in range(n))}"/><UniformMass totalMass="{n}"/>'


SOLVED = "<EulerImplicitSolver/><SparseLDLSolver/>"
SEVERAL = ('<Node name="root" gravity="0 -10 0" dt="0.01"><Node name="floor"><MechanicalObject name="dofs" position="0 7 0"/></Node>'
           f'<Node name="a">{SOLVED}{named(1)}<Node name="tip"><MechanicalObject name="dofs" position="0 1 0"/><IdentityMapping/></Node></Node>'
           f'<Node name="b">{SOLVED}{named(3)}<FixedConstraint indices="0"/></Node></Node>')
TOP = f'<Node name="root" gravity="0 -10 0" dt="0.01">{SOLVED}{named(1)}<Node name="a">{named(3)}</Node></Node>'


def stored(y, falls=True):
    return as_json({round(k * H, 10): [[0, y - falls * 10 * H * H * k * (k + 1) / 2, 0]] for k in range(STEPS)})


for scene, mapped, files, good in (
        (SEVERAL, 0, {"mstate_0_dofs.json.gz": stored(1), "mstate_1_dofs.json.gz": stored(3, False)}, True),
        (SEVERAL, 0, {"mstate_1_dofs.json.gz": stored(1), "mstate_0_dofs.json.gz": stored(3, False)}, False),
        (SEVERAL, 1, {"mstate_0_dofs.json.gz": stored(1), "mstate_1_dofs.json.gz": stored(1), "mstate_2_dofs.json.gz": stored(3, False)}, True),
        (TOP, 0, {"mstate_0_dofs.json.gz": stored(3)}, True), (TOP, 0, {"mstate_0_dofs.json.gz": stored(2)}, False),
        (TOP, 0, {f"{i}_dofs_mstate.txt.gz": as_text({k * H: [[0, y - 10 * H * H * k * (k + 1) / 2, 0]] for k in range(STEPS)}) for i, y in ((0, 1), (1, 3))},
         True)):
    code, text, result = run(files, None, scene, line=f"Mass/fall.scn {STEPS} 1e-4 {mapped}")
    assert (code == 0 and result["verdict"] == "passed") == good, (mapped, text)

# a list says what it means, or nothing is run
good = as_json(frames()), "mstate_0_dofs.json.gz"
for line in ("Mass/fall.scn 11 1e-4", "Mass/fall.scn 11 1e-4 1 0 0", "Mass/fall.scn 11 1e-4 1 1 0.05"):
    code, text, result = run(*good, line=line)
    assert code == 0 and result["verdict"] == "passed" and "ends at" not in text, f"{line}: {text}"
for line, word in (("Mass/fall.scn eleven 1e-4 1", "'eleven' is no number of steps"), ("Mass/fall.scn 11 nan 1", "'nan' is no tolerance"),
                   ("Mass/fall.scn 11 1e-4 2", "'2' is neither 0 nor 1"), ("Mass/fall.scn 11 1e-4 1 0 x", "'x' is no period"),
                   ("Mass/fall.scn 11.5 1e-4", "'11.5' is no number of steps"), ("Mass/fall.scn 0 1e-4", "'0' is no number of steps"),
                   ("Mass/fall.scn 11 -1", "'-1' is no tolerance"), ("Mass/fall.scn 11", "has 2 words"),
                   ("Mass/fall.scn 11 1e-4 1 0 0.1 7", "has 7 words"), ("Mass/fall.scn 11 1e-4 1 yes", "'yes' is neither 0 nor 1")):
    code, text, result = run(*good, line=line)
    assert code == 2 and word in text and "regression-tests:3" in text and "SCENE STEPS EPSILON" in text, f"{line}: {code} {text}"
code, text, result = run(*good, line="Mass/lost.scn 11 1e-4")
assert code == 1 and "lost.scn is not there" in text, text

# a reference that ends before the list's last step: said, unless a period explains it
some = {t: x for k, (t, x) in enumerate(frames().items()) if k % 5 == 0}
for reference, line, ends in ((frames(), "20 1e-4", "t = 0.1, and 20 steps at t = 0.19"), (frames(), "20 1e-4 1 0 0.1", ""),
                              (some, "14 1e-4", ""), (some, "16 1e-4", "t = 0.1,"), (some, "11 1e-4 1 1", ""),
                              (some, "14 1e-4 1 1", "t = 0.1,"), (some, "14 1e-4 1 0 0.02", "t = 0.1,")):
    code, text, result = run(as_json(reference), "mstate_0_dofs.json.gz", line="Mass/fall.scn " + line)
    assert code == 0 and result["verdict"] == "passed", text
    assert (ends in text and ends in result["remark"]) if ends else "ends at" not in text, f"{line}: {text}"

# a folder holds lists; those of topologies have no states
for where in ("examples", "."):
    code, text, result = run(*good, where=where)
    assert code == 0 and "1 passed, 0 failed" in text and "1 of topologies left out" in text, text
code, text, result = run(*good, where="references")
assert code == 2 and "a folder without lists of SOFA" in text, text

for option, word in (("--update", "update"), ("--bits", "bits"), ("--threads=1", "threads")):
    code, text, result = run(*good, more=[option])
    assert code == 2 and f"--{word} is of the project's own lists" in text, text

# nobody can match it: neither passed nor failed
wrong = as_json({round(k * 0.01, 10): [[0, 0, 0], [1, -1 if k > 40 else 0, 0], [2, 0, 0]] for k in range(60)})
code, text, result = run(wrong, "mstate_0_dofs.json.gz", CHAOS)
assert code == 0 and result["verdict"] == "undecided" and result["sensitivity"] > 1e-3, text

# a pendulum that stands on its head: moved by 1e-9 rad at the start it falls, to a side that no program knows
UPRIGHT = ('<Node name="root" gravity="0 -3000 0" dt="0.01"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" '
           'template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass vertexMass="1 1 1 0 0 0 1 0 0 0 1"/><PartialFixedProjectiveConstraint '
           'indices="0" fixedDirections="1 1 1 0 0 0"/><Node name="bob"><MechanicalObject name="bob" position="0 1 0"/>'
           '<UniformMass totalMass="1"/><RigidMapping/></Node></Node>')
fallen = as_json({round(k * H, 10): [[0, 0, 0, 0, 0, *((0, 1) if k < 50 else (0.6, 0.8))]] for k in range(60)})
code, text, result = run(fallen, "mstate_0_dofs.json.gz", UPRIGHT, line="Mass/fall.scn 60 1e-4 1 0")
assert code == 0 and result["verdict"] == "undecided" and result["sensitivity"] > 1e-3, text

# a folder of scenes
with tempfile.TemporaryDirectory() as folder:
    for name, scene in {"good.scn": SCENE, "drawn.scn": SCENE.replace("<Euler", "<VisualStyle/><Euler"),
                        "missing.scn": SCENE.replace("<Euler", "<Strange/><Other/><Euler"),
                        "lost.scn": SCENE.replace("<Euler", "<Strange/><Euler"), "broken.scn": "<Node"}.items():
        with open(os.path.join(folder, name), "w") as out:
            out.write(scene)
    done = subprocess.run([STROMA, "check", "--sofa", folder, "--jobs", "2", "--limit", "600"], capture_output=True, text=True, timeout=1800)
    text = done.stdout
    for line in ("good.scn: runs as it is", "drawn.scn: runs without VisualStyle", "missing.scn: cannot run because",
                 "broken.scn: cannot run because", "5 scenes: 1 run as they are, 1 run without what has no effect, 3 cannot run"):
        assert line in text, f"'{line}' is missing:\n{text}"
    assert "    2     1  Strange" in text and "    1     0  Other" in text, text
    for wrong in (["--jobs", "0"], ["--jobs=-1"], ["--limit", "nan"], ["--limit=-5"], ["--steps=-1"]):
        done = subprocess.run([STROMA, "check", "--sofa", folder, *wrong], capture_output=True, text=True, timeout=1800)
        assert done.returncode == 2 and "expected" in done.stderr, f"{wrong}: {done.returncode} {done.stderr}"

# scenes in Python are loaded, as far as `stroma check` goes; other files in Python are none
with tempfile.TemporaryDirectory() as folder:
    scene = 'def createScene(root):\n    print("{")\n    root.addObject("%s")\n'
    for name, text in {"good.scn": SCENE, "it's good.py": scene % "DefaultAnimationLoop", "missing.py": scene % "Strange", "helper.py": "x = 1\n",
                       "list": "good.scn\nmissing.py\n"}.items():
        with open(os.path.join(folder, name), "w") as out:
            out.write(text)
    for where, lines in ((folder, ("it's good.py: loads", "missing.py: cannot run because /Strange: there is no component 'Strange'",
                                   "3 scenes: 1 run as they are, 0 run without what has no effect, 1 in Python load (stroma run makes their "
                                   "steps), 1 cannot run")),
                         (os.path.join(folder, "list"), ("good.scn: runs as it is", "missing.py: cannot run", "2 scenes: 1 run as they are"))):
        done = subprocess.run([STROMA, "check", "--sofa", where, "--limit", "600"], capture_output=True, text=True, timeout=1800)
        for line in lines:
            assert line in done.stdout, f"'{line}' is missing:\n{done.stdout}{done.stderr}"
    done = subprocess.run([STROMA, "check", "--sofa", os.path.join(folder, "missing.py")], capture_output=True, text=True, timeout=1800)
    assert done.returncode == 2 and "is one scene" in done.stderr, done.stderr

# one that does not end takes processor time, is given up by it, and leaves no process behind
with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, "endless.py")
    with open(path, "w") as out:
        out.write("def createScene(root):\n    while True:\n        pass\n")
    done = subprocess.run([STROMA, "check", "--sofa", folder, "--limit", "3"], capture_output=True, text=True, timeout=1800)
    assert "endless.py: cannot run because abandoned after 3 s of processor time" in done.stdout, done.stdout + done.stderr

    def still_runs():
        for process in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{process}/cmdline") as words:
                    if path in words.read():
                        return True
            except OSError:  # it has ended meanwhile
                pass
        return False
    deadline = time.monotonic() + 60
    while still_runs() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not still_runs(), "the scene goes on by itself"
print("passed")
