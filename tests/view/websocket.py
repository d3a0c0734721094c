# SPDX-License-Identifier: LGPL-2.1-or-later
"""A small websocket client (RFC 6455) over a socket, and the packets that `stroma view` sends by it."""
import base64
import hashlib
import json
import os
import socket
import struct
import time

import numpy

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
KEY_SUFFIX = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
# Seconds after which something hangs. Nothing is ever expected to take a time: a machine may be slow, and busy with other work.
PATIENCE = float(os.environ.get("STROMA_TEST_PATIENCE", 300))
TYPES = {"f32": "<f4", "u16": "<u2", "i32": "<i4", "u8": "u1"}


class Closed(Exception):
    """The other end has gone, or refused the upgrade: `status` is what it answered then."""

    def __init__(self, text, status=0):
        super().__init__(text)
        self.status = status


def frame_bytes(payload, opcode=TEXT, fin=True, masked=True, reserved=0):
    """One frame; a client's are masked."""
    if isinstance(payload, str):
        payload = payload.encode("utf-8")
    head = bytes([(0x80 if fin else 0) | reserved << 4 | opcode])
    length, mask_bit = len(payload), 0x80 if masked else 0
    if length < 126:
        head += bytes([mask_bit | length])
    elif length < 1 << 16:
        head += bytes([mask_bit | 126]) + struct.pack(">H", length)
    else:
        head += bytes([mask_bit | 127]) + struct.pack(">Q", length)
    if not masked:
        return head + payload
    mask = os.urandom(4)
    whole = mask * (length // 4 + 1)
    hidden = (int.from_bytes(payload, "little") ^ int.from_bytes(whole[:length], "little")).to_bytes(length, "little")
    return head + mask + hidden


def read_head(stream):
    """Status and headers (names in small letters) of an HTTP answer; raises Closed where there is none."""
    line = stream.readline(1 << 16).decode("latin-1")
    if not line.startswith("HTTP/1."):
        raise Closed(f"no answer but {line!r}")
    status, headers = int(line.split()[1]), {}
    while True:
        line = stream.readline(1 << 16).decode("latin-1").rstrip("\r\n")
        if not line:
            return status, headers
        name, _, value = line.partition(":")
        headers[name.strip().lower()] = value.strip()


class WebSocket:
    """`headers`: {name: value} beside those of the upgrade; a value of None leaves the header out."""

    def __init__(self, port, path="/live", headers=None, timeout=PATIENCE):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.stream = self.socket.makefile("rb", buffering=1 << 18)
        key = base64.b64encode(os.urandom(16)).decode()
        given = {"Host": f"127.0.0.1:{port}", "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Key": key,
                 "Sec-WebSocket-Version": "13", **(headers or {})}
        lines = [f"GET {path} HTTP/1.1"] + [f"{name}: {value}" for name, value in given.items() if value is not None]
        try:
            self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))
            status, answer = read_head(self.stream)
        except OSError as error:
            raise Closed(str(error)) from error
        if status != 101:
            self.cut()
            raise Closed(f"the upgrade was answered with {status}", status)
        expected = base64.b64encode(hashlib.sha1((key + KEY_SUFFIX).encode()).digest()).decode()
        assert answer.get("sec-websocket-accept") == expected, answer
        self.kind, self.parts = None, []

    def send(self, payload, **options):
        """A text message, or what the options of frame_bytes() say. Objects are sent as JSON."""
        if not isinstance(payload, (str, bytes)):
            payload = json.dumps(payload)
        self.send_bytes(frame_bytes(payload, **options))

    def send_bytes(self, data):
        """As they are."""
        try:
            self.socket.sendall(data)
        except OSError as error:
            raise Closed(str(error)) from error

    def receive(self, timeout):
        """(TEXT, str) or (BINARY, bytes); None when nothing has come within `timeout` seconds. Raises Closed."""
        end = time.monotonic() + timeout
        while True:
            one = self._frame(end)
            if one is None:
                return None
            fin, opcode, payload = one
            if opcode == CLOSE:
                raise Closed(f"closed by the server: {payload[:2].hex()} {payload[2:].decode('utf-8', 'replace')}")
            if opcode == PING:
                self.send(payload, opcode=PONG)
            elif opcode in (0, TEXT, BINARY):
                self.kind = opcode or self.kind
                self.parts.append(payload)
                if fin:
                    whole, self.parts = b"".join(self.parts), []
                    return self.kind, whole.decode("utf-8") if self.kind == TEXT else whole

    def _frame(self, end):
        # only a frame that has not begun is waited for with the timeout of the caller
        try:
            self.socket.settimeout(max(0.001, end - time.monotonic()))
            head = self.stream.peek(1)
        except (TimeoutError, socket.timeout):
            # a buffered reader does not read again after a timeout
            self.stream = self.socket.makefile("rb", buffering=1 << 18)
            return None
        except OSError as error:
            raise Closed(str(error)) from error
        if not head:
            raise Closed("the connection has ended")
        self.socket.settimeout(PATIENCE)
        try:
            first, second = self._read(2)
            assert second & 0x80 == 0, "a server's frame is masked"
            length = second & 0x7F
            if length == 126:
                length, = struct.unpack(">H", self._read(2))
            elif length == 127:
                length, = struct.unpack(">Q", self._read(8))
            return first & 0x80 != 0, first & 0x0F, self._read(length)
        except OSError as error:
            raise Closed(str(error)) from error

    def _read(self, count):
        data = self.stream.read(count)
        if len(data) < count:
            raise Closed("the connection ended within a frame")
        return data

    def cut(self):
        """Without a word, as a network does."""
        try:
            self.stream.close()
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.socket.close()

    def close(self):
        """As a browser does."""
        try:
            self.send(struct.pack(">H", 1000), opcode=CLOSE)
        except Closed:
            pass
        self.cut()


class Packet:
    """`header` and `arrays`: {name: numpy array}. Raises AssertionError for what the format does not allow."""

    def __init__(self, data):
        assert data[:4] == b"SRM1", f"a packet begins with {data[:4]!r}"
        length, = struct.unpack_from("<I", data, 4)
        assert length % 8 == 0 and 8 + length <= len(data), f"a header of {length} bytes in {len(data)}"
        text = data[8:8 + length].decode("utf-8")
        self.header = json.loads(text)
        self.bytes = len(data)
        self.arrays, end = {}, 0
        for name, array in self.header.get("arrays", {}).items():
            kind = numpy.dtype(TYPES[array["type"]])
            assert array["offset"] % 8 == 0, f"{name} begins at {array['offset']}"
            begin = 8 + length + array["offset"]
            assert begin + array["length"] * kind.itemsize <= len(data), f"{name} ends behind the packet"
            self.arrays[name] = numpy.frombuffer(data, kind, array["length"], begin)
            end = max(end, begin + array["length"] * kind.itemsize)
        assert len(data) - max(end, 8 + length) < 8, f"{len(data) - end} bytes belong to no array"

    def __getitem__(self, name):
        return self.header[name]

    def get(self, name, default=None):
        """Of the header."""
        return self.header.get(name, default)
