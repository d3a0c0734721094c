# SPDX-License-Identifier: LGPL-2.1-or-later
"""A copy of the tree with a build of its own, in which one site after another is made wrong, built and tested."""
import concurrent.futures
import glob
import hashlib
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import time

# Tests of the project that run the engine; the others read sources, or build what no change of the engine touches.
PROJECT_TESTS = ["regression", "bits", "example_scenes", "kill_and_resume"]
LEFT_OUT = ("test_pack_",)  # programs of other instruction sets
UNIT_SECONDS = 5  # tests of one program that run in one process
SLOW = 6  # seconds of tests that wait until the quicker ones have been run
MEMORY, LARGEST_FILE = 12 << 30, 2 << 30
LOADED = re.compile(r"/lib/stroma/(?:x86-64-v\d/)?(\w+)\.so")


def copy_tree(source, target):
    """What git knows of the tree, and what it would take in; files that are the same keep their times."""
    if os.path.exists(os.path.join(target, ".git")):
        raise SystemExit(f"{target} is a work tree of git, and not a copy that may be changed")
    names = subprocess.run(["git", "-C", source, "ls-files", "-co", "--exclude-standard", "-z"], check=True,
                           capture_output=True).stdout.decode().split("\0")
    for name in filter(None, names):
        there, here = os.path.join(source, name), os.path.join(target, name)
        if not os.path.isfile(there):
            continue
        with open(there, "rb") as file:
            data = file.read()
        if name == "framework/CMakeLists.txt":  # else each change of a header would build everything
            data = data.replace(b"set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${headers})\n", b"")
        if os.path.exists(here):
            with open(here, "rb") as file:
                if file.read() == data:
                    continue
        os.makedirs(os.path.dirname(here), exist_ok=True)
        with open(here, "wb") as file:
            file.write(data)
        shutil.copymode(there, here)


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha1(file.read()).hexdigest()


class Unit:
    """Tests that run in one process: part of a GoogleTest program, or one test of the project."""

    def __init__(self, name, folder, command, tests, seconds, modules=None):
        self.name, self.folder, self.command, self.tests = name, folder, command, tests
        self.seconds, self.modules = seconds, modules


