#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lines that a person completes with the tab key in an interactive bash, behind a terminal; also with scenes whose names are
commands. Usage: test_completion_in_bash.py STROMA. Ends with 77 where there is no bash."""
import os
import pty
import select
import shutil
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import PATIENCE  # noqa: E402

STROMA = os.path.abspath(sys.argv[1])
SCENE = """<Node name="root" dt="0.01"><Node name="my"><MechanicalObject name="dofs"/>
<HexahedronFEMForceField name="fem" method="polar"/></Node></Node>
"""
HOSTILE = ["$(touch PWNED)", "`touch PWNED`", ";touch PWNED;", "&touch${IFS}PWNED", "two words", "a&#10;=/evil/", "a&#9;b", "'quote",
           "&quot;quote", "&amp;&amp;touch PWNED", "|touch PWNED", "&gt;PWNED", "\\back", "*", "~root", "!!", "{a,b}", "#no", "&#27;[31mred"]


class Bash:
    """An interactive bash; a line is typed, completed with tabs, and read back with control-o."""

    def __init__(self, folder):
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.environ.update(HOME=folder, PATH=folder + ":" + os.environ["PATH"], TERM="dumb", HISTFILE="", INPUTRC="/dev/null", FOLDER=folder)
            os.execlp("bash", "bash", "--norc", "--noprofile", "-i")
        self.folder = folder
        self.type("source script.bash; bind 'set bell-style none'; bind -x '\"\\C-o\": printf \"%s\\n\" \"$READLINE_LINE\""
                  " >line.txt; READLINE_LINE='; echo up >ready.txt\r")
        self.wait("ready.txt")

    def type(self, text):
        os.write(self.terminal, text.encode())

    def wait(self, name):
        path, until = os.path.join(self.folder, name), time.monotonic() + PATIENCE
        while time.monotonic() < until:
            if os.path.exists(path) and os.path.getsize(path) > 0:
                with open(path, encoding="utf-8") as text:
                    found = text.read()
                if found.endswith("\n"):
                    os.remove(path)
                    return found[:-1]
            if select.select([self.terminal], [], [], 0.02)[0]:
                os.read(self.terminal, 65536)  # what is shown; unread, it would hold bash up
        raise AssertionError(f"bash did not write {name}")

    def completed(self, line, tabs=1):
        self.type(line + "\t" * tabs + "\x0f")
        return self.wait("line.txt")

    def close(self):
        self.type("\x15exit\r")
        os.close(self.terminal)
        os.waitpid(self.pid, 0)


class Completion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="stroma_completion_")
        self.addCleanup(shutil.rmtree, self.folder)
        os.symlink(STROMA, os.path.join(self.folder, "stroma"))
        os.mkdir(os.path.join(self.folder, "my scenes"))
        self.write("organ.xml", SCENE)
        self.write("my scenes/liver.xml", SCENE)
        os.system(f"'{STROMA}' completion bash >'{self.folder}/script.bash'")
        self.bash = Bash(self.folder)
        self.addCleanup(self.bash.close)

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as out:
            out.write(text)

    def test_lines_as_people_type_them(self):
        for line, expected in (
                ("stroma ru", "stroma run "),
                ("stroma run org", "stroma run organ.xml "),
                ("stroma run my", "stroma run my\\ scenes/"),
                ("stroma run my\\ scenes/l", "stroma run my\\ scenes/liver.xml "),
                ("stroma run 'my scenes/l", "stroma run 'my scenes/liver.xml' "),
                ("stroma run ~/or", "stroma run ~/organ.xml "),
                ("stroma run organ.xml --set /my/fem.young", "stroma run organ.xml --set /my/fem.youngModulus="),
                ("stroma run 'my scenes/liver.xml' --set /my/fem.young",
                 "stroma run 'my scenes/liver.xml' --set /my/fem.youngModulus="),
                ("stroma run my\\ scenes/liver.xml --set /my/fem.method=sv",
                 "stroma run my\\ scenes/liver.xml --set /my/fem.method=svd "),
                ("stroma run \"$HOME/organ.xml\" --set /my/d", "stroma run \"$HOME/organ.xml\" --set /my/dofs."),
                ("stroma run ${FOLDER}/organ.xml --set /my/d", "stroma run ${FOLDER}/organ.xml --set /my/dofs."),
                ("stroma run ~/organ.xml --set /my/d", "stroma run ~/organ.xml --set /my/dofs."),
                ("stroma run organ.xml --set \"/my/fem.young", "stroma run organ.xml --set \"/my/fem.youngModulus="),
                ("stroma run organ.xml --set '/my/d", "stroma run organ.xml --set '/my/dofs."),
                ("stroma run organ.xml --set=/my/fem.method=sv", "stroma run organ.xml --set=/my/fem.method=svd "),
                ("~/stroma ru", "~/stroma run "),
                ("cd . && stroma ru", "cd . && stroma run ")):
            # an open quote is closed again where a word ends
            self.assertEqual(self.bash.completed(line).rstrip("'\""), expected.rstrip("'\""), line)

    def test_nothing_of_the_line_is_executed(self):
        for line in ("stroma run $(touch PWNED)/x --set /", "stroma run `touch PWNED` --set /", "stroma run \"$(touch PWNED)\" --set /m",
                     "stroma run ${x:=$(touch PWNED)} --set /", "stroma run organ.xml --set '$(touch PWNED)"):
            self.assertEqual(self.bash.completed(line, tabs=2), line)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "PWNED")))

    def test_names_that_are_commands_are_not_offered(self):
        for name in HOSTILE:
            self.write("hostile.xml", f'<Node><Node name="{name}"><MechanicalObject name="dofs"/></Node></Node>')
            for line in ("stroma run hostile.xml --set /", "stroma run hostile.xml --set \"/", "stroma run hostile.xml --set '/"):
                self.assertEqual(self.bash.completed(line, tabs=2), line, name)
            self.write("hostile.xml", f'<Node><HexahedronFEMForceField name="fem" method="{name}"/></Node>')
            self.assertEqual(self.bash.completed("stroma run hostile.xml --set /fem.method=x", tabs=2),
                             "stroma run hostile.xml --set /fem.method=x", name)
        self.write("hostile.xml", '<Node><Node name="good_one-1"/></Node>')
        self.assertEqual(self.bash.completed("stroma run hostile.xml --set /"), "stroma run hostile.xml --set /good_one-1/")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "PWNED")))


if __name__ == "__main__":
    if not shutil.which("bash"):
        print("skipped: there is no bash")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
