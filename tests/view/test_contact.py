#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Contact as pages of `stroma view` get it, and tools that hands move: they stop at what they meet, however fast.
Usage: test_contact.py TREE STROMA [names of tests]"""
import os
import sys
import tempfile
import unittest

import numpy

from server import Server
from test_protocol import command, replayed_hash, write

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])

# the corners and triangles of an icosahedron
TIP = numpy.array([[-0.525731, 0.850651, 0], [0.525731, 0.850651, 0], [-0.525731, -0.850651, 0], [0.525731, -0.850651, 0], [0, -0.525731, 0.850651],
                   [0, 0.525731, 0.850651], [0, -0.525731, -0.850651], [0, 0.525731, -0.850651], [0.850651, 0, -0.525731], [0.850651, 0, 0.525731],
                   [-0.850651, 0, -0.525731], [-0.850651, 0, 0.525731]]) * 0.012
FACES = numpy.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2],
                     [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]])
BALL, RADIUS = numpy.array([0.02, 0, 0.014]), 0.01

SCENE = f"""<Node dt="0.01" gravity="0 0 -0.1">
  <EulerImplicitSolver newtonIterations="40" newtonTolerance="1e-3" rayleighMass="2"/>
  <SparseLDLSolver/>
  <Node name="block">
    <RegularGridTopology name="mesh" n="8 6 4" min="-0.04 -0.03 -0.03" max="0.04 0.03 0"/>
    <MechanicalObject name="dofs"/>
    <UniformMass totalMass="0.2"/>
    <HexahedronFEMForceField youngModulus="5 kPa" poissonRatio="0.3"/>
    <BoxROI name="bottom" box="-1 -1 -0.031  1 1 -0.029"/>
    <FixedProjectiveConstraint indices="@bottom.indices"/>
  </Node>
  <Node name="tool">
    <MechanicalObject name="frame" template="Rigid3" position="-0.02 0 0.0165  0 0 0 1"/>
    <UniformMass totalMass="0.05" inertia="1e-5 1e-5 1e-5"/>
    <Node name="tip">
      <MeshTopology name="mesh" position="{' '.join(f'{c:.8f}' for c in TIP.ravel())}" triangles="{' '.join(map(str, FACES.ravel()))}"/>
      <MechanicalObject name="dofs"/>
      <RigidMapping/>
    </Node>
  </Node>
  <BarrierContact name="contact" mstate="@block/dofs" topology="@block/mesh" other="@tool/tip/dofs" contactDistance="2 mm" friction="0.1"
      slipVelocity="1e-3" selfContact="false" spheres="{' '.join(map(str, BALL))} {RADIUS}"/>
