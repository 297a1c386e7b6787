"""Runs the real programs for the tests: burnish, burnishd on free ports, curl, and a Python gRPC client."""

import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import unittest

import grpc
from burnish.v1 import smoothing_pb2, smoothing_pb2_grpc
from google.rpc import error_details_pb2, status_pb2

BURNISH = os.environ["BURNISH"]
BURNISHD = os.environ["BURNISHD"]
CURL = os.environ["CURL"]
# A proxy of the environment must not stand between programs of one machine.
ENVIRONMENT = {**os.environ, "no_proxy": "*", "NO_PROXY": "*", "no_grpc_proxy": "127.0.0.1"}
PATIENCE_SECONDS = 60
# scripts/setup installs it where there is an npm registry.
NODE_MODULES = os.environ.get("NODE_MODULES", "")
needs_npm = unittest.skipUnless(pathlib.Path(NODE_MODULES, "installed.json").exists(), "scripts/setup found no npm registry")


def eventually(condition, what, seconds=PATIENCE_SECONDS):
    """Polls an observable state; returns its first true value."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.002)
    raise AssertionError(f"not within {seconds} s: {what}")


def burnish(*arguments):
    """Runs the command line; returns the finished process with text output."""
    return subprocess.run([BURNISH, *map(str, arguments)], env=ENVIRONMENT, capture_output=True, text=True,
                          timeout=PATIENCE_SECONDS)


def start_burnish(*arguments):
    """Starts the command line and returns once it has taken charge of Ctrl-C."""
    process = subprocess.Popen([BURNISH, *map(str, arguments)], env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True)

    def blocks_interrupt():
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        return int(re.search(r"SigBlk:\s*(\w+)", status)[1], 16) & (1 << (signal.SIGINT - 1))

    eventually(blocks_interrupt, "burnish watches for Ctrl-C")
    return process


class HttpAnswer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def report(self):
        return json.loads(self.headers["burnish-report"])

    @property
    def problem(self):
        assert self.headers["content-type"].startswith("application/problem+json"), self.headers
        return json.loads(self.body)


class Server:
    """A burnishd on free ports; a context manager that ends it and checks that it exits with 0. Its store is its own
    unless one is given."""

    def __init__(self, *flags, store=None, program=BURNISHD, http="127.0.0.1:0"):
        self.folder = tempfile.TemporaryDirectory(prefix="burnish-e2e-")
        ports_file = pathlib.Path(self.folder.name, "ports.json")
        self.log = open(pathlib.Path(self.folder.name, "log"), "w+")
        self.process = subprocess.Popen(
            [program, "--grpc-listen", "127.0.0.1:0", "--http-listen", http, "--ports-file",
             str(ports_file), "--store", str(store or pathlib.Path(self.folder.name, "store")), *map(str, flags)], env=ENVIRONMENT, stdout=self.log, stderr=self.log)
        eventually(lambda: ports_file.exists() or self.process.poll() is not None, "burnishd serves")
        assert self.process.poll() is None, self.log_text()
        ports = json.loads(ports_file.read_text())
        self.grpc, self.http = ports["grpc"], ports["http"]

    def log_text(self):
        self.log.seek(0)
        return self.log.read()

    def terminate(self):
        self.process.send_signal(signal.SIGTERM)

    def kill(self):
        """As the kernel does it: nothing is told, nothing is closed."""
        self.process.kill()
        self.process.wait()
        self.log.close()
        self.folder.cleanup()

    def exit_code(self):
        return self.process.wait(PATIENCE_SECONDS)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if self.process.poll() is None:
            self.terminate()
        try:
            code = self.exit_code()
            if kind is None:
                assert code == 0, f"burnishd exited with {code}:\n{self.log_text()}"
        finally:
            if self.process.poll() is None:
                self.process.kill()
                self.process.wait()
            self.log.close()
            self.folder.cleanup()

    def curl_command(self, target, *flags):
        return [CURL, "-sS", "--max-time", str(PATIENCE_SECONDS), *map(str, flags), f"http://{self.http}{target}"]

    def curl(self, target, *flags):
        with tempfile.TemporaryDirectory() as folder:
            head, body = pathlib.Path(folder, "head"), pathlib.Path(folder, "body")
            body.touch()
            done = subprocess.run(self.curl_command(target, "-D", head, "-o", body, *flags), env=ENVIRONMENT,
                                  capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            blocks = [b for b in head.read_bytes().decode("latin-1").split("\r\n\r\n") if b.startswith("HTTP/")]
            first, *lines = blocks[-1].split("\r\n")
            headers = {n.strip().lower(): v.strip() for n, v in (line.split(":", 1) for line in lines if line)}
            return HttpAnswer(int(first.split()[1]), headers, body.read_bytes())

    def post(self, path, query=""):
        return self.curl("/v1/smooth" + ("?" + query if query else ""), "--data-binary", f"@{path}")

    def metric(self, name, **labels):
        """Sum of the samples with these labels."""
        total = 0.0
        for line in self.curl("/metrics").body.decode().splitlines():
            match = re.fullmatch(r"(\w+)(?:\{(.*)\})? (\S+)(?: \d+)?", line)
            if match and match[1] == name:
                found = dict(re.findall(r'(\w+)="([^"]*)"', match[2] or ""))
                if all(found.get(k) == v for k, v in labels.items()):
                    total += float(match[3])
        return total

    def stub(self):
        channel = grpc.insecure_channel(self.grpc, options=[("grpc.enable_http_proxy", 0),
                                                            ("grpc.max_receive_message_length", -1),
                                                            ("grpc.max_send_message_length", -1)])
        return smoothing_pb2_grpc.SmoothingServiceStub(channel)


def smooth_request(path, **options):
    """A SmoothRequest for a file; options are parameters by name, or fields of SmoothOptions."""
    request = smoothing_pb2.SmoothRequest(mesh=pathlib.Path(path).read_bytes())
    for name, value in options.items():
        if name in ("method", "iterations"):
            setattr(request.options, name, value)
        elif name in ("output", "pinned"):
            getattr(request.options, name).CopyFrom(value)
        elif isinstance(value, str):
            request.options.parameters[name].string_value = value
        else:
            request.options.parameters[name].number_value = value
    return request


def error_info(error):
    """The ErrorInfo and the BadRequest (or None) of a failed call."""
    details = dict(error.trailing_metadata()).get("grpc-status-details-bin", b"")
    info, bad_request = error_details_pb2.ErrorInfo(), error_details_pb2.BadRequest()
    found = None
    for detail in status_pb2.Status.FromString(details).details:
        detail.Unpack(info)
        if detail.Unpack(bad_request):
            found = bad_request
    return info, found


class MeshTest(unittest.TestCase):
    """A test case with a folder that holds the noisy sample and its noise-free reference."""

    RESOLUTION = 16

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory(prefix="burnish-e2e-")
        cls.addClassCleanup(cls._folder.cleanup)
        cls.folder = pathlib.Path(cls._folder.name)
        cls.noisy, cls.clean = cls.folder / "noisy.obj", cls.folder / "clean.obj"
        for path, amplitude in (cls.noisy, 0.3), (cls.clean, 0):
            done = burnish("sample", path, "--amplitude", amplitude, "--resolution", cls.RESOLUTION)
            assert done.returncode == 0, done.stderr

    def run_burnish(self, *arguments, code=0):
        done = burnish(*arguments)
        self.assertEqual(done.returncode, code, f"burnish {arguments}: {done.stderr}")
        return done
