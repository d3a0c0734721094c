# SPDX-License-Identifier: LGPL-2.1-or-later
"""Waiting for what another process does: for conditions, never for a time that is enough on a machine with nothing else to do."""
import os
import subprocess
import time

PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 60))  # seconds that anything may take where a machine has much else to do


def until(condition, what, seconds=PATIENCE):
    """Waits until condition() is true; its value."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.02)
    return value


def processor_seconds(process):
    """That a process, a number, has used; 0 when there is none."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii") as file:
            return sum(int(number) for number in file.read().rsplit(")", 1)[1].split()[11:13]) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return 0


def until_computed(process, wanted=0.5):
    """Waits until it has used `wanted` more seconds of a processor, however busy that is: it is in the middle of its work."""
    before = processor_seconds(process)
    until(lambda: processor_seconds(process) >= before + wanted, f"{wanted} s of work")


def children(process):
    """Numbers of the processes that it has started."""
    listed = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process)], capture_output=True, text=True, check=False).stdout
    return [int(number) for number in listed.split()]
