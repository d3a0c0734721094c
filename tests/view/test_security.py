#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Nobody but the page that holds the token sees or steers the run of `stroma view`, and no message harms it.
Usage: test_security.py TREE STROMA [--messages N] [--seed S] [names of tests]"""
import json
import os
import random
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from server import Server, end_with_the_test
from websocket import BINARY, CLOSE, PATIENCE, PING, TEXT, Closed, frame_bytes, read_head

TREE, STROMA = (os.path.abspath(path) for path in sys.argv[1:3])
SCENE = os.path.join(TREE, "scenes", "examples", "organ.xml")
MESSAGES, SEED = 20000, 1

# Every verb with values that are right in this scene, and verbs that are none.
GOOD = [
    {"do": "hello"}, {"do": "want", "nodes": "surface", "fields": [1], "loads": True, "contacts": True, "format": "f32", "fps": 60},
    {"do": "watch", "values": ["energy", "solver", "node.0.1.position"]}, {"do": "drawn", "frame": 1}, {"do": "control"},
    {"do": "run"}, {"do": "pause"}, {"do": "step", "count": 1}, {"do": "reset"}, {"do": "pace", "pace": "fast", "factor": 1},
    {"do": "pull", "hand": "h", "body": 0, "nodes": [1, 2], "targets": [[0, 0, 0], [0, 0, 0]], "stiffness": 1, "kind": "pull", "sequence": 1},
    {"do": "force", "hand": "f", "body": 0, "nodes": [3], "force": [0, 0, 0], "sequence": 2},
    {"do": "push", "hand": "p", "body": 0, "centre": [0, 0, 0], "radius": 0.01, "stiffness": 1, "sequence": 3},
    {"do": "move", "hand": "o", "obstacle": 0, "offset": [0, 0, 0], "sequence": 4}, {"do": "release", "hand": "h"}, {"do": "key", "key": "a", "pressed": True}, {"do": "set", "path": "/organ/fem", "attribute": "youngModulus", "value": "10000"},
    {"do": "seek", "index": 0}, {"do": "components"}, {"do": "explain"}, {"do": "xml"}, {"do": "actions"}, {"do": "hash"},
    {"do": "attach"}, {"do": "leave"}, {"do": "show"}, {"do": "doubts"}, {"do": "nothing"}]
WRONG = [None, True, False, 0, -1, 1, 0.5, 1e300, -1e300, 2**31, 2**53 + 1, 2**63, 2**64, -2**63, 10**40, "", "x", "\u0000", "é" * 50,
         "a" * 60000, [], [[]], [None], ["x"], [1, 2, 3], [[1, 2, 3]] * 3, list(range(9000)), {}, {"do": "run"}, [{"a": []}] * 20]


ABSENT = object()


def deep(levels, inner="1"):
    """[[[...]]]"""
    return "[" * levels + inner + "]" * levels


class Doors(unittest.TestCase):
    """HTTP: who gets in, and to what."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server(STROMA, SCENE, "--paused")

    @classmethod
    def tearDownClass(cls):
        cls.server.end()

    def refused(self, *arguments, status=(400, 403, 404, 405, 413, 414, 431), **options):
        """Neither the page nor a file, and no cookie."""
        try:
            got, headers, body = self.server.get(*arguments, **options)
        except Closed:
            return
        self.assertIn(got, status, (arguments, options, body[:200]))
        self.assertNotIn("set-cookie", headers)
        self.assertNotIn(self.server.token.encode(), body)
        self.assertNotIn(b"root:", body)
        self.assertNotIn(b"<script", body)
        self.assertLess(len(body), 500)

    def test_the_page_is_served_to_who_has_the_token(self):
        for path, kind, part in (("/", "text/html", b"app.js"), ("/app.js", "javascript", b""), ("/app.css", "text/css", b""),
                                 ("/licences.txt", "text/plain", b"three")):
            status, headers, body = self.server.get(path)
            self.assertEqual(status, 200, path)
            self.assertIn(kind, headers["content-type"])
            self.assertIn(part, body)
            policy = headers["content-security-policy"]
            self.assertIn("default-src 'none'", policy)
            self.assertNotIn("unsafe", policy)
            self.assertNotIn("*", policy)
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertNotIn("access-control-allow-origin", headers)

    def test_without_the_token_nothing_is_served(self):
        token = self.server.token
        for path in ("/", "/app.js", "/app.css", "/licences.txt", "/live", "/?token=", f"/?token={token[:-1]}", f"/?token={token}0",
                     f"/?token={token.swapcase() if token.swapcase() != token else 'x' * len(token)}", f"/?Token={token}", f"/app.js?token={token[:-1]}x",
                     f"/?token={'0' * len(token)}", f"/?token=%00{token}"):
            self.refused(path, cookie=None, status=(400, 403, 404))
        for cookie in ("", "stroma=1", self.server.cookie[:-1], self.server.cookie + "0", self.server.cookie.replace("=", "=0", 1),
                       f"x{self.server.cookie}", f"stroma_{self.server.port}=", token, ";" * 3000, "=" * 3000):
            self.refused("/", cookie=cookie, status=(400, 403, 404))

    def test_a_cookie_among_others_counts(self):
        self.assertEqual(self.server.get("/", cookie=f"a=b; {self.server.cookie}; c=d")[0], 200)

    def test_names_of_other_machines_are_refused(self):
        port = self.server.port
        for host in (f"127.0.0.1.evil.example:{port}", f"localhost.evil:{port}", "localhost.evil", "evil.example", f"evil.example:{port}",
                     "127.0.0.1", f"127.0.0.1:{port + 1}", f"127.0.0.1:{port}0", f"127.0.0.1:{port}@evil.example", f"evil@127.0.0.1:{port}",
                     f"[::1]:{port}", f"0.0.0.0:{port}", f"127.1:{port}", f"2130706433:{port}", "a" * 300):
            self.refused("/", host=host, status=(400, 403))
            self.refused(f"/?token={self.server.token}", host=host, cookie=None, status=(400, 403))
        self.refused("/", headers=(f"Host: evil.example:{port}",))  # a second one
        self.assertEqual(self.server.get("/", host=f"localhost:{port}")[0], 200)

    def test_a_request_without_a_host_is_refused(self):
        for version in ("1.0", "1.1"):
            self.refused("/", raw=f"GET / HTTP/{version}\r\nCookie: {self.server.cookie}\r\n\r\n".encode())

    def test_pages_of_other_origins_are_refused(self):
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{self.server.port + 1}", f"https://127.0.0.1:{self.server.port}",
                       f"http://127.0.0.1:{self.server.port}.evil.example", "file://"):
            self.refused("/", headers=(f"Origin: {origin}",), status=(403,))

    def test_no_other_file_is_served(self):
        for path in ("/../etc/passwd", "/%2e%2e/etc/passwd", "//etc/passwd", "/etc/passwd", "/..%2f..%2fetc/passwd", "/./app.js", "/app.js/",
                     "/app.js%00", "/app.js?x", "/index.html", "/package.json", "/node_modules/three/package.json", "/src/main.js", "/.git/config",
                     "/app.js/../../etc/passwd", "/\\..\\etc", "/%", "/%zz", "*", "http://127.0.0.1/etc/passwd", "/" + "a" * 5000,
                     "/" + "../" * 1000 + "etc/passwd", f"/{SCENE}", "/live", "/live/", "/LIVE"):
            self.refused(path)

    def test_other_methods_are_refused(self):
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "CONNECT", "PROPFIND", "get", "X" * 100):
            self.refused("/", method=method)
        status, headers, _ = self.server.get("/", method="HEAD")
        self.assertIn(status, (200, 400, 405), headers)

    def test_requests_that_are_none(self):
        head = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\nCookie: {self.server.cookie}\r\n".encode()
        noise = random.Random(SEED)
        for raw in (b"\r\n\r\n", b"\0" * 100, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", head + b"X: " + b"a" * 20000 + b"\r\n\r\n",
                    head + b"".join(b"X%d: 1\r\n" % i for i in range(3000)) + b"\r\n", head + b"Content-Length: 99999999999999\r\n\r\n",
                    head + b"Content-Length: -1\r\n\r\n", head + b"Content-Length: 5\r\n\r\nhello",
                    head + b"Transfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n", head + b" folded: 1\r\n\r\n", b"\x16\x03\x01\x02\x00\x01" * 20,
                    *(bytes(noise.randrange(256) for _ in range(noise.randrange(1, 400))) for _ in range(50))):
            self.refused("/", raw=raw)
        self.assertEqual(self.server.get("/")[0], 200)

    def test_connections_that_say_nothing_do_not_stop_others(self):
        silent = [socket.create_connection(("127.0.0.1", self.server.port)) for _ in range(50)]
        for one in silent[::2]:
            one.sendall(b"GET / HT")
        self.assertEqual(self.server.get("/")[0], 200)
        for one in silent:
            one.close()

    # ---- the upgrade ----

    def upgrade_refused(self, path="/live", **headers):
        try:
            given = {"Origin": f"http://127.0.0.1:{self.server.port}", "Cookie": self.server.cookie}
            from websocket import WebSocket  # pylint: disable=import-outside-toplevel
            WebSocket(self.server.port, path, {**given, **{name.replace("_", "-"): value for name, value in headers.items()}}).cut()
        except Closed as closed:
            # a page that has the token may also be answered as if it had asked for a page
            self.assertIn(closed.status, (0, 400, 403, 404, 405, 426, *((200, 303) if path != "/live" else ())), headers)
            return
        self.fail(f"the upgrade was granted: {path} {headers}")

    def test_the_upgrade_is_granted_to_the_page_alone(self):
        port = self.server.port
        self.server.socket().close()
        self.upgrade_refused(Cookie=None)
        self.upgrade_refused(Cookie=self.server.cookie[:-1] + "x")
        self.upgrade_refused(Cookie="")
        self.upgrade_refused(Origin=None)
        for origin in ("", "null", "http://evil.example", f"http://evil.example:{port}", f"https://127.0.0.1:{port}", f"http://127.0.0.1:{port}/",
                       f"http://127.0.0.1:{port}.evil.example", f"http://127.0.0.1:{port + 1}", "http://127.0.0.1", "file://"):
            self.upgrade_refused(Origin=origin)
        for host in (f"127.0.0.1.evil.example:{port}", "localhost.evil", "evil.example"):
            self.upgrade_refused(Host=host)
            self.upgrade_refused(Host=host, Origin=f"http://{host}")
        for path in ("/", "/live/", "/live?x", "/other", f"/live?token={self.server.token}", "/app.js"):
            self.upgrade_refused(path)
        self.upgrade_refused(Cookie=None, Authorization=f"Bearer {self.server.token}")
        self.upgrade_refused(Sec_WebSocket_Version="12")
        self.upgrade_refused(Sec_WebSocket_Key=None)

    def test_not_only_this_machine_is_warned_of(self):
        with Server(STROMA, SCENE, "--paused", "--host", "0.0.0.0") as server:
            self.assertIn("warning", server.error_text())
        self.assertNotIn("warning: other machines", self.server.error_text())


