#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Kills runs at random moments and lets them go on: nothing may be lost, and no bit may differ.

A scene with everything that remembers (viscosity, pore pressure, integrators of several steps) and every kind of output
runs once without interruption. Then it runs again with --resume, and SIGKILL ends it at a random moment, again and
again. After each kill every recording must be a beginning of the whole one, with all that the checkpoint before had, and
ReadState must read it. When a run reaches its end, every file must have the bytes of the run that was never killed."""

import argparse
import gzip
import io
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENE = """<Node name="root" dt="0.0078125" gravity="0 0 -9.81">
  <Node name="soft">
    <RegularGridTopology name="grid" n="3 3 6" min="0 0 0" max="0.04 0.04 0.1"/>
    <BDFOdeSolver order="2"/><SparseLDLSolver/>
    <Node name="b">
      <TetrahedronSetTopologyContainer name="tets"/><Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
      <MechanicalObject name="dofs"/><UniformMass totalMass="0.1"/>
      <TetrahedronHyperelasticityFEMForceField materialName="NeoHookean" youngModulus="5000" poissonRatio="0.4"
          viscous="true" ParameterAlpha="0.5" ParameterTau="0.3"/>
      <TetrahedronPorousForceField fluidFraction="0.5" bulkModulus="400" limitModulus="2200" permeability="1e-7"/>
      <FixedProjectiveConstraint indices="0 1 2 3 4 5 6 7 8"/>
      <Monitor name="tip" indices="53" ExportPositions="true" ExportVelocities="true" ExportForces="true"/>
      <WriteState filename="all.state" period="0.03"/>
      <WriteState name="zipped" filename="all.state.gz" writeV="true"/>
      <VTKExporter filename="pictures/body" exportEveryNumberOfSteps="20" exportAtBegin="true"/>
    </Node>
  </Node>
  <EnergyMonitor filename="energy.txt"/>
</Node>
"""
READER = """<Node name="root" dt="0.0078125"><EulerExplicitSolver/>
  <RegularGridTopology name="grid" n="3 3 6" min="0 0 0" max="0.04 0.04 0.1"/>
  <MechanicalObject name="dofs"/><UniformMass totalMass="0.1"/><ReadState filename="{file}"/>
</Node>
"""
GROWING = ["energy.txt", "tip_x.txt", "tip_v.txt", "tip_f.txt", "all.state", "all.state.gz", "out/soft.b.dofs.state.gz"]
RECORDINGS = [name for name in GROWING if ".state" in name]


def contents(folder):
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix not in (".xml", ".part")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def has_instant(data, name):
    """Whether a recording has a whole instant, as a reader of another kind sees it."""
    if not name.endswith(".gz"):
        return b"\n# whole " in data and data.rfind(b"\n") > data.rfind(b"\n# whole ")
    text = b""
    try:
        with gzip.open(io.BytesIO(data)) as stream:
            while piece := stream.read1(1 << 16):
                text += piece
    except (EOFError, OSError):
        pass
    return b"\n# whole " in text and text.rfind(b"\n") > text.rfind(b"\n# whole ")


class Trial:
    def __init__(self, arguments, folder):
        self.stroma, self.steps, self.seconds = arguments.stroma, arguments.steps, arguments.checkpoint_seconds
        self.folder = folder
        self.whole = {}
        self.kills = self.finished = self.read = 0

    def command(self):
        return [self.stroma, "run", "scene.xml", "-n", str(self.steps), "--record", "out", "--record-every", "3",
                "--checkpoint-seconds", str(self.seconds), "--resume", "--quiet"]

    def start(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.xml").write_text(SCENE)
        return subprocess.Popen(self.command(), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def run_whole(self):
        began = time.monotonic()
        process = self.start(self.folder / "whole")
        _, errors = process.communicate()
        if process.returncode != 0:
            sys.exit(f"the run that nobody kills failed: {errors}")
        self.whole = contents(self.folder / "whole")
        return time.monotonic() - began

    def complain(self, what):
        sys.exit(f"after kill {self.kills}: {what} (see {self.folder / 'killed'})")

    def check_killed(self, killed, before):
        """`before`: what files had when the last checkpoint was surely written, that is at the kill before."""
        now = contents(killed)
        for name in GROWING:
            data = now.get(name, b"")
            if not self.whole[name].startswith(data):
                self.complain(f"{name} is no beginning of the whole one")
        if "out/last.checkpoint" in before and "out/last.checkpoint" not in now:
            self.complain("the checkpoint is gone")
        for name, data in now.items():
            if name.startswith("pictures/") and name.endswith(".vtu") and data != self.whole[name]:
                self.complain(f"{name} is not whole")
        for name in RECORDINGS:
            if not has_instant(now.get(name, b""), name):
                continue
            (killed / "read.xml").write_text(READER.format(file=name))
            check = subprocess.run([self.stroma, "check", "read.xml"], cwd=killed, capture_output=True, text=True)
            if check.returncode != 0:
                self.complain(f"ReadState refuses {name}: {check.stderr}")
            self.read += 1
        return now

    def run(self, kills, whole_seconds):
        killed = self.folder / "killed"
        before = {}
        while self.kills < kills:
            began, is_fresh = time.monotonic(), not killed.exists()
            process = self.start(killed)
            try:
                process.wait(random.uniform(0, 0.7 * whole_seconds))
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
            _, errors = process.communicate()
            if process.returncode == 0:
                if is_fresh:  # the machine may have been slower when a whole run was measured
                    whole_seconds = min(whole_seconds, time.monotonic() - began)
                if contents(killed) != self.whole:
                    differing = [name for name, data in contents(killed).items() if self.whole.get(name) != data]
                    self.complain(f"the run that was resumed ended with other bytes: {differing}")
                self.finished += 1
                shutil.rmtree(killed)
                before = {}
                continue
            if process.returncode != -signal.SIGKILL:
                self.complain(f"exit code {process.returncode}: {errors}")
            self.kills += 1
            before = self.check_killed(killed, before)
        process = self.start(killed)
        _, errors = process.communicate()
        if process.returncode != 0 or contents(killed) != self.whole:
            self.complain(f"the last run ended otherwise: {errors}")
        self.finished += 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stroma", type=os.path.abspath, help="the command")
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--steps", type=int, default=400, help="of a whole run")
    parser.add_argument("--checkpoint-seconds", type=float, default=0.05)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random.seed(arguments.seed)
    folder = Path(tempfile.mkdtemp(prefix="kill_and_resume_"))
    trial = Trial(arguments, folder)
    seconds = trial.run_whole()
    trial.run(arguments.kills, seconds)
    print(f"{trial.kills} kills, {trial.finished} runs resumed to their end with the bytes of a whole one, "
          f"{trial.read} recordings of killed runs read; a whole run takes {seconds:.2f} s")
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
