#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""`stroma sweep --engine slurm` on a Slurm of its own: munged, slurmctld and slurmd of this test, with one node, which is this
machine. A share is killed in the middle, and later the sweep itself is stopped: nothing is run twice, nothing is lost, and the
table is that of one machine. It waits for conditions, never for times. Without these programs, or where they do not start, it is
skipped.

Usage: slurm.py STROMA
       slurm.py STROMA COMMAND...    runs a command with SLURM_CONF of such a cluster, in a folder of its own, to try things
Packages: slurm-wlm munge. Exit codes: 0 good, 1 not, 77 skipped."""
import glob
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from processes import until  # noqa: E402

NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "scancel", "squeue", "sinfo")
SCENE = """<Node name="root" gravity="0 0 0" dt="0.01">
  <EulerImplicitSolver rayleighMass="0" rayleighStiffness="0"/><CGLinearSolver iterations="100" tolerance="1e-14"/>
  <MechanicalObject name="dofs" position="0 0 0" velocity="1 0 0"/><UniformMass totalMass="1"/>
  <RestShapeSpringsForceField name="spring" stiffness="100"/>
</Node>
"""
CONFIGURATIONS = 8


class Skipped(Exception):
    pass


def path_of(program):
    return shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    """Daemons in the foreground, so that they are this test's own processes and end with it."""

    def __init__(self, folder):
        self.folder, self.daemons = folder, []

    def start(self, name, *options):
        log = open(os.path.join(self.folder, name + ".out"), "w", encoding="utf-8")
        self.daemons.append(subprocess.Popen([path_of(name), *options], stdout=log, stderr=log,
                                             env=self.environment("slurm.conf")))

    def environment(self, configuration="client.conf"):
        return {**os.environ, "SLURM_CONF": os.path.join(self.folder, configuration)}

    def ask(self, *words):
        return subprocess.run(words, env=self.environment(), capture_output=True, text=True, check=False).stdout

    def last_words(self):
        said = ""
        for log in sorted(glob.glob(os.path.join(self.folder, "*.out")) + glob.glob(os.path.join(self.folder, "*.log"))):
            with open(log, encoding="utf-8", errors="replace") as file:
                said += "".join(f"{os.path.basename(log)}: {line}" for line in file.readlines()[-2:])
        return said

    def __enter__(self):
        try:
            return self.begin()
        except BaseException:
            self.__exit__()
            raise

    def begin(self):
        folder, host, ports = self.folder, socket.gethostname().split(".")[0], free_ports(2)
        os.mkdir(os.path.join(folder, "state")), os.mkdir(os.path.join(folder, "spool"))
        with open(os.path.join(folder, "munge.key"), "wb") as file:
            file.write(os.urandom(1024))
        os.chmod(os.path.join(folder, "munge.key"), 0o400)
        configuration = f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
