"""The command line, gRPC and HTTP give the same bytes and the same report."""

import json
import unittest

from google.protobuf import json_format

from burnish.v1 import smoothing_pb2
from programs import MeshTest, Server, smooth_request

REPORT_NAMES = {
    "version": None, "requestId": None, "method": None, "parameters": None, "warnings": None,
    "errors": {"against", "ev", "evOverEdge", "evOverDiagonal", "meanDistance", "rmsDistance", "maxDistance",
               "meanNormalDegrees", "maxNormalDegrees", "flippedTriangles"},
    "change": {"rmsDisplacement", "maxDisplacement", "areaPercent", "volumePercent",
               "smallestAngleDegreesBefore", "smallestAngleDegreesAfter"},
    "input": {"vertices", "triangles", "boundaryEdges", "components"},
    "output": {"vertices", "triangles", "boundaryEdges", "components"},
    "encoding": {"format", "dracoMethod", "positionBits", "quantisationError", "bytes"},
    "timings": {"queueMs", "decodeMs", "prepareMs", "smoothMs", "measureMs", "encodeMs", "totalMs"},
}


class Transports(MeshTest):
    RESOLUTION = 44  # fine enough for features larger than the smoothing

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = cls.enter_for_class(Server())
        cls.draco = cls.folder / "noisy.drc"

    @classmethod
    def enter_for_class(cls, context):
        value = context.__enter__()
        cls.addClassCleanup(context.__exit__, None, None, None)
        return value

    def check_report(self, report):
        self.assertLessEqual(set(REPORT_NAMES), set(report))
        for name, inner in REPORT_NAMES.items():
            if inner:
                self.assertEqual(set(report[name]), inner, name)
        self.assertIs(type(report["input"]["vertices"]), int)
        for name, value in report["timings"].items():
            self.assertGreaterEqual(value, 0, name)

    def smooth_everywhere(self, mesh, arguments, query, options):
        """Smooths on all four ways; returns what each wrote, by name."""
        results, reports = {}, {}
        for name, flags in ("local", []), ("command line", ["--server", self.server.grpc]):
            out = self.folder / f"{name}.out"
            done = self.run_burnish("smooth", mesh, out, "--report", "-", *arguments, *flags)
            results[name], reports[name] = out.read_bytes(), json.loads(done.stdout)
        answer = self.server.post(mesh, query)
        self.assertEqual(answer.status, 200, answer.body[:300])
        results["curl"], reports["curl"] = answer.body, answer.report
        reply = self.server.stub().Smooth(smooth_request(mesh, **options))
        results["python"] = reply.mesh
        reports["python"] = json_format.MessageToDict(reply.report, including_default_value_fields=True)
        for report in reports.values():
            self.check_report(report)
        for part in "errors", "change", "input", "output", "encoding", "parameters", "method", "pinnedVertices":
            self.assertEqual(reports["local"][part], reports["curl"][part], part)
            self.assertEqual(reports["local"][part], reports["command line"][part], part)
        return results

    def test_same_bytes_whatever_the_way(self):
        self.run_burnish("smooth", self.noisy, self.draco, "--iterations", 0, "--position-bits", 16)
        to_draco = smoothing_pb2.OutputOptions(
            format=smoothing_pb2.MESH_FORMAT_DRACO,
            draco=smoothing_pb2.DracoOptions(method=smoothing_pb2.DRACO_METHOD_EDGEBREAKER, position_bits=14))
        rows = [
            (self.noisy, [], "", {}),
            (self.noisy, ["--method", "taubin", "--iterations", 5, "--set", "boundary=free"],
             "method=taubin&iterations=5&boundary=free", {"method": "taubin", "iterations": 5, "boundary": "free"}),
            (self.noisy, ["--output-format", "drc", "--draco-method", "edgebreaker", "--position-bits", 14],
             "output=drc&draco_method=edgebreaker&position_bits=14", {"output": to_draco}),
            (self.draco, ["--iterations", 3], "iterations=3", {"iterations": 3}),
            (self.draco, ["--output-format", "obj"], "output=obj",
             {"output": smoothing_pb2.OutputOptions(format=smoothing_pb2.MESH_FORMAT_OBJ)}),
        ]
        for mesh, arguments, query, options in rows:
            with self.subTest(mesh=mesh.name, query=query):
                results = self.smooth_everywhere(mesh, arguments, query, options)
                self.assertNotEqual(results["local"], mesh.read_bytes())
                for name, result in results.items():
                    self.assertEqual(result, results["local"], name)

    def test_pinned_vertices_stay_whatever_the_way(self):
        lines = self.noisy.read_text().splitlines()
        vertices = [line for line in lines if line.startswith("v ")]
        chosen = set(range(40))  # white in the file, the others black
        colored = [f"{v} {' 1 1 1' if i in chosen else ' 0 0 0'}" for i, v in enumerate(vertices)]
        faces = [line for line in lines if line.startswith("f ")]
        mesh, draco = self.folder / "grouped.obj", self.folder / "grouped.drc"
        mesh.write_text("\n".join([*colored, *faces[:-9], "g rim spare", *faces[-9:], ""]))
        self.run_burnish("smooth", mesh, draco, "--iterations", 0)
        rim = {int(corner) - 1 for face in faces[-9:] for corner in face.split()[1:]}
        pinned = smoothing_pb2.PinnedVertices
        rows = [
            (mesh, ["--pin-group", "rim", "--pin", "5,900"], "pinned_group=rim&pinned_vertices=5,900",
             pinned(group="rim", vertices=[5, 900]), rim | {5, 900}),
            (draco, ["--pin-attribute", 1, "--output-format", "obj"], "pinned_attribute=1&output=obj",
             pinned(attribute="1"), chosen),
        ]
        before = [[float(x) for x in v.split()[1:4]] for v in vertices]
        for source, arguments, query, options, expected in rows:
            with self.subTest(query=query):
                to_obj = smoothing_pb2.OutputOptions(format=smoothing_pb2.MESH_FORMAT_OBJ)
                results = self.smooth_everywhere(source, arguments, query, {"pinned": options, "output": to_obj})
                for name, result in results.items():
                    self.assertEqual(result, results["local"], name)
                after = [[float(x) for x in line.split()[1:4]] for line in results["local"].decode().splitlines()
                         if line.startswith("v ")]
                moved = [max(abs(a - b) for a, b in zip(*pair)) for pair in zip(before, after, strict=True)]
                self.assertLess(max(moved[i] for i in expected), 1e-5)  # floats, in Draco
                self.assertGreater(sum(m > 1e-3 for m in moved), len(moved) / 2)
                answer = self.server.post(source, query).report
                self.assertEqual(answer["pinnedVertices"], len(expected))

    def test_same_bytes_whatever_the_threads(self):
        results = []
        for threads in 1, 2, 7:
            out = self.folder / "threads.obj"
            self.run_burnish("smooth", self.noisy, out, "--threads", threads)
            results.append(out.read_bytes())
        self.assertEqual(results[0], results[1])
        self.assertEqual(results[0], results[2])

    def test_a_reference_is_measured_against(self):
        request = smooth_request(self.noisy)
        request.reference = self.clean.read_bytes()
        report = self.server.stub().Smooth(request).report
        self.assertEqual(report.errors.against, "reference")
        done = self.run_burnish("smooth", self.noisy, self.folder / "out.obj", "--reference", self.clean, "--report", "-")
        self.assertEqual(json.loads(done.stdout)["errors"]["ev"], report.errors.ev)

    def test_the_report_header_is_compact_ascii(self):
        header = self.server.post(self.noisy).headers["burnish-report"]
        self.assertLessEqual(len(header), 3072)
        self.assertTrue(header.isascii())

    def test_methods_are_the_same_everywhere(self):
        listed = json.loads(self.run_burnish("methods", "--json").stdout)
        self.assertEqual(json.loads(self.server.curl("/v1/methods").body), listed)
        reply = self.server.stub().ListMethods(smoothing_pb2.ListMethodsRequest())
        self.assertEqual([m.name for m in reply.methods], [m["name"] for m in listed["methods"]])
        self.assertEqual(listed["methods"][0]["name"], "auto")

    def test_the_server_says_that_it_lives_and_is_ready(self):
        for path in "/livez", "/readyz":
            self.assertEqual(self.server.curl(path).status, 200, path)

    def test_smoothing_undoes_noise(self):
        noisier, out = self.folder / "noisier.obj", self.folder / "out.obj"
        self.run_burnish("noise", self.clean, noisier, "--amplitude", 0.2, "--kind", "uniform", "--direction", "random")
        self.run_burnish("smooth", noisier, out, "--server", self.server.grpc)
        ev = [json.loads(self.run_burnish("compare", self.clean, mesh, "--json").stdout)["errors"]["ev"]
              for mesh in (noisier, out)]
        self.assertLess(ev[1], 0.7 * ev[0])


if __name__ == "__main__":
    unittest.main()
