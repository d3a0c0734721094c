#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma watch` as somebody uses it who edits a scene: saves in place, saves by renaming, mistakes, files that go and come.
Usage: test_watch.py STROMA [unittest arguments]"""
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import PATIENCE, children, processor_seconds, until  # noqa: E402

STROMA = os.path.abspath(sys.argv[1])
MODULE = os.path.join(os.path.dirname(STROMA), "..", "lib", "test_modules", "fickle.so")
MESHED = """<Node name="root" units="m kg s" dt="0.01" gravity="0 {gravity} 0"><EulerExplicitSolver/>
<MeshGmshLoader name="loader" filename="body.msh"/><TetrahedronSetTopologyContainer src="@loader"/>
<MechanicalObject name="dofs"/><UniformMass totalMass="2"/><WriteState filename="written.state"/></Node>
"""
BLOCK = ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 {height}\n$EndNodes\n$Elements\n1\n"
         "1 4 0 1 2 3 4\n$EndElements\n")


class Watched:
    """A `stroma watch` and what it has printed."""

    def __init__(self, folder, *arguments):
        self.process = subprocess.Popen([STROMA, "watch", *arguments], cwd=folder, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, start_new_session=True)
        self.text, self.seen = "", 0
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            self.text += line

    def until(self, pattern, seconds=PATIENCE):
        """What has been printed since the last call, up to what matches; the wait ends there."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            match = re.compile(pattern).search(self.text, self.seen)
            if match:
                piece = self.text[self.seen:match.end()]
                self.seen = match.end()
                return piece
            if self.process.poll() is not None and not self.reader.is_alive():
                break
            time.sleep(0.02)
        raise AssertionError(f"nothing matches {pattern} in {self.text[self.seen:]!r} after {self.text[:self.seen]!r}")

    def until_it_steps(self):
        """The run is in the middle of its steps."""
        until(lambda: any(processor_seconds(run) > 0.5 for run in children(self.process.pid)), "a run that steps")

    def end(self, number=signal.SIGINT):
        """The exit code after a signal to the whole group, as a terminal sends it."""
        os.killpg(self.process.pid, number)
        code = self.process.wait(PATIENCE)
        self.reader.join()
        return code


