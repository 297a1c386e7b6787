"""Google's Draco for JavaScript, in three versions from npm: what an app has that sends .drc and reads the answer."""

import json
import os
import pathlib
import subprocess

VERSIONS = ("1.3", "1.4", "1.5")
METHODS = ("sequential", "edgebreaker")
SCRIPT = pathlib.Path(__file__).parents[1] / "npm" / "draco3d_mesh.cjs"


def run(node_modules, version, *arguments):
    done = subprocess.run(["node", SCRIPT, f"draco3d-{version}", *map(str, arguments)], capture_output=True, text=True,
                          env={**os.environ, "NODE_PATH": str(node_modules)}, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def encode(node_modules, version, obj, drc, method, bits=0):
    run(node_modules, version, "encode", obj, drc, method, bits)
    return pathlib.Path(drc).read_bytes()


def decode(node_modules, version, drc):
    """Positions by the number that each vertex got when it was encoded, and faces as sets of these numbers' cycles."""
    mesh = json.loads(run(node_modules, version, "decode", drc))
    points, numbers = mesh["points"], mesh["numbers"]
    positions = {number: tuple(points[3 * at:3 * at + 3]) for at, number in enumerate(numbers)}
    return positions, {in_order([numbers[point] for point in face]) for face in mesh["faces"]}


def in_order(face):
    """The same cycle, from its smallest number on."""
    first = face.index(min(face))
    return tuple(face[first:] + face[:first])


def read_obj(path):
    positions, faces = {}, set()
    for line in pathlib.Path(path).read_text().splitlines():
        kind, *words = line.split(" ")
        if kind == "v":
            positions[len(positions)] = tuple(map(float, words[:3]))
        if kind == "f":
            faces.add(in_order([int(word) - 1 for word in words]))
    return positions, faces


def largest_distance(a, b):
    """Along an axis, as a fraction of the mesh's extent."""
    assert a.keys() == b.keys()
    extent = max(max(axis) - min(axis) for axis in zip(*b.values()))
    return max(max(abs(x - y) for x, y in zip(a[key], b[key])) for key in a) / extent
