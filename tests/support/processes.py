# SPDX-License-Identifier: LGPL-2.1-or-later
"""Waiting for what another process does: for conditions, never for a time that is enough on a machine with nothing else to do."""
import os
import signal
import subprocess
import time

PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 600))  # seconds: only what hangs takes so long, whatever else a machine does


def until(condition, what, seconds=PATIENCE):
    """Waits until condition() is true; its value."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, f"waited {seconds} s for {what}"
        time.sleep(0.02)
    return value


def held_still(process):
    """Stops all threads of a subprocess.Popen; they stand still when this returns, until somebody sends SIGCONT."""
    def stands():
        if process.poll() is not None:
            return True
        try:
            for thread in os.listdir(f"/proc/{process.pid}/task"):
                with open(f"/proc/{process.pid}/task/{thread}/stat", encoding="ascii", errors="replace") as file:
                    if file.read().rsplit(")", 1)[1].split()[0] not in "TZX":
                        return False
        except OSError:  # the thread or the process ends
            return False
        return True
    process.send_signal(signal.SIGSTOP)
    until(stands, "a process that stands still")


def children(process):
    """Numbers of the processes that it has started."""
    listed = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process)], capture_output=True, text=True, check=False).stdout
    return [int(number) for number in listed.split()]