class Trials:
    def __init__(self, tree, work, copy, jobs, configuration, without=None):
        self.without = re.compile(without) if without else None
        self.jobs, self.work, self.tree = jobs, os.path.abspath(work), os.path.abspath(copy)
        self.build = os.path.join(self.tree, "build", "release")
        self.source, self.configuration = tree, configuration
        self.objects, self.units, self.mentions = {}, [], {}
        self.noticed = {}  # (file or folder, unit): how often

    # ---- building ----

    def ninja(self, *targets, seconds=1800):
        """(went well, what it said)"""
        try:
            run = subprocess.run(["ninja", "-C", self.build, f"-j{self.jobs}", *targets], capture_output=True, text=True,
                                 timeout=seconds)
        except subprocess.TimeoutExpired:
            return False, "the build took too long"
        return run.returncode == 0, run.stdout + run.stderr

    def prepare(self, say):
        copy_tree(self.source, self.tree)
        say("configuring and building the copy")
        subprocess.run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DSTROMA_TESTS=ON", "-DCMAKE_LINK_DEPENDS_NO_SHARED=ON", *self.configuration], check=True,
                       stdout=subprocess.DEVNULL)
        well, said = self.ninja("all")
        if not well:
            raise SystemExit(f"the unchanged copy does not build:\n{said[-3000:]}")
        for path in glob.glob(os.path.join(self.build, "**", "*.o"), recursive=True):
            self.objects[path] = digest(path)

    def changed_objects(self, since):
        return [path for path, known in self.objects.items()
                if os.path.getmtime(path) >= since and digest(path) != known]

    # ---- the tests of the unchanged copy ----

    def measure(self, say):
        """Runs all tests once: how long each takes, and which modules its program opens. What fails here is left out."""
        stamp = hashlib.sha1("".join(sorted(self.objects.values())).encode()).hexdigest()
        store = os.path.join(self.work, "baseline.json")
        known = {}
        if os.path.exists(store):
            with open(store, encoding="utf-8") as file:
                known = json.load(file)
        if known.get("stamp") != stamp:
            known = {"stamp": stamp, "programs": {}}
        programs = known["programs"]
        wanted = [os.path.basename(path) for path in sorted(glob.glob(os.path.join(self.build, "bin", "test_*")))]
        wanted = [name for name in wanted if not name.startswith(LEFT_OUT)] + ["project." + name for name in PROJECT_TESTS]
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            runs = {pool.submit(self.measure_one, name): name for name in wanted if name not in programs}
            for run in concurrent.futures.as_completed(runs):
                programs[runs[run]] = run.result()
                say(f"measured {runs[run]}")
        with open(store, "w", encoding="utf-8") as file:
            json.dump(known, file)
        self.make_units(programs, say)

    def project_command(self, name):
        return ["ctest", "--test-dir", self.build, "-R", f"^project.{name}$", "--no-tests=error", "--output-on-failure"]

    def measure_one(self, name):
        if name.startswith("project."):
            start = time.time()
            run = self.start(self.project_command(name[8:]), 900)
            well = run.wait() == 0
            return {"seconds": time.time() - start, "well": well}
        return self.measure_program(os.path.join(self.build, "bin", name))

    def measure_program(self, program):
        folder = os.path.join(self.work, "measure", os.path.basename(program))
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        report = os.path.join(folder, "report.json")
        run = self.start([program, "--gtest_output=json:" + report], 1800,
                         {"LD_DEBUG": "files", "LD_DEBUG_OUTPUT": os.path.join(folder, "opened")})
        run.wait()
        tests, failed = {}, []
        if os.path.exists(report):
            with open(report, encoding="utf-8") as file:
                for suite in json.load(file)["testsuites"]:
                    for test in suite["testsuite"]:
                        full = f'{suite["name"]}.{test["name"]}'
                        if test.get("failures"):
                            failed.append(full)
                        elif test["result"] == "COMPLETED":
                            tests[full] = float(test["time"].rstrip("s"))
        modules = set()
        for path in glob.glob(os.path.join(folder, "opened*")):
            with open(path, encoding="utf-8", errors="replace") as file:
                modules |= set(LOADED.findall(file.read()))
        return {"tests": tests, "failed": failed, "modules": sorted(modules)}

    def make_units(self, programs, say):
        left_out = []
        for name, found in programs.items():
            if "tests" not in found:
                if found["well"]:
                    self.units.append(Unit(name, "project", self.project_command(name[8:]), None, found["seconds"]))
                else:
                    left_out.append(name)
                continue
            left_out += found["failed"]
            program, folder = os.path.join(self.build, "bin", name), name[5:]
            modules, part, sum_of_part = found["modules"], [], 0
            tests = sorted((one for one in found["tests"].items() if not (self.without and self.without.search(one[0]))),
                           key=lambda one: one[1])
            for index, (test, seconds) in enumerate(tests):
                part.append(test)
                sum_of_part += seconds
                last = index + 1 == len(tests)
                if last or sum_of_part + tests[index + 1][1] > UNIT_SECONDS:
                    number = sum(1 for unit in self.units if unit.folder == folder)
                    self.units.append(Unit(f"{name}#{number}", folder, [program, "--gtest_fail_fast"], part,
                                           sum_of_part, modules))
                    part, sum_of_part = [], 0
        if left_out:
            say("fail in the unchanged copy and are left out: " + ", ".join(left_out))
        for unit in self.units:
            if unit.folder not in self.mentions:
                text = ""
                for path in glob.glob(os.path.join(self.tree, "tests", unit.folder, "*.cpp")):
                    with open(path, encoding="utf-8") as file:
                        text += file.read()
                self.mentions[unit.folder] = text
        say(f"{len(self.units)} units of tests, {sum(unit.seconds for unit in self.units):.0f} s")

    # ---- running tests ----

    def start(self, command, seconds, more=None):
        folder = os.path.join(self.work, "run")
        os.makedirs(folder, exist_ok=True)

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        out = open(os.path.join(folder, f"out{time.monotonic_ns()}"), "w+", encoding="utf-8", errors="replace")
        run = subprocess.Popen(command, cwd=folder, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                               start_new_session=True, preexec_fn=limit, env={**os.environ, **(more or {})})
        run.out, run.until = out, time.time() + seconds
        return run

    @staticmethod
    def end(run):
        """The process that was started here, and those that it started."""
        try:
            os.killpg(run.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        run.wait()

    @staticmethod
    def said(run):
        run.out.seek(0)
        text = run.out.read()
        run.out.close()
        os.unlink(run.out.name)
        return text

    def in_order(self, site):
        """The units that can notice a change of the site's file, those likely to notice it soon first."""
        top, folder, name = site.path.split("/")[:3]
        stem = name.split(".")[0]
        words = {stem, "".join(word.capitalize() for word in stem.split("_"))}

        def key(unit):
            text = self.mentions.get(unit.folder, "")
            mentioned = any(word in text for word in words)
            here = self.noticed.get((site.path, unit.name), 0) > 0
            return (not here, unit.seconds > SLOW, unit.folder != folder, not mentioned,
                    -self.noticed.get((folder, unit.name), 0), unit.folder == "project", unit.seconds)

        can = [unit for unit in self.units
               if top == "framework" or unit.modules is None or folder in unit.modules or unit.folder == folder
               or f'"components/{folder}/' in self.mentions.get(unit.folder, "")]
        return sorted(can, key=key)

    def test(self, units):
        """(the test that notices what was changed and its unit, or None; the names of the units that have passed)"""
        waiting, running, passed = list(units), [], []
        notice = None
        while (waiting or running) and notice is None:
            while waiting and len(running) < self.jobs:
                unit = waiting.pop(0)
                command = unit.command + ([] if unit.tests is None else ["--gtest_filter=" + ":".join(unit.tests)])
                run = self.start(command, 60 + 15 * unit.seconds)
                run.unit = unit
                running.append(run)
            time.sleep(0.02)
            for run in list(running):
                code = run.poll()
                if code is None and time.time() < run.until:
                    continue
                running.remove(run)
                if code is None:
                    self.end(run)
                said = self.said(run)
                if code == 0:
                    passed.append(run.unit.name)
                    continue
                what = self.failure(said, code, run.unit) if code else self.last_test(said) + " (does not end)"
                notice = f"{run.unit.name.split('#')[0]}: {what}", run.unit
                break
        for run in running:
            self.end(run)
            self.said(run)
        return notice, passed

    @staticmethod
    def last_test(said):
        started = re.findall(r"\[ RUN      \] (\S+)", said)
        return started[-1] if started else "the run"

    def failure(self, said, code, unit):
        failed = re.search(r"\[  FAILED  \] ([\w./]+)", said)
        if failed:
            return failed.group(1)
        if unit.tests is None:
            return "fails"
        return f"{self.last_test(said)} (ends with {code})"

    # ---- one change ----

    def write(self, path, text):
        with open(os.path.join(self.tree, path), "w", encoding="utf-8") as file:
            file.write(text)

    def built(self, changed, texts, tests):
        """Builds the tree with these sites changed and calls `tests`, which returns a verdict and more. The files are as
        before when this returns; the next build sees to the rest."""
        start = time.time()
        for path in {site.path for site in changed}:
            text = texts[path]
            for site in sorted((site for site in changed if site.path == path), key=lambda site: -site.start):
                text = site.apply(text)
            self.write(path, text)
        try:
            well, said = self.ninja("all", seconds=900)
            self.build_seconds = time.time() - start
            if not well:
                # The index of a module is made by opening it: a change can be noticed there.
                if "Indexing" in said.split("FAILED")[-1] or "stroma-index" in said and "error:" not in said:
                    return "noticed", "the build, which opens the module", []
                return "does not compile", "", []
            if not self.changed_objects(start - 1):
                return "same code", "", []
            return tests()
        finally:
            for path in {site.path for site in changed}:
                self.write(path, texts[path])

    def try_site(self, site, texts, first_seconds):
        """(verdict, which test, units that have passed). Without a notice after so many seconds of tests: pending."""
        def tests():
            units, seconds = [], 0
            for unit in self.in_order(site):
                if seconds < first_seconds:
                    units.append(unit)
                    seconds += unit.seconds
            notice, passed = self.test(units)
            if notice is None:
                return "pending", "", passed
            for place in (site.path, site.path.split("/")[1]):
                self.noticed[place, notice[1].name] = self.noticed.get((place, notice[1].name), 0) + 1
            return "noticed", notice[0], passed
        return self.built([site], texts, tests)

    def try_group(self, group, texts, passed):
        """Runs what is left of the tests on all of these sites together: (verdict, which test, units that have passed)."""
        def tests():
            wanted = {}
            for site, before in zip(group, passed):
                wanted.update({unit.name: unit for unit in self.in_order(site) if unit.name not in before})
            notice, well = self.test(sorted(wanted.values(), key=lambda unit: unit.seconds))
            return ("noticed", notice[0], well) if notice else ("survived", "", well)
        return self.built(group, texts, tests)
