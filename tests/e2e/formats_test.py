"""PLY, STL and OFF, and GLB made of them, on every way: the same bytes, and nothing changed that smoothing does not own."""

import hashlib
import json
import struct
import unittest

import grpc
from burnish.v1 import smoothing_pb2
from programs import MeshTest, Server, eventually, smooth_request

FORMATS = {"obj": ("model/obj", smoothing_pb2.MESH_FORMAT_OBJ), "ply": ("model/ply", smoothing_pb2.MESH_FORMAT_PLY),
           "stl": ("model/stl", smoothing_pb2.MESH_FORMAT_STL), "off": ("model/off", smoothing_pb2.MESH_FORMAT_OFF),
           "glb": ("model/gltf-binary", smoothing_pb2.MESH_FORMAT_GLB)}
METHOD = ["--method", "taubin", "--iterations", 3]


def read_obj(path):
    rows = [line.split() for line in path.read_text().splitlines()]
    vertices = [tuple(map(float, row[1:4])) for row in rows if row and row[0] == "v"]
    faces = [tuple(int(corner) - 1 for corner in row[1:]) for row in rows if row and row[0] == "f"]
    return vertices, faces


def text_ply(vertices, faces):
    """With colours, a quality, and an element that nobody knows."""
    head = ["ply", "format ascii 1.0", "comment by a scanner", f"element vertex {len(vertices)}",
            *(f"property double {axis}" for axis in "xyz"), *(f"property uchar {c}" for c in ("red", "green", "blue")),
            "property float quality", f"element face {len(faces)}", "property list uchar int vertex_indices",
            "element station 1", "property float height", "end_header"]
    rows = [f"{x} {y} {z} {i % 256} 0 255 0.{i}" for i, (x, y, z) in enumerate(vertices)]
    return "\n".join([*head, *rows, *(f"3 {a} {b} {c}" for a, b, c in faces), "1.75", ""]).encode()


