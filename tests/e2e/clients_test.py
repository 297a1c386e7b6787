"""Clients that nobody here wrote get the command line's bytes and see what is wrong with a mesh."""

import base64
import json
import pathlib
import subprocess
import unittest

import grpc
from google.protobuf import json_format
from google.rpc import error_details_pb2

import draco3d
from burnish.v1 import smoothing_pb2
from programs import ENVIRONMENT, NODE_MODULES, PATIENCE_SECONDS, MeshTest, Server, error_info, needs_npm, smooth_request

BUF = pathlib.Path(NODE_MODULES, ".bin", "buf")
GRPC_JS = pathlib.Path(__file__).parents[1] / "npm" / "smooth_grpc_js.cjs"
CHUNK_BYTES = 256 * 1024
OPTIONS = {"method": "taubin", "iterations": 5}


class Refused(Exception):
    """What a client shows of a failed call."""

    def __init__(self, reason, message):
        super().__init__(reason, message)
        self.reason, self.message = reason, message


def chunks(path):
    data = path.read_bytes()
    return [data[at:at + CHUNK_BYTES] for at in range(0, len(data), CHUNK_BYTES)]


def report_json(message):
    return json_format.MessageToDict(message, including_default_value_fields=True)


def curl(server, mesh):
    answer = server.post(mesh, "&".join(f"{name}={value}" for name, value in OPTIONS.items()))
    if answer.status != 200:
        raise Refused(answer.problem["code"].upper(), answer.problem["detail"])
    return answer.body, answer.report


def refused_by_grpcio(error):
    return Refused(error_info(error)[0].reason, error.details())


def grpcio_unary(server, mesh):
    try:
        response = server.stub().Smooth(smooth_request(mesh, **OPTIONS))
    except grpc.RpcError as error:
        raise refused_by_grpcio(error) from error
    return response.mesh, report_json(response.report)


def grpcio_stream(server, mesh):
    options = smoothing_pb2.SmoothOptions(**OPTIONS)
    requests = [smoothing_pb2.SmoothStreamRequest(start=smoothing_pb2.SmoothStart(options=options)),
                *(smoothing_pb2.SmoothStreamRequest(mesh_chunk=chunk) for chunk in chunks(mesh))]
    try:
        responses = list(server.stub().SmoothStream(iter(requests)))
    except grpc.RpcError as error:
        raise refused_by_grpcio(error) from error
    return b"".join(response.mesh_chunk for response in responses), report_json(responses[-1].report)


def grpc_js(way):
    def call(server, mesh):
        out = mesh.with_suffix(".grpc_js")
        done = subprocess.run(["node", GRPC_JS, server.grpc, way, json.dumps(OPTIONS), mesh, out], text=True,
                              env={**ENVIRONMENT, "NODE_PATH": NODE_MODULES}, capture_output=True,
                              timeout=PATIENCE_SECONDS)
        if done.returncode:
            error = json.loads(done.stderr)
            raise Refused(error["reason"], error["message"])
        return out.read_bytes(), json.loads(done.stdout)
    return call


def buf_curl(server, mesh):
    """buf knows no schema but what the server's reflection tells."""
    request = {"mesh": base64.b64encode(mesh.read_bytes()).decode(), "options": OPTIONS}
    done = subprocess.run([BUF, "curl", "--protocol", "grpc", "--http2-prior-knowledge", "--emit-defaults",
                           "--data", "@-", f"http://{server.grpc}/burnish.v1.SmoothingService/Smooth"],
                          input=json.dumps(request), text=True, env=ENVIRONMENT, capture_output=True,
                          cwd=mesh.parent, timeout=PATIENCE_SECONDS)  # no proto files there
    if done.returncode:
        error = json.loads(done.stderr)
        detail = next(detail for detail in error["details"] if detail["type"] == "google.rpc.ErrorInfo")
        info = error_details_pb2.ErrorInfo.FromString(base64.b64decode(detail["value"] + "=="))
        raise Refused(info.reason, error["message"])
    response = json.loads(done.stdout)
    return base64.b64decode(response["mesh"]), response["report"]


CLIENTS = {"curl": curl, "grpcio unary": grpcio_unary, "grpcio stream": grpcio_stream,
           "grpc-js unary": grpc_js("unary"), "grpc-js stream": grpc_js("stream"), "buf curl": buf_curl}


@needs_npm
class Clients(MeshTest):
    RESOLUTION = 44  # more than one chunk

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = Server()
        cls.addClassCleanup(cls.server.__exit__, None)
        cls.drc = cls.folder / "noisy.drc"

    def test_every_client_gets_the_bytes_of_the_command_line(self):
        self.run_burnish("smooth", self.noisy, self.drc, "--iterations", 0)
        for mesh in self.noisy, self.drc:
            self.assertGreater(len(chunks(mesh)), 1)
            out = self.folder / f"smooth{mesh.suffix}"
            done = self.run_burnish("smooth", mesh, out, "--report", "-", "--method", OPTIONS["method"],
                                    "--iterations", OPTIONS["iterations"])
            expected = json.loads(done.stdout)
            for name, client in CLIENTS.items():
                with self.subTest(mesh=mesh.name, client=name):
                    result, report = client(self.server, mesh)
                    self.assertEqual(result, out.read_bytes())
                    for part in "method", "errors", "change", "input", "output", "encoding":
                        self.assertEqual(report[part], expected[part], part)

    def test_every_client_sees_what_is_wrong(self):
        bad = self.folder / "bad.obj"
        bad.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
        for name, client in CLIENTS.items():
            with self.subTest(name):
                with self.assertRaises(Refused) as raised:
                    client(self.server, bad)
                self.assertEqual(raised.exception.reason, "INDEX_OUT_OF_RANGE")
                self.assertRegex(raised.exception.message, r"vertex 9 .*line 4")

    def test_draco3d_of_three_versions_writes_what_comes_in_and_reads_what_comes_out(self):
        out = self.folder / "expected.obj"
        self.run_burnish("smooth", self.noisy, out, "--method", OPTIONS["method"], "--iterations", OPTIONS["iterations"])
        positions, faces = draco3d.read_obj(out)
        for version in draco3d.VERSIONS:
            for method in draco3d.METHODS:
                with self.subTest(version=version, method=method):
                    drc = self.folder / f"{version}-{method}.drc"
                    draco3d.encode(NODE_MODULES, version, self.noisy, drc, method)
                    result = self.folder / "result.drc"
                    result.write_bytes(curl(self.server, drc)[0])
                    found, found_faces = draco3d.decode(NODE_MODULES, version, result)
                    self.assertEqual(found_faces, faces)
                    self.assertLess(draco3d.largest_distance(found, positions), 1e-6, "of the mesh's extent: floats")

    def test_grpcio_compares_by_stream(self):
        expected = json.loads(self.run_burnish("compare", self.clean, self.noisy, "--json").stdout)
        part = smoothing_pb2.CompareStreamRequest
        requests = [part(start=smoothing_pb2.CompareStart()),
                    *(part(reference_chunk=chunk) for chunk in chunks(self.clean)),
                    *(part(mesh_chunk=chunk) for chunk in chunks(self.noisy))]
        self.assertGreater(len(requests), 4)
        report = report_json(self.server.stub().CompareStream(iter(requests)))
        for name in "errors", "mesh", "reference":
            self.assertEqual(report[name], expected[name], name)


if __name__ == "__main__":
    unittest.main()
