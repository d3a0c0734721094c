#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs what the pages show: every command, every scene, every output. Usage:
  run_documentation.py TREE BUILD PAGE...     PAGE as docs/view.md
  run_documentation.py TREE BUILD --not-run   lists the blocks that are only read, and counts them
  run_documentation.py TREE BUILD --self-test plants mistakes and expects each to be found

The blocks of a page are taken in order, in a folder of its own that looks like the source tree. sh: run by bash, which must end
well; folder and variables carry over to the next block. text after sh: its output, line by line in this order; numbers agree
within one per cent or one unit of the last digit shown, and "..." stands for anything. xml: a whole scene is written
under its title="NAME.xml" and checked by `stroma check`; a fragment says what it is part of. python: run with the module of
the build; what a page has defined carries over, and a text block after it is what it prints. cpp with a title: a whole file,
which must compile. Other blocks are not looked at. `stroma view` and `stroma watch` end only when somebody ends them: Ctrl-C
is pressed here when they have begun. What else can be asked for is in page_blocks.py."""
import glob
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "support")]
from fragments import FragmentError, is_whole, put  # noqa: E402
from page_blocks import PageError, blocks_of, missing_output  # noqa: E402
from tree_files import tree_files  # noqa: E402

MOST_NOT_RUN = 24
SECONDS = 1800  # of a block: a slow machine that has much else to do is given the time
WRAPPER = """#!/bin/bash
case "$1" in
  view) sign=http:// ;;
  watch) sign="waiting" ;;
  *) exec {stroma} "$@" ;;
esac
for argument; do case "$argument" in --export* | --times* | --help | -h) exec {stroma} "$@" ;; esac; done
exec {python} {interrupted} "$sign" {stroma} "$@"
"""


RUN_PYTHON = """import contextlib, io
with contextlib.redirect_stdout(io.StringIO()):
    exec(compile({before!r}, "the page before", "exec"), globals())
