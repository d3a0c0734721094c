#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What watching a run costs: the table of docs/view.md.

  view_costs.py [--stroma build/release/bin/stroma] [--rounds 8] [--seconds 2] [--memory-seconds 3600]

A step is timed by the run itself. Rounds in which a page takes every picture alternate with rounds in which the same page takes
none, so that what else the machine does concerns both; quoted are medians over rounds. The page is a websocket client without a
browser: what a browser draws with is the machine's graphics card, not the run.
"""
import argparse
import math
import os
import statistics
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
TREE = os.path.dirname(os.path.dirname(HERE))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(TREE, "tests", "view"))
from server import Page, Server  # noqa: E402


class Watcher(Page):
    """Counts bytes, and can leave pictures untaken."""

    def __init__(self, server):
        self.received, self.untaken, self.taking = 0, [], True
        super().__init__(server)

    def take_packet(self, packet):
        super().take_packet(packet)
        if packet["is"] == "frame":
            self.received += packet.bytes

    def drawn(self):
        if self.taking:
            super().drawn()
        else:
            self.untaken.append(self.frame["frame"])

    def round(self, seconds, taking):
        """(steps a second, pictures a second, bytes a picture, share of copying)"""
        for frame in self.untaken:
            self.socket.send({"do": "drawn", "frame": frame})
        self.untaken, self.taking = [], taking
        self.during(0.3)
        self.tell("hash")
        start, first, frames, size = time.monotonic(), self.hash()[0], self.frames, self.received
        self.during(seconds)
        elapsed = time.monotonic() - start
        steps = self.hash()[0] - first
        shown = self.frames - frames
        return steps / elapsed, shown / elapsed, (self.received - size) / max(1, shown), self.status["share"]["copy"]


def watched(arguments, scene, options, wants):
    """Medians over rounds: how much slower, pictures a second, bytes, share of copying, steps a second."""
    with Server(arguments.stroma, os.path.join(TREE, scene), *options) as server:
        page = Watcher(server)
        server.pages.append(page)
        page.do("want", **wants)
        page.do("pace", pace="fast")
        page.during(1)
        taken, untaken = [], []
        for i in range(arguments.rounds):
            for taking in ((True, False) if i % 2 else (False, True)):
                (taken if taking else untaken).append(page.round(arguments.seconds, taking))
        slower = [100 * (free[0] / busy[0] - 1) for busy, free in zip(taken, untaken)]
        middle = statistics.median
        return (middle(slower), middle(x[1] for x in taken), middle(x[2] for x in taken), 100 * middle(x[3] for x in taken),
                middle(x[0] for x in taken), max(slower) - min(slower))


def pulled(arguments, scene, options, body_nodes):
    """Steps a second while a hand moves at 60 Hz."""
    with Server(arguments.stroma, os.path.join(TREE, scene), *options) as server:
        page = Watcher(server)
        server.pages.append(page)
        page.do("pace", pace="fast")
        page.picture()
        node = max(range(len(page.positions())), key=lambda i: page.positions()[i][0])
        start = page.positions()[node]
        first, begin = None, time.monotonic()
        while time.monotonic() - begin < 1 + arguments.seconds * arguments.rounds:
            t = time.monotonic() - begin
            target = [start[0] + 0.005 * math.sin(6 * t), start[1] + 0.005 * math.cos(6 * t), start[2]]
            page.socket.send({"do": "pull", "hand": "h", "body": 0, "nodes": [node], "targets": [target]})
            page.during(1 / 60)
            if first is None and t > 1:
                first = (page.hash()[0], time.monotonic())
        steps, now = page.hash()[0] - first[0], time.monotonic() - first[1]
        force = page.frame["hands"][0]["force"]
        return steps / now, math.hypot(*force)


def delay(arguments, scene, options):
    """Median and longest time [ms] from an order of a hand to the arrival of the first picture that has its effect, and the
    time of a step [ms]."""
    with Server(arguments.stroma, os.path.join(TREE, scene), *options) as server:
        page = Watcher(server)
        server.pages.append(page)
        page.do("pace", pace="fast")
        page.picture()
        place = [float(value) for value in page.scene.arrays["0.rest"].reshape(-1, 3)[0]]
        own, times = str(page.scene["client"]), []
        for k in range(1, 201):
            page.during(0.003 + 0.017 * (k * 7 % 13) / 13)  # at all phases of the pictures
            start = time.monotonic()
            page.socket.send({"do": "pull", "hand": "a", "body": 0, "nodes": [0],
                              "targets": [[place[0] + 1e-5 * k, place[1], place[2]]], "sequence": k})
            page.until(lambda: page.frame.get("applied", {}).get(own) == k, "the order to take effect")
            times.append(1e3 * (time.monotonic() - start))
        return statistics.median(times), max(times), page.status["step_ms"]


def memory(arguments, scene):
    """Resident memory [MB] at some instants of a watched run."""
    with Server(arguments.stroma, os.path.join(TREE, scene)) as server:
        page = Watcher(server)
        server.pages.append(page)
        page.do("watch", values=["energy", "solver"])
        out, begin = [], time.monotonic()
        for k in range(7):
            page.until(lambda: time.monotonic() - begin >= arguments.memory_seconds * k / 6, "time to pass", arguments.memory_seconds + 60)
            out.append(server.memory() / 1e6)
        return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", default=os.path.join(TREE, "build", "release", "bin", "stroma"))
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=2)
    parser.add_argument("--memory-seconds", type=float, default=0)
    arguments = parser.parse_args()
    cube = "scenes/benchmarks/cube.xml"
    large = ["--set", "/cube/grid.n=35 35 35", "--set", "/cube/linear.iterations=1"]
    cases = [("5,000 tetrahedra, surface", cube, [], {}),
             ("5,000 tetrahedra, all nodes, von Mises stress", cube, [], {"nodes": "all", "fields": [2]}),
             ("42,875 nodes, surface", cube, large, {}),
             ("42,875 nodes, all", cube, large, {"nodes": "all"}),
             ("42,875 nodes, all, 16 bits", cube, large, {"nodes": "all", "format": "u16"})]
    print("| | Steps/s | Slower | Copying | Pictures/s | kB a picture |\n|---|---|---|---|---|---|")
    for name, scene, options, wants in cases:
        slower, pictures, size, copying, steps, spread = watched(arguments, scene, options, wants)
        print(f"| {name} | {steps:.0f} | {slower:.1f} % (rounds within {spread:.1f} %) | {copying:.2f} % | {pictures:.0f} | {size / 1e3:.1f} |",
              flush=True)
    steps, force = pulled(arguments, "scenes/examples/organ_condensed.xml", ["--set", "/organ/paraview.enable=false"], 0)
    print(f"\nCondensed organ, pulled by a moving hand ({force:.3g} N at the end): {steps:.0f} steps a second")
    print("\n| From an order to the picture with its effect | Median | Longest of 200 | Step |\n|---|---|---|---|")
    for name, scene, options in (("5,000 tetrahedra", cube, []), ("42,875 nodes", cube, large)):
        middle, longest, step = delay(arguments, scene, options)
        print(f"| {name} | {middle:.1f} ms | {longest:.1f} ms | {step:.2f} ms |", flush=True)
    if arguments.memory_seconds > 0:
        print(f"Memory over {arguments.memory_seconds:g} s [MB]: {', '.join(f'{x:.1f}' for x in memory(arguments, 'scenes/examples/organ.xml'))}")


if __name__ == "__main__":
    main()