KillWait=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={min(2, os.cpu_count())} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
        # sbatch --wait asks after 2 s, 8 s, 32 s, but never less often than half the time for which the controller remembers a job;
        # the controller itself remembers it long enough for a client that has to wait for its turn
        for name, more in (("slurm.conf", ""), ("client.conf", "MinJobAge=4\n")):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(configuration + more)
        self.start("munged", "--foreground", "--force", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                   f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munge.seed")
        self.until_up(lambda: os.path.exists(os.path.join(folder, "munge.socket")))
        self.start("slurmctld", "-D")
        self.start("slurmd", "-D")
        self.until_up(lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T"))
        return self

    def until_up(self, condition):
        """What cannot run here says so and ends."""
        until(lambda: condition() or any(daemon.poll() is not None for daemon in self.daemons), "the daemons of Slurm")
        if any(daemon.poll() is not None for daemon in self.daemons):
            raise Skipped("Slurm's daemons do not run here:\n" + self.last_words())

    def __exit__(self, *_):
        if len(self.daemons) > 1:
            self.ask("scancel", "-u", "root")
        for daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.terminate()
            try:
                daemon.wait(60)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


def sweep_words(stroma, folder, times, *more):
    return [stroma, "sweep", os.path.join(folder, "oscillator.xml"), "--vary", "dt=4e-6,2.5e-6,2e-6,1e-6", "--vary",
            "/spring.stiffness=90,100", "--no-times", "--until", str(0.25 * times), *more]


def outcomes(folder):
    return {path: os.stat(path).st_mtime_ns for path in glob.glob(os.path.join(folder, "runs", "*", "*.outcome.json"))}


def results(folder):
    with open(os.path.join(folder, "table.json"), encoding="utf-8") as file:
        table = json.load(file)
    rows = {row["key"]: {name: row[name] for name in ("settings", "outcome", "error")} for row in table["configurations"]}
    return {"rows": rows, "build": table["build"], "seed": table["seed"], "scene": table["scene_digest"]}


def shares_at_work(folder):
    """Numbers of the processes of shares in this folder."""
    found = []
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            with open(path, "rb") as file:
                words = file.read().split(b"\0")
        except OSError:
            continue  # it has ended
        if b"--shard" in words and os.fsencode(folder) in words and words[1:2] == [b"sweep"]:
            found.append(int(path.split("/")[2]))
    return found


def in_the_middle(cluster, stroma, folder, disturb):
    """Starts a sweep, and calls disturb(process, folder of the sweep) when a run is whole; with longer runs, where all were done
    by then, or nothing was disturbed. What was whole, and what the sweep said."""
    for times in (1, 8, 64, 512):
        out = os.path.join(folder, f"out{times}")
        shutil.rmtree(out, ignore_errors=True)
        process = subprocess.Popen(sweep_words(stroma, folder, times, "-o", out, "--engine", "slurm", "--shares", "2"),
                                   env=cluster.environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        until(lambda: outcomes(out) or process.poll() is not None, "a run that is whole")  # pylint: disable=cell-var-from-loop
        was_disturbed = disturb(process, out)
        whole = outcomes(out)
        said = process.communicate()[0]
        # a signal may come when the last run has just ended
        if was_disturbed and 0 < len(whole) < CONFIGURATIONS and not (disturb is interrupt and process.returncode == 0):
            return times, out, whole, process.returncode, said
    raise AssertionError(f"all runs were done before anything could happen to them: {said}")


def check(failures, truth, text):
    if not truth:
        failures.append(text)


def check_whole(failures, stroma, folder, times, out, whole):
    after = outcomes(out)
    check(failures, len(after) == CONFIGURATIONS, f"{len(after)} runs are whole in {out}")
    check(failures, all(after.get(path) == time for path, time in whole.items()), f"a run was made twice in {out}")
    alone = os.path.join(folder, "alone")
    shutil.rmtree(alone, ignore_errors=True)
    subprocess.run(sweep_words(stroma, folder, times, "-q", "-o", alone), check=True, capture_output=True)
    check(failures, results(out) == results(alone), f"the table of {out} is not that of one machine")


def kill_shares(process, out):
    del process
    killed = 0
    for number in shares_at_work(out):
        try:
            os.kill(number, signal.SIGKILL)
            killed += 1
        except ProcessLookupError:
            pass
    return killed > 0


def interrupt(process, out):
    del out
    process.send_signal(signal.SIGINT)
    return True


def test(cluster, stroma, folder):
    failures = []
    with open(os.path.join(folder, "oscillator.xml"), "w", encoding="utf-8") as file:
        file.write(SCENE)
    times, out, whole, code, said = in_the_middle(cluster, stroma, folder, kill_shares)
    check(failures, code == 0 and said.count("shares by slurm") >= 2, f"killed shares are started again: {code} {said}")
    check_whole(failures, stroma, folder, times, out, whole)

    times, out, _, code, said = in_the_middle(cluster, stroma, folder, interrupt)
    check(failures, code == 130 and "the same command goes on" in said, f"Ctrl-C: {code} {said}")
    until(lambda: not cluster.ask("squeue", "-h"), "a queue without jobs")
    until(lambda: not shares_at_work(out), "the end of the shares")
    whole = outcomes(out)
    again = subprocess.run(sweep_words(stroma, folder, times, "-o", out, "--engine", "slurm", "--shares", "2"),
                           env=cluster.environment(), capture_output=True, text=True, check=False)
    check(failures, again.returncode == 0, f"it does not go on: {again.stderr}")
    check_whole(failures, stroma, folder, times, out, whole)
    return failures


def main():
    missing = [program for program in NEEDED if not path_of(program)]
    try:
        if missing:
            raise Skipped(f"{', '.join(missing)} not installed: packages slurm-wlm and munge")
        if os.geteuid() != 0:
            raise Skipped("Slurm's daemons take another user's jobs as root alone")
        with tempfile.TemporaryDirectory() as folder, Cluster(folder) as cluster:
            work = os.path.join(folder, "work")
            os.mkdir(work)
            if sys.argv[2:]:
                return subprocess.run(sys.argv[2:], env=cluster.environment(), cwd=work, check=False).returncode
            failures = test(cluster, os.path.abspath(sys.argv[1]), work)
    except Skipped as skipped:
        print("skipped:", skipped)
        return 77
    for failure in failures:
        print(failure)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
