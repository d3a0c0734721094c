#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma view` seen by pages without a browser: what is shown is the run, and what is done by hand is in the run, to the bit.
Usage: test_protocol.py TREE STROMA [names of tests]"""
import base64
import glob
import gzip
import json
import os
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

from server import PATIENCE, Page, Server
from websocket import Packet, frame_bytes

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])
EXAMPLES = sorted(glob.glob(os.path.join(TREE, "scenes", "examples", "*.xml")))
LONGEST = 2 * PATIENCE  # of a command that a test waits for


def example(name):
    """Path of an example scene."""
    return os.path.join(TREE, "scenes", "examples", name)


GRID = """<Node gravity="0 -9.81 0" dt="0.01"><EulerImplicitSolver/><CGLinearSolver iterations="100" tolerance="1e-9" threshold="1e-9"/>
  <RegularGridTopology n="{n} {n} {n}" min="0 0 0" max="0.1 0.1 0.1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>
  <HexahedronFEMForceField name="fem" youngModulus="2e4" poissonRatio="0.3" method="large"/><FixedProjectiveConstraint indices="0 1 2"/></Node>
"""
FINE = GRID.replace('<EulerImplicitSolver/><CGLinearSolver iterations="100" tolerance="1e-9" threshold="1e-9"/>', "<EulerExplicitSolver/>").replace(
    'dt="0.01"', 'dt="1e-4"')  # many nodes, quick steps


def command(*arguments, expected=0, cwd=None, **options):
    """Output and messages of the command, which runs in a folder that is gone afterwards, or in the one named."""
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run([STROMA, *arguments], capture_output=True, text=True, cwd=cwd or folder, timeout=LONGEST, **options)
    assert result.returncode == expected, (arguments, result)
    return result.stdout, result.stderr


def write(folder, name, text):
    """Path of a new file."""
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def contents(folder):
    """{path: bytes} of all files below."""
    out = {}
    for root, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(root, name), "rb") as file:
                out[os.path.join(root, name)] = file.read()
    return out


def all_packets_of_page(path):
    """What an exported page plays."""
    with open(path, encoding="utf-8") as file:
        parts = json.loads(re.search(r'<script type="application/json" id="stroma-recording">(.*?)</script>', file.read(), re.S).group(1))
    packets = []
    for part in parts["packets"]:
        data, at = gzip.decompress(base64.b64decode(part, validate=True)), 0
        while at < len(data):
            length, = struct.unpack_from("<I", data, at)
            packets.append(Packet(data[at + 4:at + 4 + length]))
            at += 4 + length
        assert at == len(data)
    return packets


def packets_of_page(path):
    """Scene and frames that an exported page plays."""
    packets = all_packets_of_page(path)
    assert [packet["is"] for packet in packets[:2]] == ["scene", "held"]
    return packets[0], [packet for packet in packets if packet["is"] == "frame"]


def positions_in(frame, body=0):
    """x of a picture of a page, one row per node, and the widest side of its box."""
    low, high = numpy.split(numpy.array(frame["boxes"][body]), 2)
    return low + frame.arrays[f"{body}.x"].reshape(-1, 3) / 65535.0 * (high - low), (high - low).max()


def hash_of_run(scene, steps, *options):
    """State of `stroma run` after so many steps."""
    output, _ = command("run", scene, "-n", str(steps), "-q", "--no-record", "--json", *options)
    return json.loads(output)["state_hash"]


def replayed_hash(page, scene, steps, *options):
    """State of a run that repeats what the pages did."""
    actions = page.tell("actions")
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, actions["name"])
        with open(file, "w", encoding="utf-8") as out:
            out.write(actions["text"])
        return hash_of_run(scene, steps, "--replay", file, *options)


def check_scene(test, packet):
    """Numbers of a scene packet agree with each other."""
    for number, body in enumerate(packet["bodies"]):
        of = lambda name, number=number: packet.arrays.get(f"{number}.{name}", numpy.zeros(0))
        nodes, surface = body["nodes"], body["surface"]
        test.assertEqual(len(of("node")), nodes)
        test.assertEqual(len(of("rest")), 3 * nodes)
        test.assertTrue(numpy.isfinite(of("rest")).all())
        test.assertEqual(len(set(of("node"))), nodes, "a node comes twice")
        for name in ("triangles", "edges", "points"):
            used = of(name)
            test.assertTrue(((used >= 0) & (used < surface)).all() if len(used) else True, f"{name} of {body['path']}")
        solid = [node for beam in body["beams"] for node in beam[:2]] + [ball[0] for ball in body["balls"]]
        drawn = numpy.concatenate([of(name) for name in ("triangles", "edges", "points")] + [solid])
        test.assertEqual(len(numpy.unique(drawn)), surface, f"the surface of {body['path']} is what is drawn")
        test.assertEqual(len(of("owner")) * 3, len(of("triangles")))
        test.assertGreater(body["size"], 0)
        test.assertEqual(body["interactive"], not body.get("why"), body)


class EveryExample(unittest.TestCase):
    """One server a scene."""

    def test_shows_runs_pauses_steps_and_resets(self):
        for scene in EXAMPLES:
            with self.subTest(os.path.basename(scene)), Server(STROMA, scene, "--paused") as server:
                page = server.page()
                check_scene(self, page.scene)
                page.picture(0)
                start = page.hash()
                self.assertEqual(start, (0, hash_of_run(scene, 0)))
                for body, described in enumerate(page.scene["bodies"]):
                    self.assertEqual(page.positions(body).shape, (described["surface"], 3))
                page.do("step", count=2)
                self.look_at_everything(page)
                page.do("step", count=2)
                page.picture(4)
                self.assertEqual(page.hash(), (4, hash_of_run(scene, 4)))
                # 500 steps a second: as fast as it can, a scene of quick steps is at its end while the test waits for its turn
                page.do("pace", pace="real", factor=page.status["dt"] / 0.002)
                page.do("run")
                page.until(lambda: page.status["step"] > 5 or page.status["ended"], "steps")
                self.assertEqual(page.status["ended"], "")
                page.pause()
                page.do("reset")
                page.picture(0)
                self.assertEqual(page.hash(), start)
                self.assertFalse([line for line in page.messages if line["severity"] == "error"])

    def look_at_everything(self, page):
        """All nodes, fields, loads and values: none of it may change a bit of the run."""
        fields = page.scene["fields"]  # those of cells are known after the first step
        page.do("want", nodes="all", fields=[field["id"] for field in fields], loads=True, format="f32", fps=240)
        page.do("watch", values=["energy", "solver"])
        page.until(lambda: page.frame["nodes"] == "all" and "energy.kinetic" in page.frame["values"]
                   and all(f"f{field['id']}" in page.frame.arrays for field in fields), "all fields")
        for body, described in enumerate(page.scene["bodies"]):
            self.assertEqual(page.positions(body).shape, (described["nodes"], 3))
            rest = page.scene.arrays[f"{body}.rest"].reshape(-1, 3)
            self.assertLess(abs(page.positions(body) - rest).max(), described["size"])
        for field in fields:
            body = page.scene["bodies"][field["body"]]
            length = body["nodes"] if field["on"] == "nodes" else sum(body["cells"].values())
            values = page.frame.arrays[f"f{field['id']}"]
            self.assertEqual(len(values), length, field)
            # NaN is of cells that the force field does not have, in a body with cells of several kinds
            is_mixed = field["on"] == "cells" and sum(count > 0 for count in body["cells"].values()) > 1
            self.assertTrue((numpy.isfinite if not is_mixed else lambda v: ~numpy.isinf(v))(values).all(), field)
            self.assertTrue(numpy.isfinite(values).any(), field)
        page.until(lambda: page.cells is not None or not any(sum(body["cells"].values()) for body in page.scene["bodies"]), "cells")


class Run(unittest.TestCase):
    """Time and numbers of one run."""

    def test_a_viewed_run_has_the_bits_of_one_that_nobody_sees(self):
        scene = example("organ.xml")
        with Server(STROMA, scene) as server:
            page = server.page()
            fields = [field["id"] for field in page.scene["fields"]]
            page.do("want", nodes="all", fields=fields, loads=True, format="u16", fps=240)
            page.do("watch", values=["energy", "solver", "node.0.3.position", "node.0.3.velocity", "node.0.3.reaction"])
            page.do("pace", pace="fast", factor=1)
            page.until(lambda: page.status["step"] > 150, "150 steps")
            page.pause()
            step, state = page.hash()
            self.assertEqual(state, hash_of_run(scene, step))
            # a picture of before the pause is of no step that stayed: it has no reactions
            page.until(lambda: "node.0.3.reaction.x" in page.frame["values"], "the picture of the pause")
            for name in ("position", "velocity", "reaction"):
                for axis in "xyz":
                    self.assertIn(f"node.0.3.{name}.{axis}", page.frame["values"])
            text = server.end()
            self.assertIn(state, text)

    def test_positions_in_16_bits_are_near_those_in_32(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            page = server.page()
            page.do("step", count=5)
            exact = page.positions() if page.picture(5)["format"] == "f32" else None
            page.do("want", nodes="surface", format="u16")
            page.until(lambda: page.frame["format"] == "u16", "short positions")
            extent = numpy.ptp(exact, axis=0).max()
            error = abs(page.positions() - exact).max()
            self.assertLess(error, extent / 65535)
            self.assertGreater(error, 0)

    def test_real_time_is_kept_and_the_factor_slows_it(self):
        """The run is never before the clock by more than two steps. How far it stays behind is up to the machine: that is not judged."""
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            page = server.page()
            for factor in (1, 0.25):
                page.do("pace", pace="real", factor=factor)
                before, began = page.status["time"], time.monotonic()
                page.do("run")
                page.until(lambda before=before, factor=factor: page.status["time"] > before + 0.5 * factor, "half a second")
                page.pause()
                passed = time.monotonic() - began
                simulated = page.status["time"] - before
                self.assertLess(simulated, factor * passed + 0.041)

    def test_energies_are_those_of_the_run(self):
        with Server(STROMA, example("organ_static.xml"), "--paused") as server:
            page = server.page()
            page.do("watch", values=["energy", "solver"])
            page.do("step", count=1)
            page.until(lambda: page.frame["step"] == 1 and "newton" in page.frame["values"], "values")
            values = page.frame["values"]
            summary = json.loads(command("run", example("organ_static.xml"), "-n", "1", "-q", "--no-record", "--json")[0])
            for name, value in summary["energies"]["end"].items():
                self.assertEqual(values[f"energy.{name}"], value)
            self.assertEqual(values["newton"], summary["newton"]["iterations"])

    def test_reactions_carry_the_weight(self):
        """Statics: reactions of the held nodes, weight and load cancel."""
        with Server(STROMA, example("organ_static.xml"), "--paused", "--set", "/organ/solver.newton_iterations=60") as server:
            page = server.page()
            page.do("want", nodes="all", loads=True)
            page.do("step", count=1)
            page.until(lambda: page.frame["step"] == 1 and "0.load" in page.frame.arrays, "loads")
            page.until(lambda: page.held is not None, "held nodes")
            nodes = page.scene.arrays["0.node"][page.held.arrays["0.held"]]
            load = page.frame.arrays["0.load"].reshape(-1, 3).astype(float).sum(axis=0)
            numpy.testing.assert_allclose(load, [2, -2, 0], atol=1e-5)
            total = numpy.zeros(3)
            for first in range(0, len(nodes), 60):
                some = [f"node.0.{node}.reaction" for node in nodes[first:first + 60]]
                page.do("watch", values=some)
                page.until(lambda some=some: some[-1] + ".x" in page.frame["values"], "reactions")
                total += [sum(page.frame["values"][f"{name}.{axis}"] for name in some) for axis in "xyz"]
            self.assertAlmostEqual(total[0], -2, delta=1e-4)
            self.assertAlmostEqual(total[2], 0, delta=1e-4)
            self.assertGreater(total[1], 2)

    def test_questions_are_answered(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            page = server.page()
            tree = page.tell("components")["tree"]
            names = {component["path"]: component for child in tree["children"] for component in child["components"]}
            fem = names["/organ/fem"]
            young = next(one for one in fem["attributes"] if one["name"] == "youngModulus")
            self.assertEqual((young["value"], young["unit"], young["given"]), ("10000", "Pa", True))
            self.assertIn(young["change"], ("at_once", "recompile"))
            method = next(one for one in fem["attributes"] if one["name"] == "method")
            self.assertIn("polar", method["choices"])
            self.assertTrue(any("linear solver /organ/linear" in line for line in page.tell("explain")["lines"]))
            xml = page.tell("xml")
            with open(example("organ.xml"), encoding="utf-8") as file:
                self.assertEqual(xml["text"], file.read())


class Edits(unittest.TestCase):
    """Attributes that change while the scene runs."""

    def test_an_edit_equals_a_run_with_it_from_then_on(self):
        scene = example("organ.xml")
        with Server(STROMA, scene, "--paused") as server:
            page = server.page()
            page.do("step", count=4)
            before = page.hash()
            page.do("set", path="/organ/fem", attribute="youngModulus", value="20000")
            self.assertEqual(page.hash(), before)
            page.do("step", count=3)
            page.do("set", path="/", attribute="gravity", value="0 -5 1")
            page.do("step", count=5)
            step, state = page.hash()
            self.assertEqual(step, 12)
            self.assertNotEqual(state, hash_of_run(scene, 12))
            self.assertEqual(state, replayed_hash(page, scene, 12))
            changed = page.tell("xml")["text"]
            self.assertIn('youngModulus="20000"', changed)
            self.assertIn("<!-- Soft tissue in quasi-static motion", changed)
            # reset keeps the edits: the run is that of the changed scene
            page.do("reset")
            page.do("step", count=6)
            with tempfile.TemporaryDirectory() as folder:
                os.symlink(os.path.join(TREE, "scenes", "meshes"), os.path.join(folder, "meshes"))
                os.mkdir(os.path.join(folder, "examples"))
                file = os.path.join(folder, "examples", "organ.xml")
                with open(file, "w", encoding="utf-8") as out:
                    out.write(changed)
                self.assertEqual(page.hash(), (6, hash_of_run(file, 6)))

    def test_bad_values_are_refused_in_the_words_of_the_command_line(self):
        scene = example("organ.xml")
        with Server(STROMA, scene, "--paused") as server:
            page = server.page()
            page.do("step", count=2)
            before = page.hash()
            for path, attribute, value in (("/organ/fem", "youngModulus", "-5"), ("/organ/fem", "youngModulus", "soft"),
                                           ("/organ/fem", "poissonRatio", "0.7"), ("/", "gravity", "down"), ("/", "dt", "0")):
                told = page.refused("set", path=path, attribute=attribute, value=value)
                _, errors = command("run", scene, "-n", "1", "-q", "--set", f"{path}.{attribute}={value}", expected=2)
                # both name what was expected, in the same words
                expected = re.search(r"\(expected ([^;)]*)", told)
                self.assertTrue(expected, told)
                if attribute != "dt":  # whose range is told in other words when a scene is loaded
                    self.assertIn(expected.group(1), errors)
            for path, attribute, part in (("/organ/fm", "youngModulus", "fem"), ("/organ/fem", "youngsModulus", "youngModulus"),
                                          ("/organ/loader", "filename", "load the scene again")):
                self.assertIn(part, page.refused("set", path=path, attribute=attribute, value="1"))
            self.assertEqual(page.hash(), before)
            page.do("step", count=2)
            self.assertEqual(page.hash(), (4, hash_of_run(scene, 4)))


BLOCK = """<Node name="root" gravity="0 0 0" dt="1"><Node name="block">
  <StaticSolver newton_iterations="30" relative_residual_tolerance_threshold="1e-13" absolute_residual_tolerance_threshold="1e-13"/>
  <SparseLDLSolver/><RegularGridTopology n="3 3 7" min="0 0 0" max="0.1 0.1 0.3"/><MechanicalObject name="dofs"/>
  <HexahedronFEMForceField name="fem" youngModulus="2000" poissonRatio="0.3" method="large"/>
  <BoxROI name="roi" box="-1 -1 -0.001 1 1 0.001"/><FixedProjectiveConstraint indices="@roi.indices"/>
  {}