class Addresses(unittest.TestCase):
    """--host: the page is reached by the addresses of the machine, and by no other name."""

    def start(self, host, expected):
        """Port and token; the server ends with the test."""
        folder = tempfile.mkdtemp(prefix="stroma_view_")
        self.addCleanup(shutil.rmtree, folder)
        process = subprocess.Popen([STROMA, "view", SCENE, "--no-open", "--paused", "--host", host], stdout=subprocess.PIPE,
                                   stderr=subprocess.DEVNULL, text=True, cwd=folder, preexec_fn=end_with_the_test)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        address = process.stdout.readline().strip()
        match = re.fullmatch(re.escape(f"http://{expected}:") + r"(\d+)/\?token=([0-9a-f]{32})", address)
        self.assertTrue(match, address)
        return int(match.group(1)), match.group(2)

    @staticmethod
    def ask(address, port, path, host, *headers):
        """(status, headers) of a request to an address by a name."""
        with socket.create_connection((address, port), timeout=PATIENCE) as connection:
            connection.sendall("\r\n".join([f"GET {path} HTTP/1.1", f"Host: {host}", *headers, "", ""]).encode())
            with connection.makefile("rb") as stream:
                return read_head(stream)

    def reached(self, address, port, token, host):
        """The token gives the cookie, the cookie the page and the websocket, to this name alone."""
        status, headers = self.ask(address, port, f"/?token={token}", host)
        self.assertEqual(status, 303, (address, host))
        cookie = "Cookie: " + headers["set-cookie"].split(";")[0]
        self.assertEqual(self.ask(address, port, "/", host, cookie, "Connection: close")[0], 200)
        upgrade = ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + "A" * 22 + "==", cookie)
        self.assertEqual(self.ask(address, port, "/live", host, f"Origin: http://{host}", *upgrade)[0], 101)
        for wrong in (f"127.0.0.3:{port}", f"192.0.2.77:{port}", f"[::2]:{port}", f"0.0.0.0:{port}", f"[::]:{port}", f"evil.example:{port}",
                      f"{host}.evil.example", f"{host}0", host.rpartition(":")[0], f"x{host}", "", f"[{host}]"):
            self.assertIn(self.ask(address, port, f"/?token={token}", wrong)[0], (400, 403), wrong)
            self.assertEqual(self.ask(address, port, "/live", host, f"Origin: http://{wrong}", *upgrade)[0], 403, wrong)

    def test_a_second_address_of_the_machine(self):
        port, token = self.start("0.0.0.0", "127.0.0.1")
        for address in ("127.0.0.1", "127.0.0.2"):
            self.reached(address, port, token, f"{address}:{port}")
        self.assertEqual(self.ask("127.0.0.1", port, f"/?token={token}", f"127.0.0.2:{port}")[0], 403)  # this connection came to another
        port, token = self.start("127.0.0.2", "127.0.0.2")
        self.reached("127.0.0.2", port, token, f"127.0.0.2:{port}")

    def test_addresses_of_the_sixth_version(self):
        try:
            with socket.socket(socket.AF_INET6) as one:
                one.bind(("::1", 0))
        except OSError as error:
            self.skipTest(f"this machine has no ::1: {error}")
        for given in ("::1", "[::1]", "0:0:0:0:0:0:0:1"):
            port, token = self.start(given, "[0:0:0:0:0:0:0:1]" if given.startswith("0") else "[::1]")
            self.reached("::1", port, token, f"[::1]:{port}")
        port, token = self.start("::", "[::1]")
        self.reached("::1", port, token, f"[::1]:{port}")
        self.reached("127.0.0.2", port, token, f"127.0.0.2:{port}")


