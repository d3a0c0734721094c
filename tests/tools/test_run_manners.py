#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What `stroma run` tells of a run while it lasts, in a pipe and on a terminal, and what it leaves to be looked at.
Usage: test_run_manners.py TREE STROMA [unittest arguments]"""
import fcntl
import glob
import json
import os
import pty
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import PATIENCE, held_still, until  # noqa: E402

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])
MODULE = os.path.join(os.path.dirname(STROMA), "..", "lib", "test_modules", "fickle.so")
HAS_VIEW = os.path.exists(os.path.join(os.path.dirname(STROMA), "..", "lib", "stroma", "view.so"))
LAST = os.path.join("results", "fall", "last")  # what a run of fall.xml leaves
FALLING = """<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/>
<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/></Node>
"""
# The same, which writes a file of its own after each ten thousand steps.
TELLING = FALLING.replace("</Node>", '<WriteState filename="steps.state" period="100"/></Node>')
# A step of statics that takes seconds: a block that is bent far.
BENT = """<Node name="root" dt="1" gravity="0 -30 0"><StaticSolver/><CGLinearSolver iterations="20000" tolerance="1e-9" threshold="1e-30"/>
<RegularGridTopology n="{n} {n} {n}" min="0 0 0" max="0.1 0.1 0.3"/><MechanicalObject name="dofs"/><UniformMass totalMass="0.3"/>
<HexahedronHyperelasticityFEMForceField name="fem" materialName="StableNeoHookean" youngModulus="30000" poissonRatio="0.45"/>
<BoxROI name="end" box="-1 -1 -0.001 1 1 0.001"/><FixedProjectiveConstraint indices="@end.indices"/></Node>
"""
PROGRESS = re.compile(r"step \d+/\d+( |$)|loading .* so far$")
LINE = re.compile(r"step (\d+)/(\d+)  (\d+) %  t = \S+(?: s)?  \S+ ms/step  .*elapsed  (.*) to go$")


def seconds(text):
    units = {"s": 1, "min": 60, "h": 3600, "d": 86400}
    words = text.split()
    return sum(float(number) * units[unit] for number, unit in zip(words[::2], words[1::2]))


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def read(self, *names):
        with open(self.path(*names), "rb") as file:
            return file.read()

    def stroma(self, *arguments, code=0, cwd=None):
        result = subprocess.run([STROMA, *arguments], capture_output=True, text=True, cwd=cwd or self.folder, timeout=5 * PATIENCE)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    @staticmethod
    def notes(result):
        """What is said on standard error, but for how far the run is: a machine may have so much else to do that a short run tells it."""
        return "".join(line for line in result.stderr.splitlines(True) if not PROGRESS.match(line))

    def until_it_steps(self, process):
        """Waits until a run of TELLING is in the middle of its steps: some ten thousand of them are behind it."""
        def is_stepping():
            self.assertIsNone(process.poll(), "the run ends by itself")
            return os.path.exists(self.path("steps.state")) and self.read("steps.state").count(b"T=") > 3
        until(is_stepping, "a run that steps")

    def steps_of(self, scene, wanted):
        """How many steps take about `wanted` seconds, as fast as the machine is now. Later it may be slower, or faster."""
        summary = json.loads(self.stroma("run", scene, "-n", "20000", "-q", "--json", "--no-record").stdout)
        return max(1000, int(20000 * wanted / max(summary["wall_seconds"], 1e-3)))

    def instants(self, folder):
        """Head and numbers of what a run has left."""
        line, data = self.read(folder, "run.instants").split(b"\n", 1)
        head = json.loads(line)
        numbers = 1 + sum(6 * state["nodes"] for state in head["states"])
        self.assertEqual(len(data) % (8 * numbers), 0)
        values = struct.unpack(f"<{len(data) // 8}d", data)
        return head, [values[i:i + numbers] for i in range(0, len(values), numbers)]


class Progress(Folder):
    def test_a_pipe_gets_few_lines_with_the_time_to_go(self):
        self.write("fall.xml", FALLING)
        steps, whole = self.steps_of("fall.xml", 1.6), []
        for _ in range(20):  # a machine that was busy a moment ago may be fast now, and one that stands still tells other lines
            began = time.monotonic()
            told = self.stroma("run", "fall.xml", "-n", str(steps), "--no-record").stderr.splitlines()
            self.assertLessEqual(len(told), 10 + (time.monotonic() - began) / 30)
            for line in told:
                self.assertTrue(PROGRESS.match(line), line)
            whole = [LINE.match(line) for line in told if LINE.match(line)]
            if whole:
                break
            steps *= 2
        self.assertTrue(whole, "no line tells the time to go")
        before = -1
        for match in whole:
            share = int(match.group(1)) / int(match.group(2))
            self.assertEqual(int(match.group(3)), int(100 * share))
            self.assertGreaterEqual(share, before)
            before = share
            self.assertGreaterEqual(seconds(match.group(4)), 0)  # how good it is: test_pace.cpp

    def test_a_run_of_a_moment_tells_nothing(self):
        self.write("fall.xml", FALLING)
        for _ in range(100):
            began = time.monotonic()
            told, took = self.stroma("run", "fall.xml", "-n", "50").stderr, time.monotonic() - began
            if took < 1:
                return self.assertEqual(told, "")
        self.skipTest("fifty steps are no moment here")

    def test_quiet_is_silent(self):
        self.write("fall.xml", FALLING)
        result = self.stroma("run", "fall.xml", "-n", str(self.steps_of("fall.xml", 1.6)), "--quiet")
        self.assertEqual(result.stdout + result.stderr, "")

    def on_terminal(self, width, *arguments):
        """All that the command writes on a terminal of `width` columns, pieces between carriage returns."""
        pid, terminal = pty.fork()
        if pid == 0:
            os.chdir(self.folder)
            os.environ["TERM"] = "xterm"
            fcntl.ioctl(2, termios.TIOCSWINSZ, struct.pack("HHHH", 24, width, 0, 0))
            os.execv(STROMA, [STROMA, *arguments])
        text = b""
        while True:
            try:
                piece = os.read(terminal, 65536)
            except OSError:  # the other end is closed
                break
            if not piece:
                break
            text += piece
        os.close(terminal)
        _, status = os.waitpid(pid, 0)
        self.assertEqual(os.waitstatus_to_exitcode(status), 0, text)
        return text.decode()

    def test_a_terminal_has_one_line_that_fits(self):
        self.write("fall.xml", FALLING)
        steps = self.steps_of("fall.xml", 0.6)
        for width in (200, 60, 40, 12):
            for _ in range(20):  # longer where the machine has become faster, or stood still when the time to go was to be told
                text = self.on_terminal(width, "run", "fall.xml", "-n", str(steps), "--no-record")
                *lines, summary = text.split("\r\x1b[K")
                lines = [line for line in lines if line]
                for line in lines:
                    self.assertLess(len(line), width)
                    self.assertNotIn("\n", line)
                told = [line for line in lines if line.startswith("step ")]
                self.assertEqual(lines[len(lines) - len(told):], told)  # those before are of the load
                self.assertTrue(summary.startswith("fall.xml: done"), repr(summary))  # the line is gone
                is_right = (len(told) > 1 and (width < 200 or any(LINE.match(line) for line in told))
                            and (width < 40 or any(line.endswith(" to go") for line in told)))
                if is_right:
                    break
                steps *= 2
            self.assertTrue(is_right, text)

    def drawn_by_load(self, scene, width, *options):
        """The lines that a load draws in place; the name of the scene's file, and of the node, is longer than a line."""
        name = "a scene whose name is longer than a line of the terminal " + "\u00e9" * 20
        self.write(name + ".xml", scene.replace("root", name))
        text = self.on_terminal(width, "run", name + ".xml", "-n", "0", "--no-record", *options)
        lines = [piece.split("\r\n")[0] for piece in text.split("\r\x1b[K")[1:]]
        lines = [line for line in lines if line and "done after" not in line and not line.startswith("step ")
                 and not re.search(r":\d+:\d+: (note|warning): ", line)]  # sentences on the scene, which follow the load
        for line in lines:
            self.assertLess(len(line.encode()), width, line)
        return lines

    def slow_to_load(self, seconds, operations):
        """A scene whose solver takes a time to make, and tells of so much long work meanwhile."""
        if not os.path.exists(MODULE):
            self.skipTest("the module with a solver that takes its time was not built")
        return f"""<Node name="root" dt="0.01" gravity="0 0 0"><EulerImplicitSolver/>
<SluggishSolver name="root" loading="{seconds}" operations="{operations}"/><MechanicalObject position="0 0 0"/><UniformMass totalMass="1"/></Node>
"""

    def test_the_line_of_a_load_fits(self):
        for taken in (1.3, 5, 30):  # the longer ones where nothing could be drawn meanwhile
            lines = self.drawn_by_load(self.slow_to_load(taken, 0), 40, "--module", MODULE)
            if lines:
                break
        self.assertTrue(lines and all(re.match("loading a sc.* s so far$", line) for line in lines), lines)

    def test_the_line_of_long_work_fits(self):
        for width, taken in ((40, 1.3), (12, 0)):  # longer than a load that draws its own line, and shorter
            lines = [line for line in self.drawn_by_load(self.slow_to_load(taken, 1e12), width, "--module", MODULE)
                     if "%" in line]  # others are of the load
            self.assertGreater(len(lines), 90)
            self.assertEqual(lines[-1][-5:], "100 %")

    def test_a_long_step_shows_life(self):
        for n in (16, 24, 32, 40):  # on a machine that is so fast
            self.write("bent.xml", BENT.format(n=n))
            text = self.on_terminal(200, "run", "bent.xml", "-n", "1", "--no-record")
            lines = [line for line in text.split("\r\x1b[K") if line.startswith("step ") and "so far" in line]
            iterations = {match.group(1) for match in re.finditer(r"Newton iteration (\d+), residual \S+", text)}
            whole = [line for line in lines if re.match(r"step 0/1  0 %  step 1: .* so far  Newton iteration \d+", line)]
            if len(lines) > 10 and len(iterations) > 1 and whole:
                return
        self.fail(text)