</Node></Node>"""


class Hands(unittest.TestCase):
    """Pull, hold, push: by the engine's inputs."""

    def still_positions(self, page):
        """x of every node after the step, in double precision: as watched values."""
        places = []
        for first in range(0, page.scene["bodies"][0]["nodes"], 60):
            some = [f"node.0.{node}.position" for node in range(first, min(first + 60, page.scene["bodies"][0]["nodes"]))]
            page.do("watch", values=some)
            page.until(lambda some=some: some[-1] + ".x" in page.frame["values"], "positions")
            places += [[page.frame["values"][f"{name}.{axis}"] for axis in "xyz"] for name in some]
        return numpy.array(places)

    def test_the_shown_force_is_the_force_that_holds_the_body_there(self):
        """A static pull, and the same body under a ConstantForceField of the force that the view shows."""
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "block.xml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write(BLOCK.format(""))
            with Server(STROMA, scene, "--paused") as server:
                page = server.page()
                page.picture(0)
                start = self.still_positions(page)
                node = int(numpy.argmax(page.scene.arrays["0.rest"].reshape(-1, 3) @ [1, 1, 1]))
                in_scene = int(page.scene.arrays["0.node"][node])
                target = start[in_scene] + [0.05, 0.01, 0.02]
                page.do("pull", hand="h", body=0, nodes=[node], targets=[list(target)], stiffness=3, sequence=1)
                page.do("step", count=1)
                page.until(lambda: page.frame["step"] == 1 and page.frame["hands"], "the pull")
                hand, pulled = page.frame["hands"][0], self.still_positions(page)
                numpy.testing.assert_allclose(hand["to"], target, rtol=1e-12)
                self.assertEqual((hand["node"], hand["kind"]), (node, "pull"))
            moved = numpy.linalg.norm(pulled[in_scene] - start[in_scene])
            self.assertGreater(moved, 0.01)
            numpy.testing.assert_allclose(hand["force"], 3 * (target - pulled[in_scene]), rtol=1e-9)  # the spring's own law
            force = " ".join(repr(value) for value in hand["force"])
            with open(scene, "w", encoding="utf-8") as file:
                file.write(BLOCK.format(f'<ConstantForceField indices="{in_scene}" totalForce="{force}"/>'))
            with Server(STROMA, scene, "--paused") as server:
                page = server.page()
                page.do("step", count=1)
                page.picture(1)
                self.assertLess(abs(self.still_positions(page) - pulled).max(), 1e-6 * moved)

    def test_hands_are_replayed_to_the_bit(self):
        scene = example("organ.xml")
        with Server(STROMA, scene, "--paused") as server:
            page = server.page()
            rest = page.scene.arrays["0.rest"].reshape(-1, 3)
            place = [float(value) for value in rest[5]]
            page.do("step", count=3)
            for k in range(4):
                target = [place[0] + 0.004 * k, place[1], place[2]]
                page.do("pull", hand="a", body=0, nodes=[5], targets=[target], sequence=k)
                page.do("step", count=2)
            page.do("pull", kind="hold", hand="b", body=0, nodes=[1, 2], targets=[list(map(float, rest[i])) for i in (1, 2)])
            page.do("force", hand="c", body=0, nodes=[7, 8], force=[0, 0.1, 0])
            page.do("step", count=2)
            page.do("release", hand="a")
            centre, radius = [float(value) for value in rest.mean(axis=0)], 0.3 * page.scene["bodies"][0]["size"]
            page.do("push", hand="d", body=0, centre=centre, radius=radius, sequence=9)
            page.do("step", count=1)
            page.until(lambda: page.frame["step"] == 14, "the push")
            kinds = {hand["hand"]: hand for hand in page.frame["hands"]}
            self.assertEqual({name: hand["kind"] for name, hand in kinds.items()}, {"b": "hold", "c": "force", "d": "push"})
            self.assertGreater(kinds["d"]["touched"], 0)
            numpy.testing.assert_allclose(kinds["c"]["force"], [0, 0.1, 0], atol=1e-12)
            for name in "bcd":
                page.do("release", hand=name)
            page.do("step", count=6)
            step, state = page.hash()
            self.assertEqual(step, 20)
            self.assertNotEqual(state, hash_of_run(scene, 20))
            self.assertEqual(state, replayed_hash(page, scene, 20))

    def test_an_order_is_in_the_second_picture_after_it_at_the_latest(self):
        """No more than one picture that was made before it comes after the word that the order is carried out."""
        with Server(STROMA, example("organ.xml")) as server:
            page = server.page()
            page.do("pace", pace="fast")
            page.picture()
            place = [float(value) for value in page.scene.arrays["0.rest"].reshape(-1, 3)[0]]
            own = str(page.scene["client"])
            for k in range(1, 40):
                page.do("pull", hand="a", body=0, nodes=[0], targets=[[place[0] + 1e-4 * k, place[1], place[2]]], sequence=k)
                page.pictures(2)
                self.assertEqual(page.frame["applied"].get(own), k)

    def test_a_run_that_never_paused_is_replayed_to_the_bit(self):
        scene = example("organ.xml")
        with Server(STROMA, scene) as server:
            page = server.page()
            page.do("pace", pace="fast", factor=1)
            place = [float(value) for value in page.scene.arrays["0.rest"][:3]]
            for k in range(30):
                page.do("pull", hand="a", body=0, nodes=[0], targets=[[place[0] + 0.001 * k, place[1], place[2]]], sequence=k)
                page.pictures(k % 3)
            page.until(lambda: page.frame["applied"].get(str(page.scene["client"])) == 29, "the last place of the hand")
            page.do("release", hand="a")
            page.do("set", path="/organ/solver", attribute="rayleighMass", value="0.3")
            page.pictures(5)
            page.pause()
            step, state = page.hash()
            self.assertEqual(state, replayed_hash(page, scene, step))

    def test_what_a_hand_cannot_take_is_refused(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            page = server.page()
            nodes = page.scene["bodies"][0]["nodes"]
            good = {"hand": "h", "body": 0, "nodes": [1], "targets": [[0, 0, 0]]}
            for wrong in ({"body": 1}, {"body": -1}, {"nodes": []}, {"nodes": [nodes]}, {"nodes": [-1]}, {"nodes": [1, 1]},
                          {"targets": []}, {"targets": [[0, 0]]}, {"targets": [[0, 0, 1e300]]}, {"stiffness": 0},
                          {"stiffness": -1}, {"stiffness": 1e300}, {"kind": "tear"}):
                page.refused("pull", **{**good, **wrong})
            page.refused("push", hand="p", body=0, centre=[0, 0, 0], radius=0)
            page.refused("force", hand="f", body=0, nodes=[1], force=[0, 0])
            page.do("step", count=2)
            self.assertEqual(page.hash(), (2, hash_of_run(example("organ.xml"), 2)))


class Audience(unittest.TestCase):
    """Several pages, slow pages, pages that go."""

    def test_one_page_has_control_and_another_takes_it(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            first, second = server.page(), server.page()
            second.until(lambda: second.status.get("clients") == 2, "both to be counted")
            self.assertEqual(second.status["control"], first.scene["client"])
            self.assertIn("control", second.refused("step", count=1))
            self.assertIn("control", second.refused("set", path="/organ/fem", attribute="youngModulus", value="1"))
            first.do("step", count=1)
            second.picture(1)
            numpy.testing.assert_array_equal(second.positions(), first.positions() if first.picture(1) else None)
            self.assertEqual(second.hash(), first.hash())  # questions need no control
            second.do("control")
            first.until(lambda: first.status["control"] == second.scene["client"], "control to be taken")
            first.refused("run")
            second.do("step", count=1)
            second.socket.close()
            first.until(lambda: first.status["control"] is None and first.status["clients"] == 1, "control to be free")
            first.do("step", count=1)
            self.assertEqual(first.hash()[0], 3)

    def test_what_a_page_that_goes_has_left_waiting_is_not_done(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            first, second = server.page(), server.page()
            place = [float(value) for value in first.scene.arrays["0.rest"].reshape(-1, 3)[0]]
            first.socket.send({"do": "step", "count": 1500})
            first.socket.send({"do": "pull", "hand": "h", "body": 0, "nodes": [0], "targets": [place]})
            second.until(lambda: second.status["step"] > 0, "the steps to begin")  # what is not read yet may be lost with the page
            first.socket.close()
            second.until(lambda: second.status.get("control") is None, "the page to be gone")
            step, _ = second.hash()
            self.assertEqual(step, 1500)
            second.do("step", count=1)
            second.until(lambda: second.frame["step"] == 1501, "a step")
            self.assertEqual(second.frame["hands"], [])

    def test_who_loses_control_lets_go(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            first, second = server.page(), server.page()
            place = [float(value) for value in first.scene.arrays["0.rest"].reshape(-1, 3)[0]]
            first.do("pull", hand="h", body=0, nodes=[0], targets=[place])
            second.until(lambda: second.frame and second.frame["hands"], "the hand")
            second.do("control")
            second.until(lambda: not second.frame["hands"], "the hand to let go")
            first.refused("release", hand="h")

    def test_the_first_packet_of_a_page_is_the_scene(self):
        with Server(STROMA, example("organ.xml"), "--fps", "240") as server:
            server.page().do("pace", pace="fast")
            for _ in range(20):
                page = Page(server, hello=False)
                server.pages.append(page)
                seen = []
                take, page.take_packet = page.take_packet, lambda packet: (seen.append(packet["is"]), take(packet))
                page.hello()
                page.until(lambda: page.frame is not None, "a picture")
                self.assertEqual(seen[0], "scene", seen)
                self.assertLess(seen.index("held"), seen.index("frame"), seen)
                page.socket.close()

    def test_a_page_that_goes_lets_go(self):
        """Its hands end; the run goes on; it finds it again."""
        with Server(STROMA, example("organ.xml")) as server:
            page = server.page()
            build = page.scene["build"]
            place = [float(value) for value in page.scene.arrays["0.rest"][:3]]
            page.do("pull", hand="a", body=0, nodes=[0], targets=[[place[0] + 0.01, place[1], place[2]]])
            page.until(lambda: page.frame and page.frame["hands"], "the hand")
            page.socket.cut()
            again = server.page(hello=False)
            again.hello(build)
            again.until(lambda: again.status["clients"] == 1, "the other one to be gone")
            step = again.frame["step"]
            again.until(lambda: again.frame["step"] > step + 3, "a picture of what comes after")
            self.assertEqual(again.frame["hands"], [])
            again.pause()
            actions = again.tell("actions")["text"]
            self.assertEqual(len(actions.strip().splitlines()), 3, "one line about the file, a beginning and an end:\n" + actions)

    def test_a_page_of_another_build_is_told_to_load_again(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            page = server.page(hello=False)
            page.socket.send({"do": "hello", "build": "another"})
            page.until(lambda: "reload" in page.last, "the word to load again")

    def test_a_page_that_draws_nothing_slows_nobody_and_nothing_queues(self):
        """Pictures of 100 kB: if they waited for the page that draws none, they would be seen in the memory."""
        with tempfile.TemporaryDirectory() as folder, Server(STROMA, write(folder, "still.xml", FINE.format(n=20).replace("-9.81", "0"))) as server:
            idle, page = server.page(draws=False), server.page()
            idle.do("pace", pace="fast", factor=1)
            idle.do("want", nodes="all", fps=240)
            page.do("want", nodes="all", fps=240)
            page.pictures(60)
            before = server.memory()
            page.pictures(200)
            self.assertGreater(page.frame.bytes, 90000)
            self.assertLess(server.memory() - before, 8 << 20)
            for _ in range(3):  # what is under way to the page comes before the answer, or after the next one
                idle.tell("hash")
            self.assertLessEqual(idle.frames, 2, "more pictures came than may be under way")
            shown = idle.frame["frame"]
            idle.drawn()
            idle.until(lambda: idle.frame["frame"] > shown, "the newest picture")
            idle.drawn()
            idle.until(lambda: idle.frame["frame"] > page.frame["frame"] - 20, "a picture of now")

    def test_a_page_that_does_not_read_slows_nobody(self):
        with Server(STROMA, example("organ.xml")) as server:
            deaf, page = server.page(draws=False), server.page()
            page.do("control")
            page.do("pace", pace="fast", factor=1)
            for number in range(400):  # answers of some size that it never reads
                deaf.socket.send({"do": "components", "request": number})
            before, frames = server.memory(), page.frames
            page.until(lambda: page.frames > frames + 20, "pictures")
            self.assertLess(server.memory() - before, 600 << 20)
            self.assertEqual(server.page().ready, True)

    def test_steps_go_on_between_many_answers(self):
        """Each step waits for a few answers alone, however many are asked for at once; pictures come again with the last one."""
        with Server(STROMA, example("organ.xml")) as server:
            page = server.page()
            page.do("pace", pace="fast", factor=1)
            steps, take = [], page.take_text

            def note(message):
                if message["is"] == "hash":
                    steps.append(message["step"])
                take(message)
            page.take_text = note
            asked = [{"do": "hash"}, *({"do": "components", "request": number} for number in range(1001, 1601)), {"do": "hash", "request": 2000}]
            page.socket.send_bytes(b"".join(frame_bytes(json.dumps(message)) for message in asked))
            page.until(lambda: 2000 in page.replies, "the last answer")
            self.assertGreater(steps[-1], steps[0])
            page.pictures(3)

    def test_nobody_connected_costs_no_pictures(self):
        with Server(STROMA, example("organ.xml")) as server:
            page = server.page()
            page.do("pace", pace="fast", factor=1)
            page.picture()
            number, step = page.frame["frame"], page.frame["step"]
            page.socket.close()
            spent = server.spent()
            while server.spent() < spent + 0.5:  # it steps, however long a busy machine takes for that
                time.sleep(0.05)
            again = server.page()
            again.picture()
            self.assertLess(again.frame["frame"] - number, 20)
            self.assertGreater(again.frame["step"], step)


class Recording(unittest.TestCase):
    """A run that `stroma run --record` wrote."""

    def test_its_instants_are_shown(self):
        scene = example("organ.xml")
        with tempfile.TemporaryDirectory() as folder:
            recorded = os.path.join(folder, "run")
            command("run", scene, "-n", "20", "-q", "--record", recorded, "--record-every", "4")
            with Server(STROMA, scene, "--paused") as server:
                live = server.page()
                wanted = {}
                for step in range(0, 21, 4):
                    if step:
                        live.do("step", count=4)
                    live.picture(step)
                    wanted[step // 4] = live.positions()
            with Server(STROMA, recorded) as server:
                page = server.page()
                self.assertEqual(page.scene["mode"], "recording")
                recording = page.status["recording"]
                self.assertEqual(recording["count"], 6)
                numpy.testing.assert_allclose(recording["times"], [0, 0.08, 0.16, 0.24, 0.32, 0.4], rtol=1e-12)
                for index in (5, 0, 3, 3, 1):
                    page.do("seek", index=index)
                    page.until(lambda index=index: page.frame and page.frame["index"] == index, f"instant {index}")
                    numpy.testing.assert_array_equal(page.positions(), wanted[index])
                    self.assertAlmostEqual(page.frame["time"], 0.08 * index)
                for verb, values in (("seek", {"index": 6}), ("seek", {"index": -1}), ("run", {}), ("step", {}),
                                     ("set", {"path": "/organ/fem", "attribute": "youngModulus", "value": "1"}),
                                     ("pull", {"hand": "h", "body": 0, "nodes": [1], "targets": [[0, 0, 0]]})):
                    page.refused(verb, **values)

    def test_a_viewed_run_is_recorded(self):
        with tempfile.TemporaryDirectory() as folder:
            recorded = os.path.join(folder, "run")
            with Server(STROMA, example("organ.xml"), "--paused", "--record", recorded) as server:
                page = server.page()
                page.do("step", count=3)
                page.do("force", hand="c", body=0, nodes=[7], force=[0, 0.1, 0])
                page.do("step", count=2)
                state = page.hash()[1]
                server.end()
            self.assertEqual(hash_of_run(example("organ.xml"), 5, "--replay", os.path.join(recorded, "run.actions")), state)
            with Server(STROMA, recorded) as server:
                self.assertEqual(server.page().status["recording"]["count"], 6)


class Exports(unittest.TestCase):
    """`stroma view --export`: a page that is written without a browser."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.scene = write(self.folder, "block.xml", GRID.format(n=4))
        self.page = os.path.join(self.folder, "page.html")

    def test_a_run(self):
        command("view", self.scene, "--export", self.page, "-n", "7", "--every", "3")
        scene, frames = packets_of_page(self.page)
        self.assertEqual(scene["mode"], "recording")
        self.assertEqual([frame["step"] for frame in frames], [0, 3, 6])
        with Server(STROMA, self.scene, "--paused") as server:
            live = server.page()
            for frame in frames:
                if frame["step"]:
                    live.do("step", count=3)
                live.picture(frame["step"])
                x, width = positions_in(frame)
                numpy.testing.assert_allclose(x, live.positions(), rtol=0, atol=width / 65535)

    def test_a_recording_is_not_run_anew(self):
        """What was recorded is shown: a run with another stiffness, of which the scene knows nothing."""
        recorded = os.path.join(self.folder, "results", "soft")
        command("run", self.scene, "-n", "9", "-q", "--record", recorded, "--record-every", "2", "--set", "/fem.youngModulus=300")
        before = contents(recorded)
        command("view", recorded, "--export", self.page, "--every", "2")
        _, frames = packets_of_page(self.page)
        numpy.testing.assert_allclose([frame["time"] for frame in frames], [0, 0.04, 0.08], rtol=1e-12)
        with Server(STROMA, recorded) as server:
            viewed = server.page()
            self.assertEqual(viewed.status["recording"]["count"], 6)
            for number, frame in enumerate(frames):
                viewed.do("seek", index=2 * number)
                viewed.until(lambda number=number: viewed.frame["index"] == 2 * number, "the instant")
                x, width = positions_in(frame)
                numpy.testing.assert_allclose(x, viewed.positions(), rtol=0, atol=width / 65535)
        self.assertEqual(contents(recorded), before)

    def test_what_is_too_large_stops_early_and_names_a_stride_that_fits(self):
        """A page of 50 MB takes some 460 pictures of this grid; ten million steps would take a day."""
        scene = write(self.folder, "fine.xml", FINE.format(n=24))
        _, errors = command("view", scene, "--export", self.page, "-n", "10000000", "--inside", "--field", "vonMises", expected=2)
        stride = re.search(r"expected --every (\d+)", errors)
        self.assertTrue(stride, errors)
        self.assertFalse(os.path.exists(self.page))
        self.assertGreater(int(stride.group(1)), 2000)

    def test_a_run_without_a_result_is_no_page(self):
        scene = write(self.folder, "burst.xml", GRID.format(n=3).replace("EulerImplicitSolver", "EulerExplicitSolver").replace('dt="0.01"', 'dt="1"'))
        _, errors = command("view", scene, "--export", self.page, expected=3)
        self.assertIn("no result", errors)
        self.assertFalse(os.path.exists(self.page))

    def test_a_page_that_cannot_be_written_any_more(self):
        """A file may have 100 kB here; the page has more."""
        _, errors = command("view", self.scene, "--export", self.page, "-n", "2", expected=4,
                            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000)))
        self.assertIn("page.html", errors)
        self.assertFalse(os.path.exists(self.page))


class Files(unittest.TestCase):
    """Nothing that is read is written over, and an output that fails is not passed over."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.scene = write(self.folder, "block.xml", GRID.format(n=3))
        self.recorded = os.path.join(self.folder, "rec")
        self.actions = write(self.folder, "run.actions", '{"stroma":"actions","version":1,"scene":"other.xml"}\n'
                             '{"step":1,"set":"/fem","attribute":"youngModulus","value":"9000"}\n')

    def refused(self, *arguments, part="overwrite"):
        """With a sentence, and with every file as it was."""
        before = contents(self.folder)
        _, errors = command("view", *arguments, expected=2, cwd=self.folder)
        self.assertIn(part, errors)
        self.assertEqual(contents(self.folder), before)

    def test_what_is_read_is_not_overwritten(self):
        self.refused("block.xml", "--export", "block.xml")
        self.refused("block.xml", "--export", "./run.actions", "--replay", self.actions)
        self.refused("block.xml", "--no-open", "--record", ".", "--replay", "run.actions")
        os.symlink(self.scene, os.path.join(self.folder, "link.html"))
        self.refused("block.xml", "--export", "link.html")
        command("run", self.scene, "-n", "2", "-q", "--record", self.recorded)
        shutil.copy(self.actions, self.recorded)
        self.refused("block.xml", "--no-open", "--record", "rec", "--replay", "rec/run.actions")
        for name in os.listdir(self.recorded):
            self.refused("rec", "--export", os.path.join("rec", name))

    def test_a_port_that_is_taken_leaves_a_recording(self):
        command("run", self.scene, "-n", "2", "-q", "--record", self.recorded)
        before = contents(self.folder)
        with Server(STROMA, self.scene, "--paused") as server:
            command("view", self.scene, "--no-open", "--port", str(server.port), "--record", self.recorded, expected=2)
        self.assertEqual(contents(self.folder), before)

    def test_actions_of_another_scene_are_noted(self):
        for quiet in ((), ("--quiet",)):
            with Server(STROMA, self.scene, "--paused", "--replay", self.actions, *quiet) as server:
                self.assertEqual("recorded with the scene other.xml" in server.error_text(), not quiet)
                page = server.page()
                page.do("step", count=3)
                self.assertEqual(page.hash()[1], hash_of_run(self.scene, 3, "--replay", self.actions))

    def test_a_recording_of_a_relative_scene_opens_from_elsewhere(self):
        command("run", "block.xml", "-n", "2", "-q", "--record", "results/block", cwd=self.folder)
        recorded = os.path.join(self.folder, "results", "block")
        with Server(STROMA, recorded) as server:
            self.assertEqual(server.page().status["recording"]["count"], 3)
        os.rename(self.scene, os.path.join(recorded, "block.xml"))
        with Server(STROMA, recorded + "/") as server:
            self.assertEqual(server.page().status["recording"]["count"], 3)
        os.remove(os.path.join(recorded, "block.xml"))
        _, errors = command("view", recorded, "--no-open", expected=2)
        self.assertIn("last.checkpoint names the scene block.xml", errors)

    def test_a_recording_that_cannot_grow_ends_the_run(self):
        with Server(STROMA, self.scene, "--paused", "--record", self.recorded, expected=4) as server:
            page = server.page()
            page.do("step", count=2)
            size = max(len(data) for data in contents(self.recorded).values())
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
            page.do("run")
            page.until(lambda: page.status["ended"], "the end of the run")
            self.assertIn(".state.gz", page.status["ended"])
            server.end()

    def test_an_observer_that_cannot_write_ends_the_run(self):
        scene = write(self.folder, "watched.xml", GRID.format(n=3).replace("</Node>", '<WriteState filename="x.state"/></Node>'))
        with Server(STROMA, scene, "--paused", "--outputs", expected=4) as server:
            page = server.page()
            page.do("step", count=2)
            size = os.path.getsize(os.path.join(server.folder, "x.state"))
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
            page.do("run")
            page.until(lambda: page.status["ended"], "the end of the run")
            self.assertIn("x.state", page.status["ended"])
            server.end()

    def test_observers_write_only_when_asked(self):
        write(self.folder, "watched.xml", GRID.format(n=3).replace("</Node>", '<WriteState filename="x.state"/></Node>'))
        out = os.path.join(self.folder, "x.state")
        _, errors = command("view", "watched.xml", "--export", "page.html", "-n", "2", cwd=self.folder)
        self.assertFalse(os.path.exists(out))
        self.assertIn("--outputs", errors)
        command("view", "watched.xml", "--export", "page.html", "-n", "2", "--outputs", cwd=self.folder)
        self.assertTrue(os.path.exists(out))
        self.refused("watched.xml", "--export", "x.state", "--outputs", part="would both write")

    def test_a_failing_output_is_forgiven_when_a_reset_begins_it_anew(self):
        with Server(STROMA, self.scene, "--paused", "--record", self.recorded) as server:
            page = server.page()
            page.do("step", count=2)
            size = max(len(data) for data in contents(self.recorded).values())
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
            page.do("run")
            page.until(lambda: page.status["ended"], "the end of the run")
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            page.do("reset")
            page.do("step", count=1)
            server.end()
        with Server(STROMA, self.recorded) as server:
            self.assertEqual(server.page().status["recording"]["count"], 2)

    def test_a_reset_whose_recording_cannot_begin_leaves_the_one_before(self):
        with Server(STROMA, self.scene, "--paused", "--record", self.recorded, expected=4) as server:
            page = server.page()
            page.do("step", count=2)
            file = os.path.join(self.recorded, "dofs.state.gz")
            os.rename(file, file + ".kept")
            os.mkdir(file)
            before = contents(self.recorded)
            page.ask("reset")
            page.until(lambda: page.status["ended"], "the end of the run")
            self.assertIn("dofs.state.gz", page.status["ended"])
            self.assertIn("ended", page.refused("run"))
            server.process.send_signal(signal.SIGINT)
            server.process.wait(PATIENCE)
            self.assertIn("error: ", server.error_text())
            self.assertEqual(contents(self.recorded), before)
            server.end()


class Command(unittest.TestCase):
    """What goes wrong before anybody connects, and how it ends."""

    def test_mistakes_are_sentences(self):
        for arguments, part in ((("none.xml",), "none.xml"), ((example("organ.xml"), "--port", "70000"), "65535"),
                                ((example("organ.xml"), "--fps", "0"), "fps"), ((example("organ.xml"), "--host", "nowhere"), "--host"),
                                ((TREE,), "last.checkpoint")):
            _, errors = command("view", *arguments, "--no-open", expected=2)
            self.assertIn(part, errors)

    def test_sigterm_ends_it_as_ctrl_c_does(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            server.process.send_signal(signal.SIGTERM)
            server.process.wait(PATIENCE)
            self.assertIn("0 steps, t = 0", server.end())

    def test_options_without_their_partner_are_mistakes(self):
        scene = example("organ.xml")
        with tempfile.TemporaryDirectory() as folder:
            recorded = os.path.join(folder, "run")
            command("run", scene, "-n", "1", "-q", "--record", recorded)
            for option in (("--steps", "5"), ("--every", "2"), ("--field", "vonMises"), ("--inside",)):
                self.named(option[0], "--export", scene, *option, "--no-open")
            for option in (("--port", "0"), ("--host", "127.0.0.1"), ("--open",), ("--no-open",), ("--paused",), ("--fps", "30"), ("--record", "x")):
                self.named(option[0], "--export", scene, "--export", "page.html", *option)
            self.named("--record-every", "--record", scene, "--record-every", "2")
            self.named("--steps", "recording", recorded, "--export", "page.html", "-n", "5")
            self.named("--outputs", "recording", recorded, "--outputs", "--no-open")
            self.named("--record", "recording", recorded, "--record", "x", "--no-open")
            self.named("--replay", "recording", recorded, "--replay", "x", "--no-open")
            self.named("--every", "1 to", scene, "--export", "page.html", "--every", "0")

    def named(self, option, part, *arguments):
        """The mistake, and nothing is written."""
        with tempfile.TemporaryDirectory() as folder:
            _, errors = command("view", *arguments, expected=2, cwd=folder)
            self.assertEqual(os.listdir(folder), [])
        self.assertIn(option, errors)
        self.assertIn(part, errors)

    def test_a_taken_port_is_named(self):
        with Server(STROMA, example("organ.xml"), "--paused") as server:
            with tempfile.TemporaryDirectory() as folder:
                result = subprocess.run([STROMA, "view", example("organ.xml"), "--no-open", "--port", str(server.port)],
                                        capture_output=True, text=True, cwd=folder, timeout=LONGEST)
            self.assertEqual(result.returncode, 2, result)
            self.assertIn(str(server.port), result.stderr)

    def test_a_run_without_a_result_says_why(self):
        text = """<Node dt="1"><EulerExplicitSolver/><RegularGridTopology n="3 3 3" min="0 0 0" max="0.1 0.1 0.1"/>
          <MechanicalObject/><UniformMass totalMass="1"/>
          <HexahedronFEMForceField youngModulus="1e6" poissonRatio="0.3" method="svd"/>
          <ConstantForceField indices="0" totalForce="1e6 0 0"/></Node>"""
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "burst.xml")
            with open(scene, "w", encoding="utf-8") as file:
                file.write(text)
            with Server(STROMA, scene, "--paused", expected=3) as server:
                page = server.page()
                page.do("pace", pace="fast", factor=1)
                page.do("run")
                page.until(lambda: page.status["ended"], "the end of the run")
                self.assertFalse(page.status["running"])
                self.assertIn("reset", page.refused("run"))
                self.assertTrue([line for line in page.messages if line["severity"] == "error"])
                page.do("reset")
                page.until(lambda: not page.status["ended"], "the reset")
                page.do("run")
                page.until(lambda: page.status["ended"], "the end of the run once more")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
