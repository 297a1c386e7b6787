"""glTF binary through every transport: what comes back differs in positions, normals and bounds alone, and is valid."""

import json
import pathlib
import struct
import subprocess
import unittest

from burnish.v1 import smoothing_pb2
from programs import ENVIRONMENT, NODE_MODULES, PATIENCE_SECONDS, MeshTest, Server, burnish, needs_npm, smooth_request

VALIDATE = pathlib.Path(__file__).parent.parent / "npm" / "validate_glb.cjs"
PICTURE = bytes.fromhex("89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c4944415408d763f8ffff3f0005fe"
                        "02fe0def46b80000000049454e44ae426082")


def split(data):
    """The JSON as bytes, and the BIN chunk."""
    magic, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    size_of_bin, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    return data[20:20 + size], data[28 + size:28 + size + size_of_bin]


def joined(text, binary):
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    return struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(binary), len(text), b"JSON") + text + struct.pack(
        "<I4s", len(binary), b"BIN\0") + binary


class Glb(MeshTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = Server().__enter__()
        cls.addClassCleanup(cls.server.__exit__, None, None, None)
        cls.glb = cls.textured()

    @classmethod
    def textured(cls):
        """The noisy sample as a GLB of our own, to which a material, a picture, extras and an unknown extension come."""
        plain, whole = cls.folder / "plain.glb", cls.folder / "whole.glb"
        faces = [line for line in cls.noisy.read_text().splitlines() if line.startswith("f ")]
        vertices = [line for line in cls.noisy.read_text().splitlines() if line.startswith("v ")]
        corners = [[corner.split("/")[0] for corner in face.split()[1:]] for face in faces]
        obj = cls.folder / "textured.obj"
        obj.write_text("\n".join([*vertices, *(f"vt {i / len(vertices)} 0.5" for i in range(len(vertices))), *(["vn 0 0 1"] * len(vertices)),
                                  *("f " + " ".join(f"{c}/{c}/{c}" for c in face) for face in corners), ""]))
        cls.smooth(obj, plain, "--iterations", 0)
        text, binary = split(plain.read_bytes())
        tree = json.loads(text)
        tree["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(PICTURE)})
        tree["buffers"][0]["byteLength"] = len(binary) + len(PICTURE)
        tree["images"] = [{"bufferView": len(tree["bufferViews"]) - 1, "mimeType": "image/png"}]
        tree["textures"] = [{"source": 0}]
        tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extras": {"kept": [1.50, None]}}]
        tree["meshes"][0]["primitives"][0]["material"] = 0
        tree["extensionsUsed"] = ["ACME_unheard_of"]
        tree["extensions"] = {"ACME_unheard_of": {"n": 1e-7}}
        whole.write_bytes(joined(json.dumps(tree, indent=1).encode(), binary + PICTURE))
        return whole

    @classmethod
    def smooth(cls, mesh, out, *flags):
        done = burnish("smooth", mesh, out, *flags)
        assert done.returncode == 0, done.stderr
        return out.read_bytes()

    def everywhere(self, mesh, flags, query, **options):
        out = self.folder / "out.glb"
        results = {"local": self.smooth(mesh, out, *flags),
                   "grpc": self.smooth(mesh, out, *flags, "--server", self.server.grpc)}
        answer = self.server.post(mesh, query)
        self.assertEqual(answer.status, 200, answer.body[:300])
        self.assertEqual(answer.report["encoding"]["format"], "MESH_FORMAT_GLB")
        results["http"] = answer.body
        results["python"] = self.server.stub().Smooth(smooth_request(mesh, **options)).mesh
        for name, result in results.items():
            self.assertEqual(result, results["local"], name)
        return results["local"]

    def test_only_positions_normals_and_bounds_change_whatever_the_way(self):
        result = self.everywhere(self.glb, ["--iterations", 3], "iterations=3", iterations=3)
        before, after = split(self.glb.read_bytes()), split(result)
        trees = [json.loads(text) for text, _ in (before, after)]
        attributes = trees[0]["meshes"][0]["primitives"][0]["attributes"]
        bounds = [tree["accessors"][attributes["POSITION"]] for tree in trees]
        self.assertNotEqual(bounds[0], bounds[1])
        for bound in bounds:
            bound.pop("min"), bound.pop("max")
        self.assertEqual(*trees)
        views = [trees[0]["bufferViews"][trees[0]["accessors"][attributes[name]]["bufferView"]] for name in ("POSITION", "NORMAL")]
        for view in views:
            begin, end = view["byteOffset"], view["byteOffset"] + view["byteLength"]
            self.assertNotEqual(before[1][begin:end], after[1][begin:end])
        masked = []
        for _, binary in before, after:
            binary = bytearray(binary)
            for view in views:
                binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]] = bytes(view["byteLength"])
            masked.append(bytes(binary))
        self.assertEqual(*masked)

    def test_other_formats_become_glb_whatever_the_way(self):
        output = smoothing_pb2.OutputOptions(format=smoothing_pb2.MESH_FORMAT_GLB)
        result = self.everywhere(self.noisy, ["--output-format", "glb"], "output=glb", output=output)
        tree = json.loads(split(result)[0])
        vertices = sum(line.startswith("v ") for line in self.noisy.read_text().splitlines())
        self.assertEqual(tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["count"], vertices)

    def test_counts_without_data_are_refused_by_their_place_or_at_the_door(self):
        text, binary = split(self.glb.read_bytes())
        tree = json.loads(text)
        bad = self.folder / "bad.glb"
        for count, status, code, says in ((100_000, 422, "malformed_mesh", "has 100000 rows, which end at byte 1200000"),
                                          (10**9, 413, "too_large", "")):
            tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["count"] = count
            bad.write_bytes(joined(json.dumps(tree).encode(), binary))
            answer = self.server.post(bad)
            self.assertEqual((answer.status, answer.problem["code"]), (status, code))
            self.assertIn(says, answer.problem["detail"])

    @needs_npm
    def test_what_was_valid_stays_valid(self):
        smooth, made, drc = (self.folder / name for name in ("smooth.glb", "made.glb", "back.glb"))
        self.smooth(self.glb, smooth, "--iterations", 3)
        self.smooth(self.noisy, made)
        self.smooth(made, drc, "--iterations", 1)
        done = subprocess.run(["node", VALIDATE, self.glb, smooth, made, drc], capture_output=True, text=True,
                              env={**ENVIRONMENT, "NODE_PATH": NODE_MODULES}, timeout=PATIENCE_SECONDS)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        # And the validator sees what we could do wrong.
        text, binary = split(smooth.read_bytes())
        tree = json.loads(text)
        for accessor in tree["accessors"]:
            if "max" in accessor:
                accessor["max"][0] += 1
        smooth.write_bytes(joined(json.dumps(tree).encode(), binary))
        done = subprocess.run(["node", VALIDATE, smooth], capture_output=True, text=True,
                              env={**ENVIRONMENT, "NODE_PATH": NODE_MODULES}, timeout=PATIENCE_SECONDS)
        self.assertEqual(done.returncode, 1)
        self.assertIn("ACCESSOR_MAX_MISMATCH", done.stdout)


if __name__ == "__main__":
    unittest.main()
