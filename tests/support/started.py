# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs of a program, each a process of its own, that begin as forks of one that waits before main (start_server.cpp)."""
import atexit
import os
import signal
import socket
import subprocess
import tempfile
import threading

LIBRARY = os.environ.get("STROMA_TEST_START_SERVER")  # without it each run is started anew
OPENED = "libcholmod.so.3"  # what the command's modules bring that takes longest to link, with OpenBLAS


def number(answer):
    assert len(answer) == 4, "the program that waits has died"
    return int.from_bytes(answer, "little")


class Started:
    def __init__(self, program):
        self.program, self.of_thread = os.path.abspath(program), threading.local()
        self.forks = bool(LIBRARY)

    def waiting(self, socket_number):
        """Starts the process that answers on the socket of this number."""
        # as the command begins: OpenBLAS reads it when it is opened
        environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ, "LD_PRELOAD": LIBRARY, "STROMA_TEST_OPENED": OPENED,
                       "STROMA_TEST_SOCKET": str(socket_number)}
        return subprocess.Popen([self.program], pass_fds=[socket_number], env=environment, stdin=subprocess.DEVNULL)

    def server(self):
        """The socket of this thread's server."""
        if not hasattr(self.of_thread, "socket"):
            ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            server = self.waiting(theirs.fileno())
            theirs.close()
            self.of_thread.socket = ours
            atexit.register(lambda: (ours.close(), server.wait()))
        return self.of_thread.socket

    def run(self, words, cwd, timeout=600, env=None):
        """As subprocess.run([program, *words]) with no input and its texts captured."""
        command = [self.program, *words]
        if not self.forks:
            return subprocess.run(command, cwd=cwd, timeout=timeout, env=env, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        asked = self.server()
        environment = [f"{name}={value}" for name, value in (os.environ if env is None else env).items()]
        packet = b"".join(os.fsencode(word) + b"\0" for word in (str(len(command)), cwd, *command, *environment))
        with open(os.devnull, "rb") as nothing, tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as errors:
            socket.send_fds(asked, [packet], [nothing.fileno(), out.fileno(), errors.fileno()])
            child = number(asked.recv(4))
            assert child, f"{self.program} does not start with {LIBRARY}"
            asked.settimeout(timeout)
            try:
                answer = asked.recv(4)
            except TimeoutError:
                os.kill(child, signal.SIGKILL)
                asked.settimeout(None)
                asked.recv(4)
                raise subprocess.TimeoutExpired(command, timeout) from None
            asked.settimeout(None)
            out.seek(0)
            errors.seek(0)
            texts = out.read(), errors.read()
        return subprocess.CompletedProcess(command, os.waitstatus_to_exitcode(number(answer)), *texts)