exec(compile({now!r}, "the page", "exec"), globals())
"""


class Wrong(Exception):
    """A page that says what is not so."""


class Page:
    """One page, its folder, and what its commands left there."""

    def __init__(self, tree, build, name, text):
        self.tree, self.build, self.name, self.text = os.path.abspath(tree), os.path.abspath(build), name, text
        self.folder = tempfile.mkdtemp(prefix="stroma_docs_")
        self.work, self.output, self.counts = os.path.join(self.folder, "stroma"), None, {"run": 0, "not run": 0}
        self.python = ""  # what the page has run so far
        self._lay_out()

    def close(self):
        """Removes the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _lay_out(self):
        """A folder like the source tree: scenes as copies, because commands may write beside them; the rest as links."""
        os.mkdir(self.work)
        linked = set()
        for path in tree_files(self.tree):
            top, copy = path.split("/")[0], os.path.join(self.work, path)
            if top == "scenes":
                os.makedirs(os.path.dirname(copy), exist_ok=True)
                shutil.copy(os.path.join(self.tree, path), copy)
            elif not top.startswith(".") and top not in linked:
                linked.add(top)
                os.symlink(os.path.join(self.tree, top), os.path.join(self.work, top))
        commands = os.path.join(self.work, "build", "release", "bin")
        os.makedirs(commands)
        for name in os.listdir(os.path.join(self.build, "bin")):
            if name != "stroma":
                os.symlink(os.path.join(self.build, "bin", name), os.path.join(commands, name))
        self.stroma = os.path.join(commands, "stroma")
        with open(self.stroma, "w", encoding="ascii") as file:
            file.write(WRAPPER.format(stroma=shlex.quote(os.path.join(self.build, "bin", "stroma")), python=shlex.quote(sys.executable),
                                      interrupted=shlex.quote(os.path.join(HERE, "interrupted.py"))))
        os.chmod(self.stroma, 0o755)
        os.mkdir(os.path.join(self.folder, "home"))
        self.state = os.path.join(self.folder, "state")
        with open(self.state, "w", encoding="utf-8") as file:
            file.write(f"cd {shlex.quote(self.work)}\n")

    def run(self):
        """All blocks; raises Wrong at the first that is not as the page says."""
        for block in blocks_of(self.text):
            if "not run" in block.asked:
                self.counts["not run"] += 1
                continue
            check = {"sh": self._sh, "bash": self._sh, "text": self._text, "xml": self._xml, "cpp": self._cpp,
                     "python": self._python}.get(block.language)
            try:
                if check:
                    check(block)
                    self.counts["run"] += 1
            except (Wrong, FragmentError) as error:
                raise Wrong(f"{self.name}:{block.line}: {error}") from error

    # ---- commands ----

    def _bash(self, script):
        environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
        environment.update(HOME=os.path.join(self.folder, "home"), LC_ALL="C.UTF-8", TERM="dumb", COLUMNS="120",
                           PATH=os.path.dirname(self.stroma) + ":/usr/bin:" + environment["PATH"])
        process = subprocess.Popen(["bash", "-c", script], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True)
        try:
            output, _ = process.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired as error:
            raise Wrong(f"the commands took more than {SECONDS} s") from error
        finally:  # with whatever it left running
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return subprocess.CompletedProcess(script, process.returncode, output)

    def _sh(self, block):
        script = (f"source {shlex.quote(self.state)}\nset -eo pipefail\n"
                  f"trap 'code=$?; {{ echo \"cd $(printf %q \"$PWD\")\"; export -p; }} > {shlex.quote(self.state)}; exit $code' EXIT\n"
                  + block.text)
        done = self._bash(script)
        self.output = done.stdout
        expected = int(block.asked.get("exit code", 0))
        if done.returncode != expected:
            raise Wrong(f"the commands ended with {done.returncode}, not {expected}:\n{block.text}{done.stdout[-3000:]}")

    def _python(self, block):
        path = self._write("block_of_page.py", RUN_PYTHON.format(before=self.python, now=block.text))
        module = os.pathsep.join(os.path.join(self.build, folder) for folder in ("python", "python_sofa"))
        done = self._bash(f"source {shlex.quote(self.state)}\nPYTHONDONTWRITEBYTECODE=1 PYTHONPATH={shlex.quote(module)} "
                          f"/usr/bin/python3 {shlex.quote(path)}")
        self.output = done.stdout
        if done.returncode:
            raise Wrong(f"the program ended with {done.returncode}:\n{done.stdout[-3000:]}")
        self.python += block.text

    def _text(self, block):
        if "not output" in block.asked or "formula" in block.asked:
            return
        if self.output is None:
            raise Wrong("a text block without commands before it (<!-- not output --> if it is none)")
        if not block.text.replace(".", "").strip():
            raise Wrong("an output that says nothing")
        missing = missing_output(block.text, self.output, "times vary" in block.asked)
        if missing is not None:
            raise Wrong(f"the output has no such line here:\n  {missing}\nIt was:\n{self.output[-3000:]}")

    # ---- files ----

    def _path(self, name):
        where = self._bash(f"source {shlex.quote(self.state)}; pwd").stdout.strip()
        path = os.path.normpath(os.path.join(where, name))
        if not path.startswith(self.folder):
            raise Wrong(f"{name} is outside the folder of the page")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return path

    def _write(self, name, text):
        path = self._path(name)
        if os.path.islink(os.path.dirname(path)):
            raise Wrong(f"{name} would be written into the source tree")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def _xml(self, block):
        text = block.text
        if "part of" in block.asked:
            host = self._path(block.asked["part of"])
            if not os.path.exists(host):
                raise Wrong(f"there is no {block.asked['part of']} to be part of")
            with open(host, encoding="utf-8") as file:
                text = put(text, file.read())
            place = os.path.dirname(block.asked["part of"])
            path = self._write(os.path.join(place, f"fragment_of_line_{block.line}.xml"), text)
        elif is_whole(text, block.title):
            path = self._write(block.title or f"scene_of_line_{block.line}.xml", text)
        elif block.title:  # a part that scenes include
            self._write(block.title, text)
            return
        else:
            raise Wrong("a fragment that does not say what it is part of (<!-- part of SCENE.xml -->)")
        done = self._bash(f"cd {shlex.quote(os.path.dirname(path))} && {shlex.quote(self.stroma)} check {shlex.quote(path)}")
        if "refused" in block.asked:
            if done.returncode != 2 or block.asked["refused"] not in done.stdout:
                raise Wrong(f"expected to be refused with '{block.asked['refused']}', but ({done.returncode}):\n{done.stdout}")
        elif done.returncode:
            raise Wrong(f"the scene is refused:\n{done.stdout}")

    def _cpp(self, block):
        if not block.title:
            return
        path = self._write(os.path.join(self.folder, "cpp", block.title), block.text)
        if path.endswith(".h"):
            return
        done = self._bash(f"cd {shlex.quote(self.folder)} && g++ -std=c++20 -fsyntax-only -march=x86-64-v3 -DEIGEN_MAX_ALIGN_BYTES=64 "
                          f"-DEIGEN_MAX_STATIC_ALIGN_BYTES=16 -I {shlex.quote(self.folder)}/cpp -I {shlex.quote(self.tree)} "
                          f"-I {shlex.quote(self.build)}/generated -I /usr/include/eigen3 {shlex.quote(path)}")
        if done.returncode:
            raise Wrong(f"it does not compile:\n{done.stdout[-3000:]}")


