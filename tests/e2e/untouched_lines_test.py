"""Every line of an OBJ that is not a moved `v` or a recomputed `vn` comes back byte for byte and in place."""

import math
import unittest

from programs import MeshTest, Server

SIDE = 12  # quads per side


def height(i, j):
    """A wave with a ripple that smoothing removes."""
    return math.sin(i / 3) + 0.1 * (-1) ** (i + j)


def feature_rich_obj():
    """An open sheet of quads, triangles and a pentagon with all that an OBJ file may carry."""
    lines = ["# a scan \u00e9", "mtllib scan materials.mtl", "", "o sheet\t", "  # indented comment"]
    for j in range(SIDE + 1):
        for i in range(SIDE + 1):
            colour = f" 0.5 {i / SIDE:g} 1.0" if j % 2 else ""
            lines.append(f"v   {i:d} {height(i, j):.5f}  {j}.000{colour} ")
        lines.append(f"# end of row {j}")
    lines += [f"vt {i / SIDE:.3f} {j / SIDE:.3f}" for j in range(SIDE + 1) for i in range(SIDE + 1)]
    lines += ["vn 0 1 0"] * ((SIDE + 1) ** 2) + ["vn 0.6 0.8 0.0"]  # the last one is cited by no face
    lines += ["s 1", "usemtl brushed steel", "g left upper"]
    at = lambda i, j: 1 + j * (SIDE + 1) + i
    for j in range(SIDE):
        for i in range(SIDE):
            ring = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]
            if i == SIDE // 2 and j % 3 == 0:
                lines += [f"g right_{j}", "usemtl paint", "s off"]
            if (i + j) % 5 == 0:
                lines.append("f " + " ".join(f"{v}/{v}/{v}" for v in ring[:3]))
                lines.append("f " + " ".join(f"{v}//{v}" for v in (ring[0], ring[2], ring[3])))
            elif (i + j) % 5 == 1:
                total = (SIDE + 1) ** 2
                lines.append("f " + " ".join(f"{v - total - 1}/{v}" for v in ring))
            else:
                lines.append("f  " + "  ".join(f"{v}/{v}/{v}" for v in ring) + " # a quad")
    lines += ["l 1 2 3", "p 4", "vp 0.1 0.2", "#", "# the end without a newline"]
    return "\n".join(lines)


class UntouchedLines(MeshTest):
    def compare(self, before, after):
        """Returns the numbers of the `v` and `vn` lines that changed; fails on any other change."""
        old, new = before.split(b"\n"), after.split(b"\n")
        self.assertEqual(len(old), len(new))
        moved, turned = [], []
        for number, (a, b) in enumerate(zip(old, new)):
            if a == b:
                continue
            words, new_words = a.split(), b.split()
            self.assertIn(words[0], (b"v", b"vn"), f"line {number + 1}: {a} became {b}")
            self.assertEqual(words[0], new_words[0], f"line {number + 1}")
            self.assertEqual(words[4:], new_words[4:], f"line {number + 1}: {a} became {b}")
            self.assertEqual(a.endswith(b"\r"), b.endswith(b"\r"), f"line {number + 1}")
            (moved if words[0] == b"v" else turned).append(number)
        return moved, turned

    def test_only_moved_vertices_and_cited_normals_change(self):
        texts = {"lf": feature_rich_obj(), "crlf": feature_rich_obj().replace("\n", "\r\n")}
        with Server() as server:
            for name, text in texts.items():
                with self.subTest(name):
                    mesh, out = self.folder / f"{name}.obj", self.folder / f"{name}.out.obj"
                    mesh.write_bytes(text.encode())
                    self.run_burnish("smooth", mesh, out)
                    moved, turned = self.compare(mesh.read_bytes(), out.read_bytes())
                    self.assertEqual(len(moved), (SIDE - 1) ** 2)  # all but the fixed boundary
                    self.assertGreaterEqual(len(turned), len(moved))
                    self.assertIn("vn 0.6 0.8 0.0", out.read_text())
                    self.assertEqual(server.post(mesh).body, out.read_bytes())

    def test_nothing_changes_in_no_iterations(self):
        mesh, out = self.folder / "still.obj", self.folder / "still.out.obj"
        mesh.write_bytes(feature_rich_obj().encode())
        self.run_burnish("smooth", mesh, out, "--iterations", 0)
        self.assertEqual(mesh.read_bytes(), out.read_bytes())

    def test_noise_keeps_lines_too(self):
        mesh, out = self.folder / "calm.obj", self.folder / "calm.out.obj"
        mesh.write_bytes(feature_rich_obj().encode())
        self.run_burnish("noise", mesh, out, "--amplitude", 0.1)
        moved, _ = self.compare(mesh.read_bytes(), out.read_bytes())
        self.assertEqual(len(moved), (SIDE + 1) ** 2)


if __name__ == "__main__":
    unittest.main()
