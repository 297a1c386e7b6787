"""What strangers send: with the default settings each gets its error or its timeout, the server's memory stays bounded,
and honest requests go on meanwhile."""

import contextlib
import json
import pathlib
import socket
import threading
import time
import unittest
import zlib

from programs import MeshTest, Server, eventually

MEGABYTE = 1 << 20
MOST_OVER_IDLE = 200 * MEGABYTE
SLOW_CLIENTS = 200
JSON_HEAD = b'--x\r\nContent-Disposition: form-data; name="%b"\r\n\r\n'


def head(length=None, *headers, path="/v1/smooth"):
    lines = [f"POST {path} HTTP/1.1", "Host: server", *headers]
    lines.append("Transfer-Encoding: chunked" if length is None else f"Content-Length: {length}")
    return "\r\n".join(lines).encode() + b"\r\n\r\n"


def chunk(data):
    return b"%x\r\n%b\r\n" % (len(data), data)


def endless_body():
    yield head()
    piece = chunk(b"# a comment that never ends\n" * 37449)  # a megabyte
    for _ in range(300):
        yield piece
    yield chunk(b"")


def gzip_bomb():
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    packed = b"".join(packer.compress(b"\0" * MEGABYTE) for _ in range(300)) + packer.flush()
    assert len(packed) < 320_000, len(packed)
    yield head(len(packed), "Content-Encoding: gzip")
    yield packed


def endless_header_line():
    yield b"POST /v1/smooth HTTP/1.1\r\nX: "
    for _ in range(50):
        yield b"x" * MEGABYTE


def many_headers():
    yield b"POST /v1/smooth HTTP/1.1\r\n" + b"".join(b"X-%d: y\r\n" % i for i in range(50_000)) + b"\r\n"


def one_byte_chunks():
    yield head()
    for _ in range(200):
        yield chunk(b"x") * 1000
    yield chunk(b"")


def nested_arrays(depth):
    body = JSON_HEAD % b"options" + b"[" * depth + b"\r\n" + JSON_HEAD % b"mesh" + b"v 0 0 0\r\n--x--\r\n"
    yield head(len(body), "Content-Type: multipart/form-data; boundary=x")
    yield body


def whole(body):
    yield head(len(body))
    yield body


class Hostile(MeshTest):
    def setUp(self):
        self.server = Server().__enter__()
        self.addCleanup(self.server.__exit__, None, None, None)
        self.idle = self.resident()
        self.most = self.idle

    def resident(self):
        status = pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0]) * 1024

    @contextlib.contextmanager
    def watched(self):
        """Notes the largest resident size while it lasts."""
        ended = threading.Event()

        def watch():
            while not ended.wait(0.005):
                self.most = max(self.most, self.resident())

        watcher = threading.Thread(target=watch)
        watcher.start()
        try:
            yield
        finally:
            ended.set()
            watcher.join()

    def send(self, pieces):
        """Sends until the server has had enough; returns the status and the problem of its answer."""
        host, port = self.server.http.split(":")
        with socket.create_connection((host, int(port)), timeout=60) as connection:
            with contextlib.suppress(OSError):  # it may stop listening before all is said
                for piece in pieces:
                    connection.sendall(piece)
            answer = b""
            with contextlib.suppress(OSError):
                while not self.complete(answer) and (more := connection.recv(65536)):
                    answer += more
        self.assertTrue(answer.startswith(b"HTTP/1.1 "), answer[:100])
        return int(answer.split()[1]), json.loads(answer.split(b"\r\n\r\n", 1)[1])

    @staticmethod
    def complete(answer):
        first, end, body = answer.partition(b"\r\n\r\n")
        for line in first.split(b"\r\n"):
            if end and line.lower().startswith(b"content-length:"):
                return len(body) >= int(line.split(b":")[1])
        return False

    def check_memory(self):
        self.assertLess(self.most - self.idle, MOST_OVER_IDLE)

    def test_each_gets_its_error_while_memory_stays_bounded(self):
        draco = pathlib.Path(self.folder) / "mesh.drc"
        self.run_burnish("smooth", self.noisy, draco, "--iterations", 0)
        mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"
        cases = {
            "300 MB chunked": (endless_body(), 413, "too_large"),
            "gzip bomb": (gzip_bomb(), 413, "too_large"),
            "endless header line": (endless_header_line(), 431, "bad_request"),
            "50k headers": (many_headers(), 431, "bad_request"),
            "one-byte chunks": (one_byte_chunks(), 422, "empty_mesh"),
            "a million nested arrays": (nested_arrays(1_000_000), 413, "too_large"),
            "60k nested arrays": (nested_arrays(60_000), 400, "bad_option"),
            "index 0": (whole(mesh + b"f 0 1 2\n"), 422, "index_out_of_range"),
            "index 10^9": (whole(mesh + b"f 1 2 1000000000\n"), 422, "index_out_of_range"),
            "NaN": (whole(b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), 422, "non_finite_position"),
            "Draco point cloud": (whole(b"DRACO\x02\x02\x00\x00\x00\x00" + b"\xff" * 100), 422, "not_a_triangle_mesh"),
            "truncated Draco": (whole(draco.read_bytes()[:1000]), 422, "malformed_mesh"),
        }
        for name, (pieces, status, code) in cases.items():
            with self.subTest(name), self.watched():
                start = time.monotonic()
                got, problem = self.send(pieces)
                print(f"{name}: {got} {problem['code']} after {time.monotonic() - start:.2f} s")
                self.assertEqual((got, problem["code"]), (status, code), problem)
        print(f"largest resident size over idle: {(self.most - self.idle) / MEGABYTE:.0f} MB")
        self.check_memory()
        self.assertEqual(self.server.post(self.noisy).status, 200)

    def test_slow_clients_time_out_and_hold_nobody_up(self):
        host, port = self.server.http.split(":")
        clients = [socket.create_connection((host, int(port)), timeout=60) for _ in range(SLOW_CLIENTS)]
        self.addCleanup(lambda: [client.close() for client in clients])
        text = b"POST /v1/smooth HTTP/1.1\r\nHost: slow\r\nX-Endless: " + b"x" * 1000
        ended = threading.Event()

        def trickle():
            for byte in text:
                for client in clients:
                    with contextlib.suppress(OSError):
                        client.sendall(bytes([byte]))
                if ended.wait(1):
                    return

        trickler = threading.Thread(target=trickle)
        trickler.start()
        self.addCleanup(lambda: (ended.set(), trickler.join()))
        with self.watched():
            honest = []
            for _ in range(20):
                start = time.monotonic()
                self.assertEqual(self.server.post(self.noisy).status, 200)
                honest.append(time.monotonic() - start)
            for client in clients:
                self.assertEqual(client.recv(65536).split()[1], b"408")
        print(f"an honest request beside {SLOW_CLIENTS} slow ones: {1000 * sorted(honest)[10]:.0f} ms with curl's start")
        self.check_memory()
        eventually(lambda: self.server.metric("burnish_outcomes_total", code="request_timeout") == SLOW_CLIENTS,
                   "every slow client is counted")


if __name__ == "__main__":
    unittest.main()
