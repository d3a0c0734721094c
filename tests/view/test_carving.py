#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Meshes that change in `stroma view`: a region that a hand leads carves, pages follow, and the run is repeated to the bit.
Usage: test_carving.py TREE STROMA [names of tests]"""
import gzip
import os
import subprocess
import sys
import tempfile
import unittest

import numpy

from server import Server
from test_protocol import STROMA, all_packets_of_page, check_scene, hash_of_run, positions_in, replayed_hash, write

SCENE = """<Node gravity="0 0 0" dt="0.01"><EulerImplicitSolver/><SparseLDLSolver/>
  <RegularGridTopology n="6 3 3" min="0 0 0" max="0.1 0.04 0.04"/><MechanicalObject name="dofs"/><MeshMatrixMass massDensity="1000"/>
  <FixedProjectiveConstraint indices="0 6 12 18 24 30 36 42 48"/><HexahedronFEMForceField method="svd" youngModulus="3000" poissonRatio="0.4"/>
  <CarvingRegion name="tool" sphere="0.15 0.02 0.02 0.025"/></Node>"""


def read_states(path):
    """The positions of each instant."""
    with gzip.open(path, "rt") as file:
        return [numpy.array(line.split()[1:], dtype=float).reshape(-1, 3) for line in file if line.lstrip().startswith("X=")]


class Carving(unittest.TestCase):
    """A bar of 20 hexahedra whose last eight nodes lie at x = 0.1 m, and a ball beside them."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.scene = write(self.folder.name, "bar.xml", SCENE)

    def test_a_region_is_led_and_the_page_gets_the_other_mesh(self):
        with Server(STROMA, self.scene, "--paused") as viewed:
            page = viewed.page()
            first = page.scene
            page.do("step", count=3)
            page.do("watch", values=["node.0.53.position", "node.0.52.position", "energy"])
            page.do("move", hand="o0", obstacle=0, offset=[-0.04, 0, 0])
            page.do("step")
            page.until(lambda: page.frame["step"] == 4, "the step that cuts")
            self.assertEqual((first["bodies"][0]["nodes"], page.scene["bodies"][0]["nodes"]), (54, 45))
            check_scene(self, page.scene)
            self.assertEqual(page.frame["generation"], page.scene["generation"])
            self.assertEqual(page.scene["follows"], first["generation"])
            numpy.testing.assert_allclose(page.frame["moved"][0], [-0.04, 0, 0])
            before = page.scene.arrays["0.before"]
            numpy.testing.assert_array_equal(page.scene.arrays["0.rest"].reshape(-1, 3), first.arrays["0.rest"].reshape(-1, 3)[before])
            self.assertNotIn("node.0.53.position.x", page.frame["values"])  # it has another number now
            # another page sees the same, and the first one is back after a reset
            other = viewed.page()
            self.assertEqual(other.scene["bodies"][0]["nodes"], 45)
            page.do("move", hand="o0", obstacle=0, offset=[0, 0, 0])
            page.do("reset")
            page.until(lambda: page.frame["step"] == 0 and page.frame["generation"] == page.scene["generation"], "the start")
            self.assertEqual(page.scene["bodies"][0]["nodes"], 54)
            back = page.scene.arrays["0.before"]
            self.assertEqual((back >= 0).sum(), 45)
            other.until(lambda: other.scene["bodies"][0]["nodes"] == 54, "the first mesh on the other page")

    def test_a_hand_keeps_what_is_left_and_the_run_is_repeated(self):
        """It pulls the end, some of whose nodes go."""
        with Server(STROMA, self.scene, "--paused") as viewed:
            page = viewed.page()
            places = page.scene.arrays["0.rest"].reshape(-1, 3)
            nodes = numpy.flatnonzero(places[:, 0] > 0.079)
            order = {"hand": "h", "kind": "hold", "body": 0, "nodes": nodes.tolist(), "targets": (places[nodes] + [0, 0.02, 0]).tolist(),
                     "generation": page.scene["generation"]}
            page.do("pull", **order)
            page.do("step", count=3)
            page.do("move", hand="o0", obstacle=0, offset=[-0.055, 0, 0])
            page.do("step", count=3)
            page.until(lambda: page.frame["step"] == 6, "the steps")
            self.assertLess(page.scene["bodies"][0]["nodes"], 54)
            left = (page.scene.arrays["0.rest"].reshape(-1, 3)[:, 0] > 0.079).sum()
            self.assertEqual(page.frame["hands"][0]["nodes"], left)
            self.assertLess(left, len(nodes))
            page.do("pull", **{**order, "targets": places[nodes].tolist()})  # of the mesh before: not heeded
            page.do("step", count=2)
            page.do("release", hand="h")
            page.do("step", count=2)
            step, found = page.hash()
            self.assertEqual(step, 10)
            self.assertEqual(replayed_hash(page, self.scene, 10), found)
            self.assertNotEqual(hash_of_run(self.scene, 10), found)


