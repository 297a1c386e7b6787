"""Clients that nobody here wrote, against the image: each gets the bytes of the command line."""

import base64
import gzip
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from engine import BURNISH, ENVIRONMENT, PATIENCE_SECONDS, ROOT, STUBS, Burnishd, new_secrets, sample, tell

import draco3d
import grpc
from burnish.v1 import smoothing_pb2, smoothing_pb2_grpc

NODE_MODULES = ROOT / "build/npm/node_modules"
GRPC_JS = ROOT / "tests/npm/smooth_grpc_js.cjs"
GOOGLE_RPC = os.environ.get("GOOGLE_RPC_PROTO_DIR", "/usr/share/gocode/src/github.com/gogo/googleapis")
OPTIONS = {"method": "taubin", "iterations": 5}
QUERY = "method=taubin&iterations=5"


class Clients(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.mesh_file, out = cls.folder / "noisy.obj", cls.folder / "out.obj"
        cls.mesh = sample(cls.mesh_file, 44)
        subprocess.run([BURNISH, "smooth", str(cls.mesh_file), str(out), "--method", "taubin", "--iterations", "5"], check=True,
                       capture_output=True)
        cls.expected = out.read_bytes()
        cls.keys = cls.enterClassContext(new_secrets())
        cls.server = cls.enterClassContext(Burnishd(cls.keys))
        cls.grpc = f"127.0.0.1:{cls.server.GRPC}"
        cls.http = f"http://127.0.0.1:{cls.server.HTTP}"
        cls.metadata = [("authorization", f"Bearer {cls.keys.token}")]
        cls.channel = cls.enterClassContext(grpc.insecure_channel(cls.grpc, options=[("grpc.enable_http_proxy", 0)]))

    def run_client(self, *command, text=None, **environment):
        done = subprocess.run([*map(str, command)], input=text, env={**ENVIRONMENT, **environment}, capture_output=True,
                              text=True, cwd=self.folder, timeout=PATIENCE_SECONDS)
        self.assertEqual(done.returncode, 0, done.stderr + done.stdout[-2000:])
        return done.stdout

    def test_python_grpcio(self):
        stub = smoothing_pb2_grpc.SmoothingServiceStub(self.channel)
        options = smoothing_pb2.SmoothOptions(**OPTIONS)
        answer = stub.Smooth(smoothing_pb2.SmoothRequest(mesh=self.mesh, options=options), metadata=self.metadata)
        self.assertEqual(answer.mesh, self.expected)
        parts = [smoothing_pb2.SmoothStreamRequest(start=smoothing_pb2.SmoothStart(options=options)),
                 smoothing_pb2.SmoothStreamRequest(mesh_chunk=self.mesh)]
        answers = stub.SmoothStream(iter(parts), metadata=self.metadata)
        self.assertEqual(b"".join(answer.mesh_chunk for answer in answers), self.expected)
        with self.assertRaises(grpc.RpcError) as refused:
            stub.Smooth(smoothing_pb2.SmoothRequest(mesh=self.mesh, options=options))
        self.assertEqual(refused.exception.code(), grpc.StatusCode.UNAUTHENTICATED)

    def test_node_grpc_js(self):
        for way in "unary", "stream":
            out = self.folder / way
            self.run_client("node", GRPC_JS, self.grpc, way, json.dumps(OPTIONS), self.mesh_file, out,
                            NODE_PATH=str(NODE_MODULES), GOOGLE_RPC_PROTO_DIR=GOOGLE_RPC, BURNISH_TOKEN=self.keys.token)
            self.assertEqual(out.read_bytes(), self.expected)

    def test_buf_curl_over_reflection(self):
        request = json.dumps({"mesh": base64.b64encode(self.mesh).decode(), "options": OPTIONS})
        out = self.run_client(NODE_MODULES / ".bin/buf", "curl", "--protocol", "grpc", "--http2-prior-knowledge", "-H",
                              f"Authorization: Bearer {self.keys.token}", "--data", "@-",
                              f"http://{self.grpc}/burnish.v1.SmoothingService/Smooth", text=request)
        self.assertEqual(base64.b64decode(json.loads(out)["mesh"]), self.expected)

    def test_grpc_health_by_its_protocol(self):
        # By its wire form: HealthCheckRequest.service is field 1, HealthCheckResponse.status is field 1, 1 is SERVING.
        check = self.channel.unary_unary("/grpc.health.v1.Health/Check", lambda name: b"\n" + bytes([len(name)]) + name, bytes)
        for name in b"", b"burnish.v1.SmoothingService":
            self.assertEqual(check(name, timeout=PATIENCE_SECONDS), b"\x08\x01")

    def test_curl(self):
        ways = []
        packed = self.folder / "noisy.obj.gz"
        packed.write_bytes(gzip.compress(self.mesh))
        plain = ["--data-binary", f"@{self.mesh_file}"]
        for name, flags in {"HTTP/1.1": plain,
                            "chunked": [*plain, "-H", "Transfer-Encoding: chunked"],
                            "Expect: 100-continue": [*plain, "-H", "Expect: 100-continue"],
                            "gzip both ways": ["--data-binary", f"@{packed}", "-H", "Content-Encoding: gzip", "--compressed"],
                            "form": ["-F", f"mesh=@{self.mesh_file}", "-F", f"options={json.dumps(OPTIONS)}"]}.items():
            with self.subTest(name):
                out = self.folder / "curl"
                query = "" if name == "form" else f"?{QUERY}"
                self.run_client("curl", "-sS", "--fail", "--http1.1", "-H", f"Authorization: Bearer {self.keys.token}", "-o", out,
                                *flags, f"{self.http}/v1/smooth{query}")
                self.assertEqual(out.read_bytes(), self.expected)
                ways.append(name)
        tell("curl", ways=f"{len(ways)} ({', '.join(ways)})")

    def test_examples_of_a_scanning_app(self):
        """Python and JavaScript here; the C++ one runs in package_test."""
        environment = {"BURNISH_TOKEN": self.keys.token, "PYTHONPATH": STUBS}
        expected = self.folder / "auto.obj"
        subprocess.run([BURNISH, "smooth", str(self.mesh_file), str(expected)], check=True, capture_output=True)
        for program, example, address in [("/usr/bin/python3", "python/smooth_scan.py", self.grpc),
                                          ("/usr/bin/python3", "python/submit_scan.py", self.http),
                                          ("node", "javascript/smooth_scan.mjs", self.http)]:
            with self.subTest(example):
                out = self.folder / "example.obj"
                said = self.run_client(program, ROOT / "client/examples" / example, address, self.mesh_file, out, **environment)
                self.assertEqual(out.read_bytes(), expected.read_bytes())
                tell(example, says=said.strip())

    def test_draco3d(self):
        positions, faces = draco3d.read_obj(self.folder / "out.obj")
        distance = 0
        for version in draco3d.VERSIONS:
            for method in draco3d.METHODS:
                with self.subTest(version=version, method=method):
                    drc = self.folder / f"{version}-{method}.drc"
                    status, _, result = self.server.call("POST", f"/v1/smooth?{QUERY}", draco3d.encode(
                        NODE_MODULES, version, self.mesh_file, drc, method))
                    self.assertEqual(status, 200)
                    drc.write_bytes(result)
                    found, found_faces = draco3d.decode(NODE_MODULES, version, drc)
                    self.assertEqual(found_faces, faces)
                    distance = max(distance, draco3d.largest_distance(found, positions))
        self.assertLess(distance, 1e-6, "of the mesh's extent: floats")
        tell("draco3d", versions=" ".join(draco3d.VERSIONS), methods=" ".join(draco3d.METHODS),
             largest_distance_from_the_OBJ_result=f"{distance:.1e}")

    def test_h2load(self):
        # Calls of gRPC as HTTP/2 posts, by a tool that knows no gRPC: ListMethods takes an empty message.
        empty = self.folder / "empty"
        empty.write_bytes(b"\0\0\0\0\0")
        out = self.run_client("h2load", "-n", "5000", "-c", "8", "-m", "20", "-d", empty, "-H", "content-type: application/grpc",
                              "-H", "te: trailers", "-H", f"authorization: Bearer {self.keys.token}",
                              f"http://{self.grpc}/burnish.v1.SmoothingService/ListMethods")
        self.assertRegex(out, r"5000 succeeded, 0 failed, 0 errored, 0 timeout")
        tell("h2load", calls=5000, per_second=re.search(r"([\d.]+) req/s", out)[1])


if __name__ == "__main__":
    unittest.main()
