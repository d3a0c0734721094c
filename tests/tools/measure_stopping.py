#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How long Ctrl-C and SIGTERM take within long steps: stopped at random moments, by a seed.

  tests/tools/measure_stopping.py COMMAND [MOMENTS [SEED]]

COMMAND is the stroma command. Runs bodies of 19,844 nodes whose static step takes from some seconds to minutes, ends each
at a moment drawn from its first seconds, and prints the seconds from the signal to the end of the process: on the wall,
and of the processor, which other work on the machine does not lengthen. Each run must end with 130 or 143 and leave a
recording and a checkpoint that the command goes on from. Ends with 1 when one does not. Not part of the tests: times
depend on the machine."""
import gzip
import os
import random
import signal
import subprocess
import sys
import tempfile
import time

SCENE = """<Node name="root" dt="1" gravity="0 -9.81 0">
  <StaticSolver/>{solver}
  <RegularGridTopology name="grid" n="41 22 22" min="0 0 0" max="0.2 0.1 0.1"/>
  <MechanicalObject name="dofs" position="@grid.position"/>
  <UniformMass totalMass="2"/>
  <HexahedronFEMForceField youngModulus="4000" poissonRatio="0.4" {law}/>
  <BoxROI name="end" box="-0.001 -1 -1  0.001 1 1"/>
  <FixedProjectiveConstraint indices="@end.indices"/>
</Node>
"""
# the solver, the law, and the seconds from which moments are drawn
KINDS = {
    "Cholesky": ("<SparseLDLSolver/>", 'method="svd"', 25),
    "LU": ("<SparseLDLSolver/>", 'method="svd" tangent="exact"', 60),
    "CG": ("<CGLinearSolver/>", 'method="svd"', 25),
    "PCG, incomplete Cholesky": ('<PCGLinearSolver preconditioner="incomplete_cholesky"/>', 'method="svd"', 25),
    "PCG, warped": ('<PCGLinearSolver preconditioner="warped"/><SparseLDLSolver/>', 'method="svd"', 25),
}


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def started(pid, folder):
    """Waits until the first instant is recorded: from then on signals are the run's."""
    for _ in range(6000):
        if os.path.exists(os.path.join(folder, "out", "dofs.state.gz")):
            return
        if os.waitpid(pid, os.WNOHANG)[0]:
            raise RuntimeError("the run ended before its first step")
        time.sleep(0.01)
    raise RuntimeError("the run did not begin")


def problems_of(command, folder, scene, code, number):
    found = []
    if code != 128 + number:
        found.append(f"exit code {code}")
    recording = os.path.join(folder, "out", "dofs.state.gz")
    try:
        with gzip.open(recording) as file:
            file.read()
    except (OSError, EOFError) as error:
        found.append(f"recording: {error}")
    if not os.path.exists(os.path.join(folder, "out", "last.checkpoint")):
        found.append("no checkpoint")
    elif subprocess.run([command, "run", scene, "--quiet", "--record", "out", "--resume", "-n", "0"], cwd=folder,
                        capture_output=True, check=False).returncode != 0:
        found.append("the run does not go on")
    return found


def stopped(command, folder, scene, moment, number):
    """Wall and processor seconds from the signal to the end, and what was wrong."""
    with subprocess.Popen([command, "run", scene, "--quiet", "--record", "out", "-n", "1"], cwd=folder,
                          stderr=subprocess.DEVNULL) as process:
        started(process.pid, folder)
        time.sleep(moment)
        before = processor_seconds(process.pid)
        start = time.monotonic()
        os.kill(process.pid, number)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
    return wall, usage.ru_utime + usage.ru_stime - before, process.returncode


def main():
    command = os.path.abspath(sys.argv[1])
    moments = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    times, bad = {kind: [] for kind in KINDS}, []
    for index in range(moments):
        kind = list(KINDS)[index % len(KINDS)]
        solver, law, seconds = KINDS[kind]
        number = chance.choice([signal.SIGINT, signal.SIGTERM])
        moment = chance.uniform(0, seconds)
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "long.xml"), "w", encoding="utf-8") as file:
                file.write(SCENE.format(solver=solver, law=law))
            try:
                wall, processor, code = stopped(command, folder, "long.xml", moment, number)
            except (RuntimeError, ProcessLookupError, FileNotFoundError) as error:
                print(f"{kind}, {moment:.2f} s: {error}", flush=True)
                continue
            if code == 0:
                if processor > 1:
                    bad.append(f"{kind}, {moment:.2f} s: the signal was lost, and the run went on for {wall:.1f} s")
                continue  # it was over before
            times[kind].append((wall, processor))
            for problem in problems_of(command, folder, "long.xml", code, number):
                bad.append(f"{kind}, {moment:.2f} s: {problem}")
    print(f"{'solver':26} {'moments':>8} {'median':>8} {'most':>8}   processor: {'median':>8} {'most':>8}")
    for kind, values in times.items():
        if values:
            walls, own = sorted(v[0] for v in values), sorted(v[1] for v in values)
            print(f"{kind:26} {len(values):8} {walls[len(walls) // 2]:8.2f} {walls[-1]:8.2f}   "
                  f"           {own[len(own) // 2]:8.2f} {own[-1]:8.2f}")
    for line in bad:
        print(line)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