def run_page(tree, build, name, text):
    """Counts of a page; raises Wrong."""
    try:
        page = Page(tree, build, name, text)
    except PageError as error:
        raise Wrong(f"{name}: {error}") from error
    try:
        page.run()
        return page.counts
    except PageError as error:
        raise Wrong(f"{name}: {error}") from error
    finally:
        page.close()


def pages_of(tree):
    """README.md and all of docs/."""
    found = glob.glob(os.path.join(tree, "docs", "**", "*.md"), recursive=True)
    return ["README.md"] + sorted(os.path.relpath(path, tree) for path in found)


def read(tree, name):
    """The text of a page."""
    with open(os.path.join(tree, name), encoding="utf-8") as file:
        return file.read()


def list_not_run(tree):
    """Prints every block that is only read; too many are a failure."""
    count = 0
    for name in pages_of(tree):
        for block in blocks_of(read(tree, name)):
            if "not run" in block.asked:
                print(f"{name}:{block.line}: not run: {block.asked['not run']}")
                count += 1
    print(f"{count} blocks are not run (at most {MOST_NOT_RUN})")
    return count <= MOST_NOT_RUN


SCENE = """<Node dt="0.01" gravity="0 0 -9.81">
  <RegularGridTopology name="grid" n="3 3 5" min="0 0 0" max="0.02 0.02 0.08"/>
  <EulerImplicitSolver/> <CGLinearSolver iterations="50" tolerance="1e-8"/>
  <MechanicalObject/> <UniformMass totalMass="0.03"/>
  <HexahedronFEMForceField name="fem" method="polar" youngModulus="1e5" poissonRatio="0.4"/>
  <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
</Node>
"""
PLANTED = [  # page, what must be said of it (None: nothing is wrong)
    (f'```xml title="a.xml"\n{SCENE}```\n```sh\nstroma run a.xml -n 3 --quiet\n```\n', None),
    (f'```xml title="a.xml"\n{SCENE.replace("youngModulus", "youngModulos")}```\n', "the scene is refused"),
    (f'<!-- refused: youngModulus -->\n```xml\n{SCENE.replace("youngModulus", "youngModulos")}```\n', None),
    (f"<!-- refused: youngModulus -->\n```xml\n{SCENE}```\n", "expected to be refused"),
    ("```sh\nstroma runn a.xml\n```\n", "ended with 2"),
    ("<!-- exit code 2 -->\n```sh\nstroma runn a.xml\n```\n", None),
    ("```sh\nfalse | cat\necho on\n```\n", "ended with 1"),
    ("```sh\nmkdir -p b && cd b && export N=3\n```\n```sh\necho $N $(basename $PWD)\n```\n```text\n3 b\n```\n", None),
    ("```sh\necho tip 0.0312 m after 5 ms\n```\n```text\ntip 0.0313 m after 5 ms\n```\n", None),
    ("```sh\necho tip 0.0312 m after 5 ms\n```\n```text\ntip 0.0332 m after 5 ms\n```\n", "no such line"),
    ("```sh\necho tip 0.0312 m after 5 ms\n```\n```text\ntip 0.0312 m after 9 ms\n```\n", "no such line"),
    ("```sh\necho tip 0.0312 m after 5 ms\n```\n<!-- times vary -->\n```text\ntip 0.0312 m ... 9 ms\n```\n", None),
    ("```sh\necho 5.1 % off, 9 ms\n```\n<!-- times vary -->\n```text\n5.9 % off, 2 ms\n```\n", "no such line"),
    ("```sh\necho 5.1 % off, 9 ms\n```\n<!-- times vary -->\n```text\n5.1 % off, 2 ms\n```\n", None),
    ("```python\na = 2\nprint(a)\n```\n```python\nprint(a + 1)\n```\n```text\n3\n```\n", None),
    ("```python\nprint(1)\n```\n```text\n5\n```\n", "no such line"),
    ("```python\nraise KeyError('x')\n```\n", "ended with 1"),
    ("```\nw = 3\n```\n", "without a language"),
    ("<!-- formula -->\n```text\nw = 3\n```\n", None),
    ("```sh\necho tip 1 of 2; echo end\n```\n```text\nend\ntip 1 of 2\n```\n", "no such line"),
    ("```sh\necho a tip\n```\n```text\na tap\n```\n", "no such line"),
    ("```sh\necho a\n```\n```text\n...\n```\n", "says nothing"),
    ("```text\nalone\n```\n", "without commands"),
    ('```xml\n<UniformMass totalMass="1"/>\n```\n', "does not say what it is part of"),
    ('<!-- part of scenes/examples/organ.xml -->\n```xml\n<TetrahedronFEMForceField youngModulus="1e4" poissonRatio="0.4" '
     'method="svd"/>\n```\n', None),
    ('<!-- part of scenes/examples/organ.xml -->\n```xml\n<TetrahedronFEMForceField youngModulus="1e4" poissonRatio="0.4" '
     'method="svt"/>\n```\n', "svd"),
    ("<!-- not run: no network -->\n```sh\nfalse\n```\n", None),
    ("<!-- not run: -->\n```sh\nfalse\n```\n", "without a reason"),
    ("<!-- not run: x -->\n\nText.\n\n```sh\nfalse\n```\n", "above no block"),
    ("```sh\nstroma view scenes/examples/cantilever_polar.xml\n```\n", None),
    ("```sh\nstroma view scenes/examples/none.xml\n```\n", "ended with 2"),
    ('```cpp title="a.cpp"\nint f() { return 1; }\n```\n', None),
    ('```cpp title="a.cpp"\nint f() { return g(); }\n```\n', "does not compile"),
]

