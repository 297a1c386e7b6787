"""smooth_scan.py ADDRESS IN OUT: smooths a scan of any size over gRPC, and tells how far it is and what was done."""

import os
import pathlib
import sys

import grpc
from burnish.v1 import smoothing_pb2, smoothing_pb2_grpc

CHUNK_BYTES = 512 * 1024
DEADLINE_SECONDS = 120


def parts(mesh):
    """The start, with the size, so that a scan which does not fit is refused before it is sent; then the bytes."""
    yield smoothing_pb2.SmoothStreamRequest(start=smoothing_pb2.SmoothStart(mesh_bytes=len(mesh)))
    for at in range(0, len(mesh), CHUNK_BYTES):
        yield smoothing_pb2.SmoothStreamRequest(mesh_chunk=mesh[at:at + CHUNK_BYTES])


def smooth(stub, mesh, metadata):
    result, report = bytearray(), None
    for answer in stub.SmoothStream(parts(mesh), timeout=DEADLINE_SECONDS, metadata=metadata):
        kind = answer.WhichOneof("part")
        if kind == "progress":
            stage = smoothing_pb2.SmoothStage.Name(answer.progress.stage)
            print(f"{stage} {100 * answer.progress.fraction:.0f} %", file=sys.stderr)
        elif kind == "mesh_chunk":
            result += answer.mesh_chunk
        else:
            report = answer.report
    return bytes(result), report


def main(address, scan, out):
    token = os.environ.get("BURNISH_TOKEN")
    metadata = [("authorization", f"Bearer {token}")] if token else []
    with grpc.insecure_channel(address) as channel:
        stub = smoothing_pb2_grpc.SmoothingServiceStub(channel)
        try:
            mesh, report = smooth(stub, pathlib.Path(scan).read_bytes(), metadata)
        except grpc.RpcError as error:
            sys.exit(f"{error.code().name}: {error.details()}")
    pathlib.Path(out).write_bytes(mesh)
    print(f"{report.method}: {report.input.triangles} triangles with noise of {report.noise.sigma_over_edge:.3g} mean edges, "
          f"moved by {report.change.max_displacement:.3g} at most, in {report.timings.total_ms:.1f} ms")


if __name__ == "__main__":
    main(*sys.argv[1:])