class Messages(unittest.TestCase):
    """What a page that holds the token may send without harm."""

    def setUp(self):
        self.server = Server(STROMA, SCENE, "--paused")
        self.addCleanup(self.server.kill)  # also after a failure
        self.page = self.server.page()
        self.page.do("step", count=2)
        self.state = self.page.hash()

    def tearDown(self):
        """The server answers as ever, and nothing has happened to the run."""
        page = self.server.page()
        self.assertEqual(page.hash(), self.state)
        self.server.end()

    def other(self):
        """A connection that nobody reads."""
        page = self.server.page()
        return page.socket

    def ends(self, websocket, what):
        """The server ends this connection."""
        end = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < end:
                websocket.receive(1)
        except (Closed, UnicodeDecodeError):
            return
        self.fail(f"the connection lives on after {what}")

    def test_values_of_wrong_types_are_refused(self):
        """Every field of every command with every wrong value, and without it: an answer each time, and no effect on the state."""
        page, sent = self.page, 0
        for good in GOOD:
            for field in good:
                for wrong in [ABSENT, *WRONG]:
                    message = {**good, field: wrong, "request": 10**6 + sent}
                    if wrong is ABSENT:
                        del message[field]
                    if self.would_act(message):
                        continue
                    page.socket.send(message)
                    sent += 1
                    page.until(lambda number=message["request"]: number in page.replies, f"a reply to {json.dumps(message)[:200]}")
                    reply = page.replies.pop(message["request"])
                    self.assertTrue(reply["ok"] or reply["message"], message)
        self.assertGreater(sent, 1500)
        for name in ("h", "f", "p"):
            page.do("release", hand=name)

    @staticmethod
    def would_act(message):
        """What is right after all, and changes the state."""
        verb = message.get("do")
        if verb == "step":
            return "count" not in message or message["count"] in (1, 9000) and message["count"] is not True
        return verb in ("run", "reset")

    def test_wrong_types_of_the_number_of_a_request_are_harmless(self):
        said = []
        for wrong in [*WRONG, "the last"]:
            self.page.socket.send({"do": "hash", "request": wrong})
            self.page.socket.send({"do": "nothing", "request": wrong})
        self.page.take_text = said.append
        self.page.until(lambda: {"is": "reply", "request": "the last", "ok": True, "message": ""} in said, "the last reply")

    def test_texts_that_are_no_messages(self):
        for text in ("", " ", "null", "1", "true", "[]", '"do"', "{", "}", '{"do":', '{"do":"run"', "{'do':'run'}", '{"do":"nothing"} x', "NaN",
                     '{"do":"step","count":NaN}', '{"do":"step","count":Infinity}', '{"do":"step","count":1e999}', '{"do":"step","count":-0.0}',
                     '{"do":"step","count":' + "9" * 5000 + "}", '{"do":"nothing","do":"hash"}', '{"do":"\\ud800"}', '{"do":"nothing\\u0000"}',
                     "/*x*/{}", "\ufeff{}", deep(10), deep(1000), deep(30000), "[" * 60000, '{"a":' * 10000, '{"do":"set","value":' + deep(500) + "}",
                     '{"do":"pull","nodes":' + deep(20000) + "}", " " * 60000, "x" * 65000):
            self.page.socket.send(text)
        self.assertEqual(self.page.hash(), self.state)

    def test_messages_that_are_too_large_end_the_connection(self):
        for size in (70 << 10, 1 << 20, 20 << 20):
            websocket, before = self.other(), self.server.memory()
            try:
                websocket.send('{"do":"set","value":"' + "x" * size + '"}')
            except Closed:
                pass
            self.ends(websocket, f"{size} bytes")
            self.assertLess(self.server.memory() - before, 8 << 20)
        self.page.socket.send(json.dumps({"do": "nothing", "filler": "x" * (60 << 10)}))
        self.assertEqual(self.page.hash(), self.state)

    def test_a_message_in_many_pieces_is_one(self):
        text = json.dumps({"do": "hash", "request": 77}).encode()
        for i, byte in enumerate(text):
            self.page.socket.send(bytes([byte]), opcode=TEXT if i == 0 else 0, fin=i == len(text) - 1)
            if i == 5:
                self.page.socket.send(b"between", opcode=PING)
        self.page.until(lambda: 77 in self.page.replies, "the reply to a message in pieces")
        self.assertTrue(self.page.replies[77]["ok"])

    def test_pieces_without_an_end_are_bounded(self):
        websocket, before = self.other(), self.server.memory()
        try:
            websocket.send(b"x" * 1000, opcode=TEXT, fin=False)
            for _ in range(200000):
                websocket.send_bytes(frame_bytes(b"x" * 1000, opcode=0, fin=False))
        except Closed:
            pass
        self.ends(websocket, "pieces without an end")
        self.assertLess(self.server.memory() - before, 8 << 20)

    def test_frames_that_break_the_rules_end_the_connection(self):
        text = b'{"do":"hash","request":1}'
        huge = bytes([0x81, 0xFF]) + b"\x7f" + b"\xff" * 7
        for name, data in (("binary", frame_bytes(text, opcode=BINARY)), ("not masked", frame_bytes(text, masked=False)),
                           ("reserved bits", frame_bytes(text, reserved=1)), ("an unknown kind", frame_bytes(text, opcode=3)),
                           ("a long ping", frame_bytes(b"x" * 200, opcode=PING)), ("a ping in pieces", frame_bytes(b"x", opcode=PING, fin=False)),
                           ("a continuation of nothing", frame_bytes(text, opcode=0)), ("a length of 2^63", huge + b"x" * 100),
                           ("bytes that are no UTF-8", frame_bytes(b'{"do":"\xff\xfe"}')), ("a surrogate", frame_bytes(b"\xed\xa0\x80")),
                           ("a bad close", frame_bytes(b"\x00", opcode=CLOSE)), ("half a message and a new one", frame_bytes(text, fin=False) + frame_bytes(text))):
            websocket = self.other()
            websocket.send_bytes(data)
            self.ends(websocket, name)

    def test_random_bytes_after_the_upgrade(self):
        noise = random.Random(SEED)
        for _ in range(200):
            websocket = self.server.socket()
            try:
                websocket.send_bytes(noise.randbytes(noise.randrange(1, 3000)))
            except Closed:
                pass
            websocket.cut()

    def test_pages_that_come_and_go_leave_nothing(self):
        for _ in range(20):
            self.server.page().socket.cut()
        before = self.server.memory()
        for i in range(150):
            page = self.server.page(hello=i % 2 == 0)
            page.socket.cut() if i % 3 else page.socket.close()
        last = self.server.page()  # whose first word on who is there comes after all of them
        last.until(lambda: last.status["clients"] == 2, "the others to be gone")
        self.assertLess(self.server.memory() - before, 16 << 20)

    def test_more_messages_than_may_wait_lose_no_page(self):
        """While the run is busy: a new page gets its scene, and the hands of one that goes are let go."""
        busy = self.page
        busy.do("force", hand="f", body=0, nodes=[3], force=[0, 0, 0])
        busy.socket.send({"do": "step", "count": 1000})
        for _ in range(2000):
            busy.socket.send({"do": "doubts"})
        page = self.server.page()
        busy.socket.cut()
        page.until(lambda: page.frame is not None and page.frame["step"] == 1002 and not page.frame["hands"], "a picture without hands")
        self.state = page.hash()

    def test_before_hello_nothing_is_done(self):
        page = self.server.page(hello=False)
        for message in GOOD[1:]:
            page.socket.send({**message, "request": 5})
            page.until(lambda: 5 in page.replies, "a refusal")
            self.assertFalse(page.replies.pop(5)["ok"], message)


