# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma explain --quirks`: how much each of SOFA's ways changes a scene, against closed forms. Usage: test_explain_quirks.py STROMA"""
import json
import os
import subprocess
import sys
import tempfile

STROMA = os.path.abspath(sys.argv[1])
SOLVER = "<EulerImplicitSolver/><SparseLDLSolver/>"
STONE = SOLVER + '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="2"/>'
# a child's gravity does not count in SOFA: y = -g h^2 n (n + 1) / 2 with 10 or with 25, so that 60 % of the way is the quirk
GRAVITY = f'<Node name="root" gravity="0 -10 0" dt="0.01"><Node name="child" gravity="0 -25 0">{STONE}</Node></Node>'
# frames with a fixed inertia turn by w t about a fixed axis, and others tumble; their centres rest
TUMBLES = (f'<Node name="root" gravity="0 0 0" dt="0.01">{SOLVER}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" '
           'velocity="0 0 0 5 1 0.5"/><UniformMass vertexMass="1 1 0.1 0 0 0 0.2 0 0 0 0.4"/></Node>')
# two masses of one state, which only SOFA's dialect takes; what falls does not depend on them
MASSES = GRAVITY.replace('<UniformMass totalMass="2"/>', '<UniformMass totalMass="2"/><UniformMass totalMass="3"/>')


def explain(scene, *more, name="scene.scn"):
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, name), "w") as out:
            out.write(scene)
        done = subprocess.run([STROMA, "explain", name, *more], cwd=folder, capture_output=True, text=True, timeout=600)
        assert os.listdir(folder) == [name], "it leaves a file behind"
        return done.returncode, done.stdout, done.stderr


def effects(scene, *more):
    code, out, err = explain(scene, "--quirks", "--json", *more)
    assert code == 0, err
    found = json.loads(out)
    shares = [each["share"] for each in found["quirks"] if "share" in each]
    assert shares == sorted(shares, reverse=True), out
    return found, {each["quirk"]: each for each in found["quirks"]}


found, ways = effects(GRAVITY, "-n", "12")
assert found["steps"] == 12 and abs(found["time"] - 0.12) < 1e-12, found
assert abs(ways["child-gravity"]["share"] - 0.6) < 1e-9 and ways["child-gravity"]["where"] == "node 0 of /child/dofs", ways
assert found["quirks"][0]["quirk"] == "child-gravity" and abs(found["without_any"]["share"] - 0.6) < 1e-9, found

found, ways = effects(TUMBLES)
assert ways["fixed-inertia"]["share"] > 0.1 and ways["fixed-inertia"]["where"] == "orientation 0 of /dofs", ways
code, out, err = explain(TUMBLES, "--quirks", "-n", "20", "--without-quirk", "fixed-inertia")
assert (code == 2 and "has none of SOFA's ways" in err) or "fixed-inertia:" not in out, out + err

found, ways = effects(MASSES, "-n", "5")
assert "has two masses" in ways["added-masses"]["refused"] and found["quirks"][0]["quirk"] == "added-masses", ways
code, out, err = explain(MASSES, "--quirks", "-n", "5")
assert code == 0 and out.startswith("After 5 steps (-n), at t = 0.05") and "\n  refused  added-masses: " in out and "\n     60 %  child-gravity: " in out, out

for scene, more, word in ((GRAVITY, ["--quirks", "-n", "0"], "at least one step"), (GRAVITY, ["-n", "5"], "of --quirks")):
    code, out, err = explain(scene, *more)
    assert code == 2 and word in err, f"{more}: {code} {err}"
code, out, err = explain(GRAVITY, "--quirks", name="scene.xml")
assert code == 2 and "has none of SOFA's ways" in err, err
code, out, err = explain("<Node name='root'><Nothing/></Node>", "--quirks")
assert code == 2 and "Nothing" in err, err
print("passed")