</Node>
"""


def body_at(page, path):
    """Number of a body."""
    return next(number for number, body in enumerate(page.scene["bodies"]) if body["path"] == path)


class Contact(unittest.TestCase):
    """One scene, with a tool on a frame and one that is an obstacle."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.scene = write(self.folder.name, "tools.xml", SCENE)

    def check_apart(self, page):
        """The certificate of the engine, and places as the page sees them: nothing of the block is inside of a tool."""
        sums = page.frame["contacts"][0]
        self.assertEqual(sums["crossings"], 0)
        block = page.positions(body_at(page, "/block/dofs"))
        centre = BALL + page.frame["moved"][0]
        self.assertGreater(numpy.linalg.norm(block - centre, axis=1).min(), RADIUS - 1e-6)
        tip = page.positions(body_at(page, "/tool/tip/dofs"))
        corners = tip[FACES]
        normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= numpy.linalg.norm(normals, axis=1)[:, None]
        outside = ((block[:, None, :] - corners[None, :, 0, :]) * normals[None]).sum(axis=2).max(axis=1)
        self.assertGreater(outside.min(), -1e-6)  # of a convex body

    def step(self, page):
        before = page.frame["step"]
        page.do("step")
        page.picture(before + 1)

    def test_tools_that_hands_throw_do_not_pass(self):
        """At up to 10 m/s into the block, through it, sideways and back; each step is looked at, and the run is repeated to the bit."""
        with Server(STROMA, self.scene, "--paused") as viewed:
            page = viewed.page()
            page.do("want", nodes="surface", contacts=True)
            frame, most, late = body_at(page, "/tool/frame"), 0., 0.
            start = page.positions(frame)[0]
            for k in range(14):
                depth = -0.1 * (k + 1) if k < 6 else -0.05 * (k % 5)
                aside = 0.02 * numpy.sin(2.5 * k)
                target = start + [aside, 0, depth]
                offset = numpy.array([0.6 * aside, 0.3 * aside, depth])
                page.do("pull", hand="a", body=frame, nodes=[0], targets=[list(target)], stiffness=400, sequence=2 * k)
                page.do("move", hand="o", obstacle=0, offset=list(offset), sequence=2 * k + 1)
                self.step(page)
                self.check_apart(page)
                self.assertEqual(page.frame["applied"][str(page.scene["client"])], 2 * k + 1)
                numpy.testing.assert_array_equal(page.frame["offsets"][0], offset)
                most = max(most, numpy.linalg.norm(page.frame["contacts"][0]["wrenches"][6:9]))
                late = max(late, numpy.linalg.norm(offset - page.frame["moved"][0]))
            self.assertGreater(most, 1, "the tool on a frame has not pushed")
            self.assertGreater(late, 0.05, "nothing was in the way of the ball")
            steps, run = page.hash()
            self.assertEqual(run, replayed_hash(page, self.scene, steps))

    def test_tools_are_moved_while_the_run_goes_on(self):
        """The run as fast as it can, and orders as fast as they come: the count of crossings is of every step."""
        with Server(STROMA, self.scene) as viewed:
            page = viewed.page()
            page.do("want", nodes="surface", contacts=True)
            page.do("pace", pace="fast")
            frame = body_at(page, "/tool/frame")
            start = page.positions(frame)[0]
            for k in range(20):
                depth = -0.04 * (k % 6)
                page.do("pull", hand="a", body=frame, nodes=[0], targets=[[start[0], start[1], start[2] + depth]], stiffness=400)
                page.do("move", hand="o", obstacle=0, offset=[0, 0.01 * (k % 3), depth])
                page.pictures(1)
                self.check_apart(page)
            page.pause()
            self.assertGreaterEqual(page.frame["step"], 20)

    def test_forces_and_fields_are_those_of_the_component(self):
        """Arrows sum up to the wrench, pairs to bodies; a field of nodes is there when it is wanted, and nothing else is."""
        with Server(STROMA, self.scene, "--paused") as viewed:
            page = viewed.page()
            contact = page.scene["contacts"][0]
            self.assertEqual((contact["path"], contact["bodies"]), ("/contact", ["/block/dofs", "/tool/tip/dofs"]))
            self.assertEqual(contact["pairs"], [["/block/dofs", "/tool/tip/dofs"], ["/block/dofs", "obstacles"], ["/tool/tip/dofs", "obstacles"]])
            block = body_at(page, "/block/dofs")
            self.assertEqual(contact["body"], block)
            self.assertTrue(page.scene["obstacles"][0]["movable"])
            points = page.scene.arrays["o0.points"].reshape(-1, 3)
            numpy.testing.assert_allclose(numpy.linalg.norm(points - BALL, axis=1), RADIUS, rtol=1e-5)
            fields = {field["name"]: field for field in page.scene["fields"] if field["body"] == block}
            self.assertEqual(fields["pressures"]["on"], "nodes")
            page.do("move", hand="o", obstacle=0, offset=[0, 0, -0.008])
            for _ in range(4):
                self.step(page)
            self.assertNotIn("contacts", page.frame.header)
            self.assertFalse([name for name in page.frame.arrays if name.startswith(("c0", "f"))])
            page.do("want", nodes="surface", contacts=True, fields=[fields["pressures"]["id"], fields["contactStates"]["id"]])
            self.step(page)
            sums = page.frame["contacts"][0]
            forces = page.frame.arrays["c0.forces"].reshape(-1, 3)
            wrench = numpy.array(sums["wrenches"])
            self.assertGreater(wrench[:3] @ [0, 0, -1], 0.01)
            numpy.testing.assert_allclose(forces.sum(axis=0), wrench[:3], atol=1e-5 * numpy.linalg.norm(wrench[:3]))
            pairs = numpy.array(sums["pairWrenches"]).reshape(-1, 2, 3)
            numpy.testing.assert_allclose(pairs[0] + pairs[1], wrench[:6].reshape(2, 3), rtol=1e-9, atol=1e-12)
            pressures = page.frame.arrays[f"f{fields['pressures']['id']}"]
            states = page.frame.arrays[f"f{fields['contactStates']['id']}"]
            pushed = numpy.zeros(len(pressures), bool)
            pushed[page.frame.arrays["c0.pages"]] = True
            self.assertTrue((pressures[pushed] > 0).all() and (pressures[~pushed] == 0).all())
            self.assertTrue((states[pushed] > 0).all() and (states[~pushed] == 0).all())
            places = page.frame.arrays["c0.places"].reshape(-1, 3)
            numpy.testing.assert_allclose(places, page.positions(block)[page.frame.arrays["c0.pages"]], atol=1e-7)

    def test_a_recording_has_them(self):
        """The instants of a recorded run show the forces that the run had."""
        recorded = os.path.join(self.folder.name, "run")
        path = ["--set", "/contact.keyTimes=0 0.1", "--set", "/contact.movements=0 0 0  0 0 -0.006"]
        command("run", self.scene, "-n", "10", "--record", recorded, "-q", *path)
        self.assertIn("contact.values.gz", os.listdir(recorded))
        with Server(STROMA, recorded) as viewed:
            page = viewed.page()
            pressure = next(field["id"] for field in page.scene["fields"] if field["name"] == "pressures")
            page.do("want", nodes="surface", contacts=True, fields=[pressure])
            last = page.status["recording"]["count"] - 1
            page.do("seek", index=last)
            page.until(lambda: page.frame["index"] == last and "contacts" in page.frame.header, "the last instant with its forces")
            numpy.testing.assert_allclose(page.frame["moved"][0], [0, 0, -0.006], atol=1e-12)
            wrench = page.frame["contacts"][0]["wrenches"]
            self.assertGreater(-wrench[2], 0.01)
            self.assertGreater(page.frame.arrays[f"f{pressure}"].max(), 1)
            page.do("seek", index=0)
            page.until(lambda: page.frame["index"] == 0, "the first instant")
            self.assertEqual(page.frame["contacts"][0]["wrenches"], [], "there is nothing before the first step")
            self.assertEqual(page.refused("move", hand="o", obstacle=0, offset=[0, 0, 0]), "no hand reaches into a recording")

    def test_what_cannot_be_moved_is_refused(self):
        with Server(STROMA, self.scene, "--paused") as viewed:
            page = viewed.page()
            before = page.hash()
            for wrong in ({"obstacle": 1}, {"obstacle": -1}, {"offset": [0, 0]}, {"offset": [0, 0, 1e300]}, {"offset": "up"}, {"to": [0, 0, 0]}):
                page.refused("move", **{"hand": "o", "obstacle": 0, "offset": [0, 0, 0], **wrong})
            self.step(page)
            page.do("reset")
            self.assertEqual(page.hash(), before)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