class Fuzz(unittest.TestCase):
    """Seeded messages, most of them nearly right."""

    def setUp(self):
        self.random = random.Random(SEED)

    def value(self, depth=0):
        """Anything that JSON can say."""
        kind = self.random.randrange(12 if depth < 3 else 8)
        if kind < 3:
            return self.random.choice(WRONG[:22])
        if kind < 5:
            return self.random.randrange(-3, 200)
        if kind < 6:
            return self.random.uniform(-1, 1) * 10.0 ** self.random.randrange(-300, 300)
        if kind < 8:
            return self.random.choice(["h", "fast", "real", "all", "surface", "u16", "energy", "node.0.1.velocity", "/organ/fem", "youngModulus",
                                       "gravity", "/", "0", "1e3", "-1", "node.9.9.x", "hold", "../../etc"])
        if kind < 10:
            return [self.value(depth + 1) for _ in range(self.random.randrange(5))]
        if kind < 11:
            return [self.random.uniform(-0.2, 0.2) for _ in range(3)]
        return {self.random.choice(["do", "hand", "body", "x"]): self.value(depth + 1) for _ in range(self.random.randrange(4))}

    def message(self):
        """A message with some values replaced, or a text with some letters replaced."""
        message = dict(self.random.choice(GOOD))
        if message["do"] == "step":
            message["count"] = self.random.choice([1, 2, 0, -1, 0.5, "1"])
        for field in list(message):
            if self.random.random() < 0.25 and field != "do":
                message[field] = self.value()
            elif self.random.random() < 0.03:
                message.pop(field)
        if self.random.random() < 0.3:
            message["request"] = self.value() if self.random.random() < 0.2 else self.random.randrange(1000)
        if message.get("do") == "step" and message.get("count", 1) not in (1, 2, 0, -1, 0.5, "1"):
            message["count"] = 1
        text = json.dumps(message)
        if self.random.random() < 0.1:
            at = self.random.randrange(len(text) + 1)
            text = text[:at] + self.random.choice(["", "{", "]", '"', "\\", "1e9999", "é", "\u0000"]) + text[at + self.random.randrange(4):]
        return text

    def test_the_server_outlives_them(self):
        began, reader_every = time.monotonic(), 200
        with Server(STROMA, SCENE, "--paused", "--fps", "20") as server:
            page = server.page()
            page.take_text = lambda message: None  # numbers of requests are anything
            memory = 0
            for count in range(MESSAGES):
                try:
                    page.socket.send(self.message())
                    if count % reader_every == 0:
                        while page.take(0.001):
                            pass
                except Closed:
                    page = server.page(draws=self.random.random() < 0.5, hello=self.random.random() < 0.9)
                    page.take_text = lambda message: None
                if count == MESSAGES // 4:
                    memory = server.memory()
                self.assertIsNone(server.process.poll(), f"the server ended at message {count}, seed {SEED}")
            page.socket.cut()
            page = server.page()
            page.do("control")
            page.do("pause")
            self.assertLess(server.memory() - memory, 200 << 20)
            # edits stay; a value that a message may have set is put back by hand, and the run is that of the scene
            for path, attribute, value in (("/organ/fem", "youngModulus", "10000"), ("/", "gravity", "0 -9.81 0"), ("/", "dt", "0.02")):
                page.do("set", path=path, attribute=attribute, value=value)
            page.do("reset")
            page.do("step", count=3)
            with Server(STROMA, SCENE, "--paused") as other:
                fresh = other.page()
                fresh.do("step", count=3)
                self.assertEqual(page.hash(), fresh.hash())
        print(f"{MESSAGES} messages in {time.monotonic() - began:.1f} s, seed {SEED}")


def option(name, default):
    """Takes `--name N` out of the arguments."""
    if name not in sys.argv:
        return default
    at = sys.argv.index(name)
    value = int(sys.argv[at + 1])
    del sys.argv[at:at + 2]
    return value


if __name__ == "__main__":
    MESSAGES, SEED = option("--messages", MESSAGES), option("--seed", SEED)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
