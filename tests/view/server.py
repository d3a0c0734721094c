# SPDX-License-Identifier: LGPL-2.1-or-later
"""Starts `stroma view`, speaks HTTP with it, and pages that need no browser."""
import ctypes
import json
import os
import re
import select
import shutil
import signal
import socket
import subprocess
import tempfile
import time

import numpy

from websocket import PATIENCE, TEXT, Closed, Packet, WebSocket, read_head

LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1


def end_with_the_test():
    """In a new process: it does not outlive a test that is killed."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


class Server:
    """`stroma view SCENE --no-open --port 0 ...` in a folder of its own. A context: at its end the server must end well."""

    def __init__(self, stroma, scene, *options, expected=0):
        self.folder = tempfile.mkdtemp(prefix="stroma_view_")
        self.errors = open(os.path.join(self.folder, "errors"), "w+", encoding="utf-8")
        self.expected, self.pages = expected, []
        self.process = subprocess.Popen([stroma, "view", scene, "--no-open", "--port", "0", *options], text=True,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.errors, cwd=self.folder,
                                        preexec_fn=end_with_the_test)
        ready, _, _ = select.select([self.process.stdout], [], [], PATIENCE)
        self.address = self.process.stdout.readline().strip() if ready else ""
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-zA-Z_-]{20,})", self.address)
        if not match:
            self.kill()
            raise AssertionError(f"stroma view printed {self.address!r}\n{self.error_text()}")
        self.port, self.token = int(match.group(1)), match.group(2)
        self.cookie = self.open_address()

    def open_address(self):
        """The cookie that the address with the token gives."""
        status, headers, _ = self.get(f"/?token={self.token}", cookie=None)
        assert status in (302, 303) and headers["location"] == "/", (status, headers)
        assert "httponly" in headers["set-cookie"].lower() and "samesite=strict" in headers["set-cookie"].lower(), headers
        return headers["set-cookie"].split(";")[0]

    def get(self, path, cookie="own", method="GET", host=None, headers=(), raw=None):
        """(status, headers, body) of a request; raises Closed when the server ends the connection without an answer."""
        cookie = self.cookie if cookie == "own" else cookie
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{self.port}'}", "Connection: close", *headers]
        if cookie:
            lines.append(f"Cookie: {cookie}")
        try:
            with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE) as connection:
                connection.sendall(raw if raw is not None else ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))
                if raw is not None:
                    connection.shutdown(socket.SHUT_WR)
                with connection.makefile("rb") as stream:
                    status, answer = read_head(stream)
                    return status, answer, stream.read(int(answer.get("content-length", 0)))
        except OSError as error:
            raise Closed(str(error)) from error

    def socket(self, **headers):
        """The upgraded connection of a page; headers replace those that a page sends, and None leaves one out."""
        given = {"Origin": f"http://127.0.0.1:{self.port}", "Cookie": self.cookie}
        given.update({name.replace("_", "-"): value for name, value in headers.items()})
        return WebSocket(self.port, headers=given)

    def page(self, **options):
        page = Page(self, **options)
        self.pages.append(page)
        return page

    def error_text(self):
        self.errors.seek(0)
        return self.errors.read()

    def memory(self):
        """Resident, in bytes."""
        with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def spent(self):
        """Seconds of processor time so far."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self):
        """Ctrl-C; checks the exit code. What it printed last; a second call does nothing."""
        if self.errors.closed:
            return ""
        for page in self.pages:
            page.socket.cut()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired as late:
            self.kill()
            raise AssertionError(f"the server did not end within {PATIENCE} s of Ctrl-C") from late
        text = self.process.stdout.read()
        self.process.stdout.close()
        assert self.process.returncode == self.expected, (self.process.returncode, text, self.error_text())
        self.errors.close()
        shutil.rmtree(self.folder, ignore_errors=True)
        return text

    def kill(self):
        self.process.kill()
        self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if kind is None:
            self.end()
        else:
            code = self.process.poll()
            self.kill()
            print(f"the server: {'ran' if code is None else f'had ended with {code}'}; it said:\n{self.error_text()}")


