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

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import PATIENCE, children, until  # noqa: E402

STROMA = os.path.abspath(sys.argv[1])
MODULE = os.path.join(os.path.dirname(STROMA), "..", "lib", "test_modules", "fickle.so")
MESHED = """<Node name="root" units="m kg s" dt="0.01" gravity="0 {gravity} 0"><EulerExplicitSolver/>
<MeshGmshLoader name="loader" filename="body.msh"/><TetrahedronSetTopologyContainer src="@loader"/>
<MechanicalObject name="dofs"/><UniformMass totalMass="2"/><WriteState filename="written.state"/></Node>
"""
# A run that does not end, and that leaves what it has made so far now and then.
ENDLESS = ("-n", "1000000000", "--set", "/WriteState.period=1e6", "--checkpoint-seconds", "0.1")
BLOCK = ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 {height}\n$EndNodes\n$Elements\n1\n"
         "1 4 0 1 2 3 4\n$EndElements\n")


class Watched:
    """A `stroma watch` and what it has printed."""

    def __init__(self, folder, *arguments):
        self.folder = folder
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
        end, is_over = time.monotonic() + seconds, False
        while not is_over:
            is_over = time.monotonic() > end or (self.process.poll() is not None and not self.reader.is_alive())
            match = re.compile(pattern).search(self.text, self.seen)  # once more when nothing can come any more
            if match:
                piece = self.text[self.seen:match.end()]
                self.seen = match.end()
                return piece
            time.sleep(0.02)
        raise AssertionError(f"nothing matches {pattern} in {self.text[self.seen:]!r} after {self.text[:self.seen]!r}")

    def until_said(self, pattern):
        """What has been printed since the last call, up to the wait after what matches. A save that takes long may be seen before
        it is whole: what is said of that comes before."""
        return self.until(pattern) + self.until("waiting for .*\n")

    def until_it_steps(self):
        """The run has left twice what it has made so far: it is in the middle of its steps."""
        until(lambda: children(self.process.pid), "a run")
        left = set()

        def leaves():
            try:
                left.add(os.stat(os.path.join(self.folder, "results", "body", "last", "run.instants")).st_mtime_ns)
            except FileNotFoundError:
                left.add(None)
            return len(left) > 2
        until(leaves, "a run that steps")

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
        """In place, and in one go: nobody sees a part of it. Where there was more, spaces follow."""
        path = os.path.join(self.folder, name)
        file = os.open(path, os.O_WRONLY | os.O_CREAT, 0o644)
        try:
            data = text.encode().ljust(os.fstat(file).st_size)
            self.assertEqual(os.write(file, data), len(data))
        finally:
            os.close(file)

    def replace(self, name, text):
        """As editors save who keep a backup: the old file goes, a new one takes its name."""
        path = os.path.join(self.folder, name)
        with open(path + ".new", "w", encoding="utf-8") as file:
            file.write(text)
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
        second = watched.until_said("before 0.055 m")
        self.assertRegex(second, r"==== \d\d:\d\d:\d\d, body.xml: body.xml was saved\n")
        self.assertIn("greatest displacement of /dofs: 0.11 m, before 0.055 m (+100 %) at node ", second)
        self.assertRegex(second, r"time per step: \S+ ms, before \S+ ms")
        self.replace("body.xml", MESHED.format(gravity=-10))
        watched.until_said(r"0\.055 m, before 0\.11 m \(-50 %\)")
        self.write("body.xml", MESHED.format(gravity=-10) + "<!-- -->\n")
        watched.until_said("the result is the same, bit for bit")
        self.replace("body.msh", BLOCK.format(height=2))
        said = watched.until_said("greatest displacement|the result is the same")
        self.assertRegex(said, "body.msh (was saved|is gone|has come)")
        for gravity in (-20, -30, -40):  # what a run writes is no reason for another: each run has a reason of its own
            self.write("body.xml", MESHED.format(gravity=gravity))
            said = watched.until_said("greatest displacement")
            self.assertRegex("".join(re.findall("==== .*", said)), "^==== [^=]*: body.xml was saved$")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "written.state")))
        self.assertEqual(watched.end(), 0)

    def test_a_broken_scene_is_told_of_and_waited_for(self):
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        watched.until("waiting for .*\n")
        self.write("body.xml", MESHED.format(gravity=-10).replace("UniformMass", "UniformMas"))
        watched.until_said("body.xml:3:")
        self.write("body.xml", "<Node")
        watched.until_said("body.xml:1")
        self.write("body.xml", MESHED.format(gravity=-20))
        watched.until_said("greatest displacement .*before")  # compared with the last run that had a result
        os.remove(os.path.join(self.folder, "body.xml"))
        watched.until_said("body.xml is gone")
        self.write("body.xml", MESHED.format(gravity=-20))
        watched.until_said("the result is the same")
        self.assertEqual(watched.end(signal.SIGTERM), 0)

    def test_files_that_a_broken_scene_names_are_waited_for(self):
        os.remove(os.path.join(self.folder, "body.msh"))
        watched = self.watch("body.xml", "-n", "2", "--quiet")
        self.assertIn("body.msh", watched.until("waiting for .*\n"))
        self.write("body.msh", BLOCK.format(height=1))
        self.assertIn("body.msh has come", watched.until_said("greatest displacement .*\n"))
        os.remove(os.path.join(self.folder, "body.msh"))
        watched.until_said("body.msh is gone")
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
        self.assertRegex(watched.until_said("the result is the same"), "part.xml (was saved|has come)")
        self.replace("part.xml", part.format(mass=-3))
        watched.until_said("part.xml:1:")
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
        self.assertRegex(watched.until("waiting for a save of body.xml or 3 other files.*\n"), "part.xml (was saved|has come)")
        self.write("inner.xml", inner)
        self.assertIn("inner.xml has come", watched.until_said("greatest displacement .*\n"))
        self.write("inner.xml", inner[:-3])
        watched.until_said("inner.xml:1:")
        self.write("inner.xml", inner)
        self.assertIn("inner.xml was saved", watched.until("the result is the same"))
        self.assertEqual(watched.end(), 0)

    def test_a_result_that_overflows_does_not_end_it(self):
        watched = self.watch("body.xml", "-n", "10", "--quiet")
        watched.until("waiting for .*\n")
        self.write("body.xml", MESHED.format(gravity="1e200"))  # its square is no number
        watched.until_said(r"greatest displacement of /dofs: 5\.5e\+197 m, before 0\.055 m")
        self.write("body.xml", MESHED.format(gravity="1.7e308 1.7e308").replace('"0 1.7', '"1.7').replace('dt="0.01"', 'dt="1"'))
        watched.until_said(r"greatest displacement of /dofs: no finite number, before 5\.5e\+197 m")
        self.write("body.xml", MESHED.format(gravity=-10))
        watched.until_said(r"greatest displacement of /dofs: 0\.055 m")
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
            watched.until_said(f"{name} was saved")
        self.assertEqual(watched.end(), 0)

    def test_a_checkpoint_that_the_run_replaces_is_refused(self):
        subprocess.run([STROMA, "run", "body.xml", "-n", "3", "-q"], cwd=self.folder, check=True)
        restart = ("--restart", os.path.join("results", "body", "last", "last.checkpoint"))
        watched = self.watch("body.xml", "-n", "6", *restart)
        self.assertEqual(watched.process.wait(PATIENCE), 2)
        watched.until("results/body/last/last.checkpoint: the first run would replace it")
        self.assertEqual(self.watch("body.xml", "-n", "6", "--no-record", "--times", "1", *restart).process.wait(PATIENCE), 0)

    def test_a_save_in_the_middle_of_a_run_begins_the_next(self):
        watched = self.watch("body.xml", *ENDLESS)
        watched.until_it_steps()
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
        watched = self.watch("body.xml", "-q", *ENDLESS)
        watched.until_it_steps()
        self.assertEqual(len(children(watched.process.pid)), 1)
        os.kill(watched.process.pid, signal.SIGKILL)
        watched.process.wait()
        watched.reader.join(PATIENCE)  # nobody holds the pipe any more
        self.assertFalse(watched.reader.is_alive())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
