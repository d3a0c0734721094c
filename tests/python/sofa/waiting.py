# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs `python3 -m Sofa.command WORDS` many times at the price of a fork: this process has imported what each of them imports, and
nothing else. A child of its own answers each request, in the folder and with the environment and files of the request. Requests and
answers are those of tests/support/start_server.cpp. Usage: waiting.py NUMBER_OF_A_SOCKET"""
import os
import runpy
import socket
import sys
import traceback

import Sofa.Core  # with numpy, which takes longest  # pylint: disable=unused-import
import Sofa.Simulation  # pylint: disable=unused-import
from stroma import _command  # pylint: disable=unused-import


def become(files, folder, arguments, environment):
    """In the child: as python3 begins."""
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(entry.split("=", 1) for entry in environment)
    sys.path[0] = folder
    sys.argv = ["-m", *arguments]
    runpy.run_module("Sofa.command", run_name="__main__", alter_sys=True)  # ends the process


def main():
    asked = socket.socket(fileno=int(sys.argv[1]))
    while True:
        packet, files, _, _ = socket.recv_fds(asked, 1 << 18, 3)
        if not packet:
            return
        count, folder, *words = (os.fsdecode(word) for word in packet.split(b"\0")[:-1])
        child = os.fork()
        if child == 0:
            asked.close()
            try:
                become(files, folder, words[1:int(count)], words[int(count):])
            except BaseException:  # the command ends the process itself  # pylint: disable=broad-exception-caught
                traceback.print_exc()
            os._exit(70)
        for file in files:
            os.close(file)
        asked.send(child.to_bytes(4, "little"))
        asked.send(os.waitpid(child, 0)[1].to_bytes(4, "little"))


main()
