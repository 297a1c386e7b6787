"""submit_scan.py URL IN OUT: for a scanner whose network breaks. The upload goes on where it was cut, the job ends whatever
happens to this program or to the server, and asking again gives the same job. Needs Python alone."""

import base64
import hashlib
import http.client
import json
import os
import pathlib
import sys
import time
import urllib.parse

PIECE_BYTES = 8 << 20
ATTEMPTS = 10
PASSES = (429, 502, 503, 504)  # a full or restarting server


class Refused(Exception):
    """What the server says that no other attempt would change."""


class Server:
    def __init__(self, url):
        parsed = urllib.parse.urlsplit(url)
        self.kind = http.client.HTTPSConnection if parsed.scheme == "https" else http.client.HTTPConnection
        self.address = parsed.netloc
        token = os.environ.get("BURNISH_TOKEN")
        self.headers = {"Authorization": f"Bearer {token}"} if token else {}

    def once(self, verb, target, body=None, headers=None):
        connection = self.kind(self.address, timeout=90)
        try:
            connection.request(verb, target, body, {**self.headers, **(headers or {})})
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def call(self, verb, target, body=None, headers=None, also=()):
        """Tries again what passes by itself; status, headers and body."""
        for attempt in range(ATTEMPTS):
            try:
                status, answer_headers, answer = self.once(verb, target, body, headers)
            except (OSError, http.client.HTTPException) as error:
                status, answer_headers, answer = 503, {}, json.dumps({"code": "unreachable", "detail": str(error)}).encode()
            if status < 400 or status in also:
                return status, answer_headers, answer
            if status not in PASSES:
                break
            time.sleep(float(answer_headers.get("Retry-After", min(0.2 * 2 ** attempt, 10))))
        problem = json.loads(answer or b"{}")
        raise Refused(f"{problem.get('code', status)}: {problem.get('detail', '')}")


def upload(server, mesh):
    """The SHA-256 by which jobs name the mesh, and the replica that has it: empty where there is one server."""
    digest = hashlib.sha256(mesh)
    announced = {"Upload-Length": str(len(mesh)), "Upload-Complete": "?0",
                 "Repr-Digest": f"sha-256=:{base64.b64encode(digest.digest()).decode()}:"}
    _, headers, body = server.call("POST", "/v1/uploads", headers=announced)
    place, have = headers["Location"], json.loads(body)
    while not have.get("complete"):
        offset = int(have["offset"])
        status, _, body = server.call("PATCH", place, mesh[offset:offset + PIECE_BYTES],
                                      {"Content-Type": "application/partial-upload", "Upload-Offset": str(offset)}, also=(409,))
        if status == 409:  # the server has other bytes than we think: a piece came whose answer was lost
            _, _, body = server.call("GET", place)
        have = json.loads(body)
        print(f"uploaded {have['offset']} of {len(mesh)} bytes", file=sys.stderr)
    return digest.hexdigest(), have["id"].rpartition("-")[0]


def main(url, scan, out):
    server, mesh = Server(url), pathlib.Path(scan).read_bytes()
    try:
        sha256, replica = upload(server, mesh)
        _, _, body = server.call("POST", f"/v1/jobs?mesh_sha256={sha256}",
                                 headers={"Idempotency-Key": sha256, "Burnish-Replica": replica})
        job = json.loads(body)
        while job["state"] in ("JOB_STATE_QUEUED", "JOB_STATE_RUNNING"):
            _, _, body = server.call("GET", f"/v1/jobs/{job['id']}", headers={"Prefer": "wait=30"})
            job = json.loads(body)
        if job["state"] != "JOB_STATE_SUCCEEDED":
            raise Refused(f"{job['error']['code']}: {job['error']['message']}")
        _, _, result = server.call("GET", f"/v1/jobs/{job['id']}/mesh")
    except Refused as error:
        sys.exit(str(error))
    pathlib.Path(out).write_bytes(result)
    report = job["report"]
    print(f"{report['method']}: {report['input']['triangles']} triangles with noise of {report['noise']['sigmaOverEdge']:.3g} mean "
          f"edges, moved by {report['change']['maxDisplacement']:.3g} at most, in {report['timings']['totalMs']:.1f} ms")


if __name__ == "__main__":
    main(*sys.argv[1:])