class Watch(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.write("body.msh", BLOCK.format(height=1))
        self.write("body.xml", MESHED.format(gravity=-10))

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def replace(self, name, text):
        """As editors save who keep a backup: the old file goes, a new one takes its name."""
        path = os.path.join(self.folder, name)
        self.write(name + ".new", text)
        os.rename(path, path + "~")
        os.rename(path + ".new", path)

    def watch(self, *arguments):
        watched = Watched(self.folder, *arguments)
        self.addCleanup(lambda: watched.process.poll() is None and watched.end(signal.SIGKILL))
        return watched

    def test_edits_are_run_and_compared(self):
        watched = self.watch("body.xml", "-n", "10")
        first = watched.until("waiting for a save of body.xml or 1 other file; Ctrl-C ends\n")
        self.assertIn("body.xml: done after 10 steps", first)
        self.assertIn("greatest displacement of /dofs: 0.055 m at node 2\n", first)  # 10 m/s^2 (1 + ... + 10) (0.01 s)^2
        self.write("body.xml", MESHED.format(gravity=-20))
        second = watched.until("waiting for .*\n")
        self.assertRegex(second, r"==== \d\d:\d\d:\d\d, body.xml: body.xml was saved\n")
        self.assertIn("greatest displacement of /dofs: 0.11 m, before 0.055 m (+100 %) at node ", second)
        self.assertRegex(second, r"time per step: \S+ ms, before \S+ ms")
        self.replace("body.xml", MESHED.format(gravity=-10))
        self.assertIn("0.055 m, before 0.11 m (-50 %)", watched.until("waiting for .*\n"))
        self.write("body.xml", MESHED.format(gravity=-10) + "<!-- -->\n")
        self.assertIn("the result is the same, bit for bit", watched.until("waiting for .*\n"))
        self.replace("body.msh", BLOCK.format(height=2))
        self.assertIn("body.msh was saved", watched.until("waiting for .*\n"))
        time.sleep(0.5)
        self.assertEqual(watched.text[watched.seen:], "", "what a run writes is no reason for another")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "written.state")))
        self.assertEqual(watched.end(), 0)

    def test_a_broken_scene_is_told_of_and_waited_for(self):
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        watched.until("waiting for .*\n")
        self.write("body.xml", MESHED.format(gravity=-10).replace("UniformMass", "UniformMas"))
        self.assertIn("body.xml:3:", watched.until("waiting for .*\n"))
        self.write("body.xml", "<Node")
        self.assertIn("body.xml:1", watched.until("waiting for .*\n"))
        self.write("body.xml", MESHED.format(gravity=-20))
        self.assertIn("before", watched.until("waiting for .*\n"), "compared with the last run that had a result")
        os.remove(os.path.join(self.folder, "body.xml"))
        self.assertIn("body.xml is gone", watched.until("waiting for .*\n"))
        self.write("body.xml", MESHED.format(gravity=-20))
        self.assertIn("the result is the same", watched.until("waiting for .*\n"))
        self.assertEqual(watched.end(signal.SIGTERM), 0)

    def test_files_that_a_broken_scene_names_are_waited_for(self):
        os.remove(os.path.join(self.folder, "body.msh"))
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        self.assertIn("body.msh", watched.until("waiting for .*\n"))
        self.write("body.msh", BLOCK.format(height=1))
        self.assertIn("body.msh has come", watched.until("greatest displacement .*\n"))
        watched.until("waiting for .*\n")
        os.remove(os.path.join(self.folder, "body.msh"))
        self.assertIn("body.msh is gone", watched.until("waiting for .*\n"))
        self.write("body.msh", BLOCK.format(height=3))
        watched.until("greatest displacement .*\n")
        self.assertEqual(watched.end(), 0)

    def test_included_files_are_watched(self):
        self.write("body.xml", '<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/><include href="part.xml"/></Node>')
        part = '<Node name="part"><MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="{mass}"/></Node>'
        self.write("part.xml", part.format(mass=1))
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        watched.until("waiting for a save of body.xml or 1 other file")
        self.replace("part.xml", part.format(mass=3))
        self.assertIn("part.xml was saved", watched.until("the result is the same(?s:.*)waiting for .*\n"))
        self.replace("part.xml", part.format(mass=-3))
        self.assertIn("part.xml:1:", watched.until("waiting for .*\n"))
        self.replace("part.xml", part.format(mass=3))
        watched.until("the result is the same")
        self.assertEqual(watched.end(), 0)

    def test_a_broken_include_is_waited_for(self):
        self.write("body.xml", '<Node name="root" dt="0.01"><EulerExplicitSolver/><include href="part.xml"/><include href="more.xml"/></Node>')
        part = '<Node name="part"><include href="inner.xml"/></Node>'
        inner = '<Node name="inner"><MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/></Node>'
        self.write("part.xml", "<Node")
        self.write("more.xml", '<Node name="more"/>')
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        self.assertIn("part.xml:1:", watched.until("waiting for a save of body.xml or 2 other files.*\n"))
        self.replace("part.xml", part)  # names a file that is not there
        self.assertIn("part.xml was saved", watched.until("waiting for a save of body.xml or 3 other files.*\n"))
        self.write("inner.xml", inner)
        self.assertIn("inner.xml has come", watched.until("greatest displacement .*\n"))
        watched.until("waiting for .*\n")
        self.write("inner.xml", inner[:-3])
        self.assertIn("inner.xml:1:", watched.until("waiting for .*\n"))
        self.write("inner.xml", inner)
        self.assertIn("inner.xml was saved", watched.until("the result is the same"))
        self.assertEqual(watched.end(), 0)

    def test_a_result_that_overflows_does_not_end_it(self):
        watched = self.watch("body.xml", "-n", "10", "--quiet")
        watched.until("waiting for .*\n")
        self.write("body.xml", MESHED.format(gravity="1e200"))  # its square is no number
        self.assertIn("greatest displacement of /dofs: 5.5e+197 m, before 0.055 m", watched.until("waiting for .*\n"))
        self.write("body.xml", MESHED.format(gravity="1.7e308 1.7e308").replace('"0 1.7', '"1.7').replace('dt="0.01"', 'dt="1"'))
        self.assertIn("greatest displacement of /dofs: no finite number, before 5.5e+197 m", watched.until("waiting for .*\n"))
        self.write("body.xml", MESHED.format(gravity=-10))
        self.assertIn("greatest displacement of /dofs: 0.055 m", watched.until("waiting for .*\n"))
        self.assertEqual(watched.end(), 0)

    def test_files_of_options_are_watched(self):
        self.write("none.actions", '{"stroma":"actions","version":1,"scene":"body.xml"}\n')
        run = [STROMA, "run", "body.xml", "-n", "3", "-q"]
        subprocess.run(run, cwd=self.folder, check=True)
        shutil.copy(os.path.join(self.folder, "results", "body", "last", "last.checkpoint"), os.path.join(self.folder, "start.checkpoint"))
        options = ["--replay", "none.actions", "--restart", "start.checkpoint"]
        names = ["none.actions", "start.checkpoint"]
        if os.path.exists(MODULE):
            shutil.copy(MODULE, os.path.join(self.folder, "mine.so"))
            options, names = options + ["--module", "mine.so"], names + ["mine.so"]
        watched = self.watch("body.xml", "-n", "6", "-q", *options)
        watched.until("waiting for .*\n")
        for name in names:
            os.utime(os.path.join(self.folder, name))
            self.assertIn(f"{name} was saved", watched.until("waiting for .*\n"))
        self.assertEqual(watched.end(), 0)

    def test_a_checkpoint_that_the_run_replaces_is_refused(self):
        subprocess.run([STROMA, "run", "body.xml", "-n", "3", "-q"], cwd=self.folder, check=True)
        restart = ("--restart", os.path.join("results", "body", "last", "last.checkpoint"))
        watched = self.watch("body.xml", "-n", "6", *restart)
        self.assertEqual(watched.process.wait(PATIENCE), 2)
        watched.until("results/body/last/last.checkpoint: the first run would replace it")
        self.assertEqual(self.watch("body.xml", "-n", "6", "--no-record", "--times", "1", *restart).process.wait(PATIENCE), 0)

    def test_a_save_in_the_middle_of_a_run_begins_the_next(self):
        watched = self.watch("body.xml", "-n", "1000000000", "--set", "/WriteState.period=1e6")
        watched.until_it_steps()
        self.write("body.msh", BLOCK.format(height=2))
        self.write("body.xml", MESHED.format(gravity=-30))
        text = watched.until("(?s)==== .*==== [^\n]*\n")
        self.assertIn("was saved: the run ends after its step\n", text)
        self.assertIn("body.xml: interrupted after ", text)
        self.assertNotIn("greatest displacement", text)
        watched.until_it_steps()
        self.assertEqual(watched.end(), 0)
        self.assertEqual(watched.text.count("interrupted after"), 2)

    def test_times_ends_it_with_the_last_exit_code(self):
        for arguments, code in ((("-n", "2"), 0), (("-n", "2", "--set", "/.dt=-1"), 2)):
            watched = self.watch("body.xml", "--times", "1", *arguments)
            self.assertEqual(watched.process.wait(PATIENCE), code)
        for arguments in (("absent.xml",), ("body.xml", "--json"), ("body.xml", "--times", "0"), ("body.xml", "--recrod", "x"),
                          ("body.xml", "-n", "-1")):
            self.assertEqual(self.watch(*arguments).process.wait(PATIENCE), 2, arguments)

    def test_a_watch_that_is_killed_leaves_no_run_behind(self):
        watched = self.watch("body.xml", "-n", "1000000000", "-q", "--no-record", "--set", "/WriteState.period=1e6")
        watched.until_it_steps()
        self.assertEqual(len(children(watched.process.pid)), 1)
        os.kill(watched.process.pid, signal.SIGKILL)
        watched.process.wait()
        watched.reader.join(PATIENCE)  # nobody holds the pipe any more
        self.assertFalse(watched.reader.is_alive())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