def big_endian_ply(vertices, faces):
    head = ["ply", "format binary_big_endian 1.0", f"element vertex {len(vertices)}", *(f"property float {a}" for a in "xyz"),
            "property ushort part", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = [struct.pack(">3fH", *v, i % 65536) for i, v in enumerate(vertices)]
    return "\n".join(head).encode() + b"".join(rows) + b"".join(struct.pack(">B3i", 3, *f) for f in faces)


def text_stl(vertices, faces):
    lines = ["solid part"]
    for face in faces:
        lines += ["facet normal 0 0 1", " outer loop", *("  vertex {} {} {}".format(*vertices[v]) for v in face), " endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""]).encode()


def binary_stl(vertices, faces):
    facets = [struct.pack("<12fH", 0, 0, 1, *(x for v in face for x in vertices[v]), i % 65536) for i, face in enumerate(faces)]
    return b"solid by a scanner".ljust(80) + struct.pack("<I", len(faces)) + b"".join(facets)


def off(vertices, faces):
    rows = [f"{x} {y} {z} 255 {i % 256} 0 255" for i, (x, y, z) in enumerate(vertices)]
    return "\n".join(["# by a scanner", "COFF", f"{len(vertices)} {len(faces)} 0", *rows, *(f"3 {a} {b} {c} 1 0 0" for a, b, c in faces), ""]).encode()


class Formats(MeshTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        server = Server("--max-unary-bytes", "64MiB")
        cls.server = server.__enter__()
        cls.addClassCleanup(server.__exit__, None, None, None)
        cls.vertices, cls.faces = read_obj(cls.noisy)
        cls.meshes = {}
        for name, make in {"text.ply": text_ply, "big_endian.ply": big_endian_ply, "text.stl": text_stl,
                           "binary.stl": binary_stl, "colours.off": off}.items():
            cls.meshes[name] = cls.folder / name
            cls.meshes[name].write_bytes(make(cls.vertices, cls.faces))

    def stream(self, mesh, output):
        """SmoothStream in chunks of odd sizes."""
        def requests():
            start = smoothing_pb2.SmoothStart()
            start.options.method, start.options.iterations = "taubin", 3
            start.options.output.format = output
            yield smoothing_pb2.SmoothStreamRequest(start=start)
            data = mesh.read_bytes()
            for at in range(0, len(data), 100_003):
                yield smoothing_pb2.SmoothStreamRequest(mesh_chunk=data[at:at + 100_003])
        return b"".join(reply.mesh_chunk for reply in self.server.stub().SmoothStream(requests()))

    def by_job(self, target, *flags):
        job = self.server.curl(target, *flags).headers["location"]
        eventually(lambda: json.loads(self.server.curl(job).body)["state"] == "JOB_STATE_SUCCEEDED", "the job ends")
        return self.server.curl(job + "/mesh")

    def everywhere(self, mesh, name, ending):
        media, output = FORMATS[ending]
        query = f"method=taubin&iterations=3&output={ending}"
        results = {}
        for way, flags in ("local", []), ("command line", ["--server", self.server.grpc]):
            out = self.folder / f"out-{way}.{ending}"
            self.run_burnish("smooth", mesh, out, *METHOD, *flags)
            results[way] = out.read_bytes()
        options = smoothing_pb2.OutputOptions(format=output)
        reply = self.server.stub().Smooth(smooth_request(mesh, method="taubin", iterations=3, output=options))
        self.assertEqual(reply.format, output)
        results["unary"], results["stream"] = reply.mesh, self.stream(mesh, output)
        answer = self.server.post(mesh, query)
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, media))
        results["body"] = answer.body
        own = FORMATS[mesh.suffix[1:]][0]
        form = self.server.curl("/v1/smooth", "-F", f"mesh=@{mesh};type={own}", "-F",
                                f'options={{"method": "taubin", "iterations": 3, "output": {{"format": "{ending}"}}}}')
        self.assertEqual(form.status, 200, form.body[:300])
        results["form"] = form.body
        kept = self.by_job("/v1/jobs?" + query, "--data-binary", f"@{mesh}")
        self.assertEqual(kept.headers["content-type"], media)
        results["job"] = kept.body
        return results

    def test_every_format_on_every_way_gives_the_same_bytes(self):
        for name, mesh in self.meshes.items():
            for ending in sorted({mesh.suffix[1:], "glb"}):
                with self.subTest(mesh=name, to=ending):
                    results = self.everywhere(mesh, name, ending)
                    self.assertNotEqual(results["local"], mesh.read_bytes())
                    for way, result in results.items():
                        self.assertEqual(result, results["local"], way)

    def test_an_upload_in_pieces_is_smoothed_like_the_file(self):
        mesh = self.meshes["big_endian.ply"]
        data = mesh.read_bytes()
        upload = self.server.curl("/v1/uploads", "-X", "POST", "-H", f"Upload-Length: {len(data)}",
                                  "-H", "Upload-Complete: ?0").headers["location"]
        for at in range(0, len(data), 200_000):
            piece = self.folder / "piece"
            piece.write_bytes(data[at:at + 200_000])
            last = int(at + 200_000 >= len(data))
            answer = self.server.curl(upload, "-X", "PATCH", "-H", f"Upload-Offset: {at}", "-H", f"Upload-Complete: ?{last}", "-H",
                                      "Content-Type: application/partial-upload", "--data-binary", f"@{piece}")
            self.assertLess(answer.status, 300, answer.body)
        digest = hashlib.sha256(data).hexdigest()
        kept = self.by_job(f"/v1/jobs?mesh_sha256={digest}&method=taubin&iterations=3", "-X", "POST")
        self.assertEqual(kept.body, self.server.post(mesh, "method=taubin&iterations=3").body)

    def test_what_smoothing_does_not_own_comes_back(self):
        written = {}
        for name, mesh in self.meshes.items():
            out = self.folder / f"smooth-{name}"
            self.run_burnish("smooth", mesh, out, *METHOD)
            written[name] = out.read_bytes()
        was, now = self.meshes["text.ply"].read_text().splitlines(), written["text.ply"].decode().splitlines()
        first = was.index("end_header") + 1
        for i, (a, b) in enumerate(zip(was, now, strict=True)):
            vertex = first <= i < first + len(self.vertices)
            self.assertEqual(a.split()[3:] if vertex else a, b.split()[3:] if vertex else b)
        was, now = self.meshes["binary.stl"].read_bytes(), written["binary.stl"]
        self.assertEqual(was[:84], now[:84])
        self.assertEqual([was[i:i + 2] for i in range(132, len(was), 50)], [now[i:i + 2] for i in range(132, len(now), 50)])
        was, now = self.meshes["colours.off"].read_text().splitlines(), written["colours.off"].decode().splitlines()
        for i, (a, b) in enumerate(zip(was, now, strict=True)):
            vertex = 3 <= i < 3 + len(self.vertices)
            self.assertEqual(a.split()[3:] if vertex else a, b.split()[3:] if vertex else b)
        # All formats move the vertices alike: to the last digit that each can hold.
        self.run_burnish("smooth", self.noisy, self.folder / "smooth.obj", *METHOD)
        report = self.run_burnish("compare", self.folder / "smooth.obj", self.folder / "smooth-binary.stl", "--json").stdout
        self.assertLess(json.loads(report)["errors"]["maxDistance"], 1e-4)

    def test_errors_name_the_place_on_every_way(self):
        broken = self.folder / "broken.ply"
        broken.write_bytes(self.meshes["text.ply"].read_bytes().replace(b"\n3 ", b"\n3 99999999 ", 1))
        sentence = "face 0 uses vertex 99999999 of"
        done = self.run_burnish("smooth", broken, self.folder / "none.ply", code=3)
        self.assertIn(sentence, done.stderr)
        answer = self.server.post(broken)
        self.assertEqual((answer.status, answer.problem["code"]), (422, "index_out_of_range"))
        self.assertIn(sentence, answer.problem["detail"])
        with self.assertRaises(grpc.RpcError) as failed:
            self.server.stub().Smooth(smooth_request(broken))
        self.assertIn(sentence, failed.exception.details())


if __name__ == "__main__":
    unittest.main()
