#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs a command that ends only when somebody ends it: waits for a sign that it does its work, then presses Ctrl-C.
Usage: interrupted.py SIGN COMMAND... Ends with 0 when the sign came and the command ended well, else with its code, or 1."""
import signal
import subprocess
import sys
import threading

PATIENCE = 900  # seconds, after which it hangs


def main():
    sign, command = sys.argv[1], sys.argv[2:]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    timer = threading.Timer(PATIENCE, process.kill)
    timer.start()
    seen = False
    for line in process.stdout:
        print(line, end="", flush=True)
        if sign in line and not seen:
            seen = True
            process.send_signal(signal.SIGINT)
    code = process.wait()
    timer.cancel()
    sys.exit(0 if seen and code in (0, 130) else code if code > 0 else 1)


if __name__ == "__main__":
    main()