NAMED_BY_PLANTED = ["scenes/examples/organ.xml", "scenes/examples/cantilever_polar.xml", "scenes/examples/parts/beam.xml",
                    "scenes/meshes/organ_600.msh"]


def self_test(tree, build):
    """Every planted mistake is found, and nothing else. The planted pages have the few files of the tree that they name: to copy all
    scenes for each takes longer than what it shows."""
    with tempfile.TemporaryDirectory() as small:
        for path in NAMED_BY_PLANTED:
            os.makedirs(os.path.join(small, os.path.dirname(path)), exist_ok=True)
            shutil.copy(os.path.join(tree, path), os.path.join(small, path))
        for number, (text, expected) in enumerate(PLANTED):
            try:
                run_page(small, build, f"planted_{number}.md", text)
                said = None
            except Wrong as error:
                said = str(error)
            assert (said is None) == (expected is None) and (expected is None or expected in said), (text, expected, said)
    print(f"{len(PLANTED)} planted pages, all judged as they should be")


def main():
    tree, build, *rest = sys.argv[1:] if len(sys.argv) > 3 else sys.exit(__doc__)
    if rest == ["--self-test"]:
        self_test(tree, build)
        return
    if rest == ["--not-run"]:
        sys.exit(0 if list_not_run(tree) else 1)
    for name in rest:
        try:
            counts = run_page(tree, build, name, read(tree, name))
        except Wrong as error:
            sys.exit(str(error))
        print(f"{name}: {counts['run']} blocks are as the page says, {counts['not run']} not run")


if __name__ == "__main__":
    main()