class DefaultRecording(Folder):
    def test_a_run_leaves_something_to_look_at(self):
        scene = self.write("fall.xml", FALLING)
        result = self.stroma("run", scene, "-n", "100")
        head, instants = self.instants(LAST)
        self.assertEqual((head["scene"], head["folder"]), (scene, os.path.realpath(self.folder)))
        times = [instant[0] for instant in instants]
        self.assertEqual(len(times), 21)
        for i, t in enumerate(times):
            self.assertAlmostEqual(t, 0.05 * i)
        for t, *numbers in instants:  # the velocity under a constant acceleration is exact for every scheme of order one
            self.assertAlmostEqual(numbers[7], -10 * t)
            self.assertEqual(numbers[3], 1)
        self.assertIn(f"recorded in {LAST}\n", result.stdout)
        self.assertIn(LAST + "/last.checkpoint", self.stroma("run", scene, "-n", "3", "--json").stdout)
        self.assertEqual([instant[0] for instant in self.instants(LAST)[1]], [0, 0.01, 0.02, 0.03])

    def test_the_instants_are_evenly_spread_whatever_the_steps(self):
        self.write("fall.xml", FALLING)
        for steps in (0, 1, 2, 19, 20, 21, 22, 41, 999, 20001, 43210, 163000):
            self.stroma("run", "fall.xml", "-n", str(steps), "-q")
            at = [round(instant[0] / 0.01) for instant in self.instants(LAST)[1]]
            self.assertEqual((at[0], at[-1]), (0, steps))
            self.assertGreaterEqual(len(at), min(steps + 1, 11), steps)
            self.assertLessEqual(len(at), 42)
            strides = {b - a for a, b in zip(at[:-1], at[1:-1])}
            self.assertLessEqual(len(strides), 1, (steps, at))

    def test_many_nodes_leave_fewer(self):
        self.write("many.xml", """<Node name="root" dt="0.01" gravity="0 -10 0"><EulerExplicitSolver/>
<RegularGridTopology n="50 50 50" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/></Node>
""")
        self.stroma("run", "many.xml", "-n", "40", "-q")
        self.assertLess(sum(os.path.getsize(file) for file in glob.glob(self.path("results/many/last", "*"))), 64 << 20)
        at = [round(instant[0] / 0.01) for instant in self.instants("results/many/last")[1]]
        self.assertEqual((at[0], at[-1]), (0, 40))
        self.assertGreater(len(at), 4)

    def test_no_bit_of_the_run_depends_on_it(self):
        for name in ("organ.xml", "organ_condensed.xml", "liver.xml"):
            scene = os.path.join(TREE, "scenes", "examples", name)
            hashes = {json.loads(self.stroma("run", scene, "-n", "30", "-q", "--json", *options).stdout)["state_hash"]
                      for options in ((), ("--no-record",))}
            self.assertEqual(len(hashes), 1, name)

    def test_no_record_leaves_nothing(self):
        self.write("fall.xml", FALLING)
        result = self.stroma("run", "fall.xml", "-n", "5", "--no-record")
        self.assertEqual(os.listdir(self.folder), ["fall.xml"])
        self.assertNotIn(LAST, result.stdout)
        self.stroma("run", "fall.xml", "--record", "out", "--no-record", code=2)

    def test_what_is_not_ours_stays(self):
        scene = self.write("fall.xml", FALLING)
        self.write(LAST, "a file of the user")
        note = self.notes(self.stroma("run", scene, "-n", "5"))
        self.assertEqual(note.count("\n"), 1)
        self.assertTrue(note.startswith("note: ") and LAST in note, note)
        self.assertEqual(self.read(LAST), b"a file of the user")
        os.remove(self.path(LAST))
        for contents in ((), ("notes.txt",), ("run.instants",), ("last.checkpoint",)):
            os.mkdir(self.path(LAST))
            for name in contents:
                self.write(os.path.join(LAST, name), "kept")
            self.assertIn(LAST, self.notes(self.stroma("run", scene, "-n", "5")))
            self.assertEqual(tuple(os.listdir(self.path(LAST))), contents)
            for name in contents:
                self.assertEqual(self.read(LAST, name), b"kept")
            shutil.rmtree(self.path(LAST))
        # beside what a run left, files of others stay too
        self.stroma("run", scene, "-n", "5")
        self.write(os.path.join(LAST, "picture.png"), "kept")
        self.assertEqual(self.notes(self.stroma("run", scene, "-n", "7")), "")
        self.assertEqual(self.read(LAST, "picture.png"), b"kept")
        self.assertEqual(len(self.instants(LAST)[1]), 8)

    def test_a_folder_that_record_names_is_the_users(self):
        self.write("fall.xml", FALLING)
        self.stroma("run", "fall.xml", "-n", "5")
        self.stroma("run", "fall.xml", "-n", "3", "--record", LAST)
        before = {name: self.read(LAST, name) for name in os.listdir(self.path(LAST))}
        self.assertEqual(sorted(before), ["dofs.state.gz", "last.checkpoint"])
        self.assertIn("note: ", self.notes(self.stroma("run", "fall.xml", "-n", "5")))
        self.assertEqual({name: self.read(LAST, name) for name in os.listdir(self.path(LAST))}, before)

    def test_a_place_that_cannot_be_written_is_a_note(self):
        scene = self.write("fall.xml", FALLING)
        result = self.stroma("run", scene, "-n", "5", cwd="/proc")
        self.assertEqual(self.notes(result).count("\n"), 1, result.stderr)
        self.assertTrue(self.notes(result).startswith("note: "), result.stderr)
        self.assertNotIn("recorded in", result.stdout)
        self.assertEqual(self.stroma("run", scene, "-n", "5", "--quiet", cwd="/proc").stderr, "")

    def test_a_full_disk_is_a_note(self):
        os.mkdir(self.path("disk"))
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", self.path("disk")], capture_output=True).returncode:
            self.skipTest("only root may mount a small disk")
        try:
            scene = self.write("many.xml", FALLING.replace("0 0 0  1 0 0", " ".join(f"{i} 0 0" for i in range(500))))
            result = self.stroma("run", scene, "-n", "50", cwd=self.path("disk"))
            self.assertIn("No space left on device", self.notes(result))
            self.assertEqual(self.notes(result).count("\n"), 1, result.stderr)
        finally:
            subprocess.run(["umount", self.path("disk")], check=True)

    def test_links_are_not_followed(self):
        scene = self.write("fall.xml", FALLING)
        self.stroma("run", scene, "-n", "5")
        os.rename(self.path(LAST), self.path("elsewhere"))
        os.symlink(os.path.join("..", "..", "elsewhere"), self.path(LAST))
        before = {name: self.read("elsewhere", name) for name in ("run.instants", "last.checkpoint")}
        for link in ((LAST,), (LAST, "run.instants"), (LAST, "last.checkpoint")):
            note = self.notes(self.stroma("run", scene, "-n", "7"))
            self.assertTrue(note.startswith("note: no recording is left") and note.count("\n") == 1, note)
            self.assertIn("/".join(link), note)
            self.assertTrue(os.path.islink(self.path(*link)))
            self.assertEqual({name: self.read("elsewhere", name) for name in before}, before)
            # the next one: one of the files is a link
            if os.path.islink(self.path(LAST)):
                os.remove(self.path(LAST))
                shutil.copytree(self.path("elsewhere"), self.path(LAST))
            else:
                os.remove(self.path(*link))
                shutil.copy(self.path("elsewhere", link[1]), self.path(*link))
            if link[-1] != "last.checkpoint":
                file = "run.instants" if link == (LAST,) else "last.checkpoint"
                os.remove(self.path(LAST, file))
                os.symlink(os.path.join("..", "..", "..", "elsewhere", file), self.path(LAST, file))
        self.assertEqual(self.notes(self.stroma("run", scene, "-n", "7")), "")

    def state_of_checkpoint(self, folder):
        """The hash of the state in the checkpoint of a folder, and the steps it has behind it."""
        shutil.copy(self.path(folder, "last.checkpoint"), self.path("copy.checkpoint"))
        result = json.loads(self.stroma("run", "fall.xml", "-n", "0", "--restart", "copy.checkpoint", "-q", "--json", "--no-record").stdout)
        return result["steps"]

    def test_of_runs_at_once_one_is_left_whole(self):
        self.write("fall.xml", FALLING)
        for _ in range(5):
            shutil.rmtree(self.path(LAST), ignore_errors=True)
            for again in range(2):  # where nothing is, and where something is
                runs = [subprocess.Popen([STROMA, "run", "fall.xml", "-q", "-n", str(steps)], cwd=self.folder, stderr=subprocess.PIPE)
                        for steps in (50, 60, 70, 80)]
                self.assertEqual([(run.wait(), run.communicate()[1]) for run in runs], 4 * [(0, b"")])
                self.assertEqual(sorted(os.listdir(self.path(LAST))), ["last.checkpoint", "run.instants"])
                last = self.instants(LAST)[1][-1][0]
                self.assertEqual(self.state_of_checkpoint(LAST), round(last / 0.01))
            self.assertEqual(os.listdir(os.path.dirname(self.path(LAST))), ["last"])

    def test_a_failed_write_leaves_the_run_before_whole(self):
        os.mkdir(self.path("disk"))
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "none", self.path("disk")], capture_output=True).returncode:
            self.skipTest("only root may mount a small disk")
        try:
            scene = self.write("many.xml", FALLING.replace("0 0 0  1 0 0", " ".join(f"{i} 0 0" for i in range(500))))
            self.stroma("run", scene, "-n", "1", cwd=self.path("disk"))
            before = {name: self.read("disk", "results/many/last", name) for name in ("run.instants", "last.checkpoint")}
            result = self.stroma("run", scene, "-n", "50", cwd=self.path("disk"))
            self.assertRegex(self.notes(result), r"^note: no recording is left: .*No space left on device.*; results/many/last is that of a run before\n$")
            self.assertEqual({name: self.read("disk", "results/many/last", name) for name in os.listdir(self.path("disk", "results/many/last"))}, before)
        finally:
            subprocess.run(["umount", self.path("disk")], check=True)

    def test_a_run_goes_on_from_its_own_folder(self):
        self.write("fall.xml", FALLING)
        self.stroma("run", "fall.xml", "-n", "10", "-q")
        restart = ("--restart", LAST + "/last.checkpoint", "-q")
        # a run that fails takes nothing away from what it went on from
        before = self.read(LAST, "last.checkpoint")
        self.stroma("run", "fall.xml", "-n", "90", "--set", "/.gravity=0 1e304 0", "--set", "/.dt=10", *restart, code=3)
        self.assertEqual(self.read(LAST, "last.checkpoint"), before)
        self.stroma("run", "fall.xml", "-n", "30", *restart)
        self.assertEqual(self.state_of_checkpoint(LAST), 30)

    def test_a_long_run_writes_now_and_then(self):
        self.write("fall.xml", FALLING)
        self.stroma("run", "fall.xml", "-n", "5")
        process = subprocess.Popen([STROMA, "run", "fall.xml", "-n", "1000000000", "-q", "--checkpoint-seconds", "0.2"], cwd=self.folder)
        self.addCleanup(process.kill)

        def is_written():
            """Looks while the run stands still, and leaves it so when it has written: else it lets it go on."""
            self.assertIsNone(process.poll(), "the run ends by itself")
            held_still(process)
            try:
                instants, checkpoint = (os.stat(self.path(LAST, name)).st_mtime_ns for name in ("run.instants", "last.checkpoint"))
                # the checkpoint is that of the instants: written after them
                if checkpoint >= instants and len(self.instants(LAST)[1]) > 6 and self.instants(LAST)[1][-1][0] > 1:
                    return True
            except FileNotFoundError:  # it stands between the two
                pass
            process.send_signal(signal.SIGCONT)
            return False
        until(is_written, "what is written now and then")
        process.kill()
        process.wait()
        instants = self.instants(LAST)[1]
        self.assertEqual(self.state_of_checkpoint(LAST), round(instants[-1][0] / 0.01))

    def test_closing_the_terminal_keeps_the_recording(self):
        self.write("fall.xml", TELLING)
        arguments = [STROMA, "run", "fall.xml", "-n", "1000000000"]
        process = subprocess.Popen(arguments, cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.until_it_steps(process)
        process.send_signal(signal.SIGHUP)
        out, _ = process.communicate()
        self.assertEqual(process.returncode, 129)
        self.assertIn(f"recorded in {LAST}", out)
        self.assertGreater(len(self.instants(LAST)[1]), 11)
        os.remove(self.path("steps.state"))
        process = subprocess.Popen(arguments, cwd=self.folder, stdout=subprocess.DEVNULL,
                                   preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))  # nohup
        self.addCleanup(process.kill)
        self.until_it_steps(process)
        process.send_signal(signal.SIGHUP)
        before = os.path.getsize(self.path("steps.state"))
        until(lambda: os.path.getsize(self.path("steps.state")) > before + 1000 or process.poll() is not None, "a run that goes on")
        self.assertIsNone(process.poll())
        process.terminate()
        self.assertEqual(process.wait(), 143)

    def test_a_reader_who_goes_does_not_end_the_run(self):
        self.write("fall.xml", FALLING)
        steps = self.steps_of("fall.xml", 1.6)
        for closed in ({"stdout"}, {"stderr"}, {"stdout", "stderr"}):
            texts = []
            while not texts:
                shutil.rmtree(self.path(LAST), ignore_errors=True)
                pipes = {name: subprocess.PIPE for name in ("stdout", "stderr")}
                process = subprocess.Popen([STROMA, "run", "fall.xml", "-n", str(steps), "--json"], cwd=self.folder, **pipes)
                for name in closed:
                    getattr(process, name).close()
                self.assertEqual(process.wait(5 * PATIENCE), 0)
                self.assertEqual(round(self.instants(LAST)[1][-1][0] / 0.01), steps)
                texts = [getattr(process, name).read() for name in set(pipes) - closed] or [b"nobody reads"]
                for name in set(pipes) - closed:
                    getattr(process, name).close()
                if closed == {"stdout"} and not texts[0]:
                    steps, texts = 2 * steps, []  # the run was so short that it told nothing of its progress
            self.assertTrue(all(texts), closed)

    def test_a_run_that_is_killed_leaves_what_was_there(self):
        self.write("fall.xml", TELLING)
        self.stroma("run", "fall.xml", "-n", "5")
        before = self.read(LAST, "run.instants")
        process = subprocess.Popen([STROMA, "run", "fall.xml", "-n", "1000000000", "-q", "--checkpoint-seconds", "0"], cwd=self.folder)
        self.addCleanup(process.kill)
        self.until_it_steps(process)
        process.kill()
        process.wait()
        self.assertEqual(sorted(os.listdir(self.path(LAST))), ["last.checkpoint", "run.instants"])
        self.assertEqual(self.read(LAST, "run.instants"), before)

    def test_an_interrupted_run_goes_on_from_it(self):
        self.write("fall.xml", TELLING)
        process = subprocess.Popen([STROMA, "run", "fall.xml", "-n", "1000000000"], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.until_it_steps(process)
        process.terminate()
        out, _ = process.communicate()
        self.assertEqual(process.returncode, 143)
        self.assertIn(f"recorded in {LAST}", out)
        steps = int(re.search(r"after (\d+) steps", out).group(1))
        instants = self.instants(LAST)[1]
        self.assertGreater(len(instants), 11)
        self.assertEqual(round(instants[-1][0] / 0.01), steps)
        on = self.stroma("run", "fall.xml", "-n", str(steps + 10), "--restart", LAST + "/last.checkpoint", "--json", "-q")
        self.assertEqual(json.loads(on.stdout)["state_hash"],
                         json.loads(self.stroma("run", "fall.xml", "-n", str(steps + 10), "--json", "-q").stdout)["state_hash"])


@unittest.skipUnless(HAS_VIEW, "the live view was not built")
class Looking(Folder):
    def frames_of(self, folder, *options):
        self.stroma("view", folder, "--export", "page.html", *options)
        self.assertGreater(os.path.getsize(self.path("page.html")), 100000)
        os.remove(self.path("page.html"))

    def test_the_commands_at_the_end_work(self):
        os.mkdir(self.path("my scenes"))
        scene = self.write(os.path.join("my scenes", "a block.xml"), """<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver/>
<CGLinearSolver/><RegularGridTopology name="grid" n="3 3 3" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>
<HexahedronFEMForceField youngModulus="3000" poissonRatio="0.3"/><FixedProjectiveConstraint indices="0 1 2"/></Node>
""")
        out = self.stroma("run", scene, "-n", "5", "--set", "/grid.n=4 4 4").stdout
        commands = out.rsplit("to look at it: ", 1)[1].strip().split("  or  ")
        views = [command for command in commands if " view " in command]
        self.assertEqual(len(views), 1, commands)
        # the overrides of the run are known: the scene alone has another number of nodes
        subprocess.run(views[0] + " --export page.html", shell=True, cwd=self.folder, check=True, capture_output=True)
        for command in commands:
            if " picture " in command:
                subprocess.run(command, shell=True, cwd=self.folder, check=True, capture_output=True)
            self.assertTrue(" view " in command or " picture " in command, command)
        results = json.loads(self.stroma("run", scene, "-n", "5", "--json", "-q").stdout)["results"]
        self.assertEqual(results["recording"], "results/a block/last")
        self.assertEqual(len(results["commands"]), len(commands))

    def test_every_example_can_be_looked_at(self):
        looked = 0
        for scene in sorted(glob.glob(os.path.join(TREE, "scenes", "examples", "*.xml"))):
            name = os.path.splitext(os.path.basename(scene))[0]
            with self.subTest(name):
                self.stroma("run", scene, "-n", "2", "-q")
                self.assertTrue(os.path.exists(self.path("results", name, "last", "run.instants")))
                self.frames_of(f"results/{name}/last")
                looked += 1
        self.assertGreater(looked, 10)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