class Page:
    """What a page knows of the run. Frames are acknowledged as they come, unless `draws` is off."""

    def __init__(self, server, draws=True, hello=True):
        self.server, self.draws = server, draws
        self.socket = server.socket()
        self.scene = self.held = self.cells = self.frame = self.status = None
        self.frames, self.ready, self.request = 0, False, 0
        self.replies, self.messages, self.last = {}, [], {}
        if hello:
            self.hello()

    def hello(self, build=None):
        """The first message. A page that comes back says which build it is of; one that is new cannot know."""
        self.socket.send({"do": "hello", **({"build": build} if build else {})})
        self.until(lambda: self.ready or "reload" in self.last, "everything that belongs to the start")
        assert "reload" not in self.last, "the page was told to load itself again"
        self.until(lambda: self.frame is not None, "the first picture")

    # ---- what comes ----

    def take(self, seconds):
        """One message, if one comes in time. True if so."""
        got = self.socket.receive(seconds)
        if got is None:
            return False
        kind, data = got
        if kind == TEXT:
            self.take_text(json.loads(data))
        else:
            self.take_packet(Packet(data))
        return True

    def take_text(self, message):
        kind = message["is"]
        if kind == "ready":
            self.ready = True
        elif kind == "status":
            before = (self.status or {}).get("recording", {})
            self.status = {**(self.status or {}), **message}
            if "recording" in message:  # its times come once
                self.status["recording"] = {**before, **message["recording"]}
        elif kind == "messages":
            self.messages += message["lines"]
        elif kind == "reply":
            assert message["request"] not in self.replies, f"two replies: {message}"
            self.replies[message["request"]] = message
        else:
            self.last[kind] = message

    def take_packet(self, packet):
        kind = packet["is"]
        assert kind in ("scene", "held", "cells", "frame"), kind
        setattr(self, kind, packet)
        if kind == "frame":
            self.frames += 1
            if self.draws:
                self.drawn()

    def drawn(self):
        self.socket.send({"do": "drawn", "frame": self.frame["frame"]})

    def until(self, reached, what, seconds=PATIENCE):
        """Takes messages until reached() is true."""
        end = time.monotonic() + seconds
        while not reached():
            left = end - time.monotonic()
            assert left > 0, f"waited {seconds} s for {what}; the run is {self.status}"
            self.take(min(left, 0.2))

    def pictures(self, count):
        """Waits for so many more: the run goes on meanwhile."""
        before = self.frames
        self.until(lambda: self.frames >= before + count, f"{count} pictures")

    # ---- what is asked ----

    def ask(self, verb, **values):
        """The reply."""
        self.request += 1
        number = self.request
        self.socket.send({"do": verb, "request": number, **values})
        self.until(lambda: number in self.replies, f"the reply to {verb}")
        return self.replies[number]

    def do(self, verb, **values):
        """What must be accepted."""
        reply = self.ask(verb, **values)
        assert reply["ok"], (verb, values, reply)

    def refused(self, verb, **values):
        """What must be refused; the sentence."""
        reply = self.ask(verb, **values)
        assert not reply["ok"] and reply["message"], (verb, values, reply)
        return reply["message"]

    def tell(self, verb):
        """The answer to a question (components, explain, xml, actions, hash)."""
        self.last.pop(verb, None)
        self.do(verb)
        self.until(lambda: verb in self.last, f"the answer to {verb}")
        return self.last[verb]

    def hash(self):
        """(step, hash of the state)"""
        answer = self.tell("hash")
        return answer["step"], answer["hash"]

    def pause(self):
        self.do("pause")
        self.until(lambda: not self.status["running"], "the run to pause")

    def picture(self, step=None):
        """The next frame, or the first one of a step."""
        before = self.frames
        if step is None or self.frame is None or self.frame["step"] != step:
            self.until(lambda: self.frames > before and (step is None or self.frame["step"] == step), f"a picture of step {step}")
        return self.frame

    def positions(self, body=0):
        """x of the last frame, one row per node."""
        x = self.frame.arrays[f"{body}.x"]
        if self.frame["format"] == "u16":
            low, high = numpy.split(numpy.array(self.frame["boxes"][body]), 2)
            return low + x.reshape(-1, 3) / 65535.0 * (high - low)
        return x.reshape(-1, 3).astype(float)