class Recorded(unittest.TestCase):
    """The bar, whose ball comes by itself."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.scene = write(self.folder.name, "bar.xml", SCENE.replace('0.025"/>', '0.025" velocity="-1 0 0"/>').replace("0 0 0\" dt", "0 -9 0\" dt"))
        self.recorded = os.path.join(self.folder.name, "kept")

    def test_a_recording_is_looked_at_with_the_mesh_of_each_instant(self):
        with Server(STROMA, self.scene, "--paused", "--record", self.recorded) as viewed:
            live = viewed.page()
            wanted = []
            for step in range(10):
                if step:
                    live.do("step")
                live.picture(step)
                live.until(lambda: live.frame["generation"] == live.scene["generation"], "its scene")
                wanted.append((live.scene["bodies"][0]["nodes"], live.positions()))
        counts = [count for count, _ in wanted]
        self.assertGreater(len(set(counts)), 2, counts)
        with Server(STROMA, self.recorded) as viewed:
            page = viewed.page()
            self.assertEqual(page.scene["mode"], "recording")
            self.assertEqual(page.status["recording"]["count"], 10)
            for index in (9, 0, 5, 5, 6, 9, 8, 7, 1):
                page.do("seek", index=index)
                page.until(lambda index=index: page.frame and page.frame["index"] == index
                           and page.frame["generation"] == page.scene["generation"], f"instant {index}")
                check_scene(self, page.scene)
                self.assertEqual(page.scene["bodies"][0]["nodes"], counts[index], index)
                numpy.testing.assert_array_equal(page.positions(), wanted[index][1])

    def test_a_page_of_its_own_has_the_mesh_of_each_picture(self):
        """Of the run, and of its recording. Where a node has been before is told of the run."""
        subprocess.run([STROMA, "run", self.scene, "-n", "9", "-q", "--record", self.recorded], check=True, stderr=subprocess.DEVNULL)
        recording = read_states(os.path.join(self.recorded, "dofs.state.gz"))
        self.assertGreater(len({len(x) for x in recording}), 2)
        for what in (["view", self.scene, "-n", "9"], ["view", self.recorded]):
            done = subprocess.run([STROMA, *what, "--export", "page.html", "--inside"], cwd=self.folder.name, text=True, capture_output=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            scene, shown = None, []
            for packet in all_packets_of_page(os.path.join(self.folder.name, "page.html")):
                if packet["is"] == "scene":
                    if scene is not None:
                        self.assertEqual(packet["follows"], scene["generation"])
                        rest, before = (each.arrays["0.rest"].reshape(-1, 3) for each in (packet, scene))
                        where = packet.arrays["0.before"]
                        if what[1] == self.scene:
                            self.assertTrue((where >= 0).all())
                        numpy.testing.assert_array_equal(rest[where >= 0], before[where[where >= 0]])
                    scene = packet
                    continue
                self.assertEqual(packet["generation"], scene["generation"])
                if packet["is"] == "cells":
                    self.assertLess(packet.arrays["0.hexahedra"].max(), scene["bodies"][0]["nodes"])
                if packet["is"] != "frame":
                    continue
                wanted = recording[len(shown)][scene.arrays["0.node"]]
                found, side = positions_in(packet)
                numpy.testing.assert_allclose(found, wanted, atol=side / 65535)
                shown.append(scene["bodies"][0]["nodes"])
            self.assertEqual(shown, [len(x) for x in recording])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
