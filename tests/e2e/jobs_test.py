"""Jobs and uploads over both transports, across the ends of the server."""

import hashlib
import json
import os
import random
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from http.client import HTTPConnection, HTTPException

import grpc
from burnish.v1 import jobs_pb2, jobs_pb2_grpc, smoothing_pb2

from programs import BURNISH, ENVIRONMENT, PATIENCE_SECONDS, MeshTest, Server, eventually

LONG = bool(os.environ.get("BURNISH_LONG"))
ENDED = ("JOB_STATE_SUCCEEDED", "JOB_STATE_FAILED", "JOB_STATE_CANCELLED")


class Caller:
    """One HTTP connection at a time; None where the server is not there."""

    def __init__(self, server):
        self.address = server.http

    def call(self, verb, target, body=None, headers=None):
        connection = HTTPConnection(self.address, timeout=PATIENCE_SECONDS)
        try:
            connection.request(verb, target, body, headers or {})
            answer = connection.getresponse()
            return answer.status, answer.read()
        except (OSError, HTTPException):
            return None, b""
        finally:
            connection.close()

    def job(self, identity):
        status, body = self.call("GET", f"/v1/jobs/{identity}", headers={"Prefer": "wait=30"})
        return json.loads(body) if status == 200 else None

    def ended(self, identity):
        return eventually(lambda: (lambda job: job and job["state"] in ENDED and job)(self.job(identity)),
                          f"job {identity} ends")


class Jobs(MeshTest):
    def test_both_transports_see_the_same_job_and_the_same_bytes(self):
        with Server() as server:
            channel = grpc.insecure_channel(server.grpc, options=[("grpc.enable_http_proxy", 0)])
            stub, caller = jobs_pb2_grpc.JobServiceStub(channel), Caller(server)
            mesh = self.noisy.read_bytes()
            job = stub.SubmitJob(jobs_pb2.SubmitJobRequest(
                mesh=mesh, options=smoothing_pb2.SmoothOptions(method="taubin")))
            states = [jobs_pb2.JobState.Name(each.state) for each in stub.WatchJob(jobs_pb2.WatchJobRequest(id=job.id))]
            self.assertEqual(states[-1], "JOB_STATE_SUCCEEDED")
            self.assertEqual(caller.ended(job.id)["result"]["sha256"], hashlib.sha256(
                server.post(self.noisy, "method=taubin").body).hexdigest())
            parts = list(stub.DownloadResult(jobs_pb2.DownloadResultRequest(id=job.id)))
            self.assertEqual(b"".join(part.chunk for part in parts), caller.call("GET", f"/v1/jobs/{job.id}/mesh")[1])
            again = stub.SubmitJob(jobs_pb2.SubmitJobRequest(
                mesh_sha256=job.mesh.sha256, options=smoothing_pb2.SmoothOptions(method="taubin")))
            self.assertTrue(again.from_cache)
            channel.close()

    def test_a_drain_keeps_what_has_not_ended(self):
        with tempfile.TemporaryDirectory() as store:
            with Server("--workers", 1, "--grace-seconds", 0, store=store) as server:
                caller = Caller(server)
                ids = []
                for iterations in (100000, 1, 2):
                    status, body = caller.call("POST", f"/v1/jobs?method=laplacian&iterations={iterations}",
                                               self.noisy.read_bytes())
                    self.assertEqual(status, 202)
                    ids.append(json.loads(body)["id"])
                eventually(lambda: json.loads(caller.call("GET", f"/v1/jobs/{ids[0]}")[1])["state"] ==
                           "JOB_STATE_RUNNING", "the first runs")
            with Server(store=store) as server:
                caller = Caller(server)
                self.assertEqual([caller.ended(each)["state"] for each in ids[1:]], ["JOB_STATE_SUCCEEDED"] * 2)
                self.assertEqual(caller.call("DELETE", f"/v1/jobs/{ids[0]}")[0], 202)

    def test_the_callers_trace_is_in_every_line_of_its_log(self):
        def parent(trace):
            return f"00-{trace}-00f067aa0ba902b7-01"

        kept, direct = "4bf92f3577b34da6a3ce929d0e0e4736", "0af7651916cd43dd8448eb211c80319c"
        with Server() as server:
            caller = Caller(server)
            status, body = caller.call("POST", "/v1/jobs?method=laplacian", self.noisy.read_bytes(),
                                       {"traceparent": parent(kept)})
            self.assertEqual(status, 202)
            identity = caller.ended(json.loads(body)["id"])["id"]
            subprocess.run([BURNISH, "smooth", str(self.noisy), str(self.folder / "traced.obj"), "--server", server.grpc],
                           env={**ENVIRONMENT, "TRACEPARENT": parent(direct)}, check=True, capture_output=True)
            log = server.log_text()
            self.assertRegex(log, rf"request id={identity} trace={kept} ")
            self.assertRegex(log, rf"trace={direct} transport=grpc")

    def test_ids_begin_with_the_replica_that_keeps_them(self):
        with Server("--replica", "scans-2") as server:
            caller = Caller(server)
            job = json.loads(caller.call("POST", "/v1/jobs", self.noisy.read_bytes())[1])["id"]
            upload = json.loads(caller.call("POST", "/v1/uploads")[1])["id"]
            for identity in job, upload:
                self.assertRegex(identity, "^scans-2-[0-9a-f]{32}$")
            self.assertEqual(caller.ended(job)["id"], job)
            self.assertEqual(caller.call("GET", f"/v1/uploads/{upload}")[0], 200)

    def test_one_folder_serves_one_server(self):
        with tempfile.TemporaryDirectory() as store, Server(store=store):
            with self.assertRaisesRegex(AssertionError, "another server uses it"):
                Server(store=store)

    def test_an_upload_cut_again_and_again_arrives_whole(self):
        size = (1 << 30) if LONG else (48 << 20)
        block = random.Random(7).randbytes(1 << 20)
        with Server("--max-bytes", "2GiB") as server:
            idle = server.metric("process_resident_memory_bytes")
            upload = server.curl("/v1/uploads", "-X", "POST", "-H", f"Upload-Length: {size}").headers["location"]
            whole, cuts, most = hashlib.sha256(), 0, 0
            for _ in range(size >> 20):
                whole.update(block)
            while True:
                offset = int(server.curl(upload, "--head").headers["upload-offset"])
                if offset == size:
                    break
                most = max(most, server.metric("process_resident_memory_bytes"))
                # 20 cuts; the last piece comes whole.
                until = size if cuts == 20 else min(size, offset + size // 20)
                host, port = server.http.rsplit(":", 1)
                with socket.create_connection((host, int(port)), PATIENCE_SECONDS) as connection:
                    head = (f"PATCH {upload} HTTP/1.1\r\nHost: x\r\nContent-Type: application/partial-upload\r\n"
                            f"Upload-Offset: {offset}\r\nContent-Length: {size - offset}\r\n\r\n")
                    connection.sendall(head.encode())
                    while offset < until:
                        piece = block[offset % len(block):][:until - offset]
                        connection.sendall(piece)
                        offset += len(piece)
                    if until == size:
                        self.assertIn(b"200 OK", connection.recv(100))
                cuts += until < size
                eventually(lambda: self.is_free(server, upload), "the server sees the cut")
            done = json.loads(server.curl(upload).body)
            self.assertEqual((done["complete"], done["sha256"]), (True, whole.hexdigest()))
            self.assertGreaterEqual(cuts, 19)
            self.assertLess(most - idle, 600e6 - idle)

    @staticmethod
    def is_free(server, upload):
        """Nobody appends any more: an append at a wrong offset hears of the offset, not of another append."""
        answer = server.curl(upload, "-X", "PATCH", "-H", "Content-Type: application/partial-upload", "-H",
                             "Upload-Offset: 4000000000", "--data-binary", "x")
        return answer.problem["code"] == "upload_offset_mismatch"


class Crashes(MeshTest):
    """Kills the server at random instants while callers submit, upload, cancel and fetch."""

    KILLS = 200 if LONG else 12
    SECONDS_BETWEEN = (0.02, 0.35)

    def setUp(self):
        self.accepted, self.uploaded, self.lock, self.stop = {}, {}, threading.Lock(), False
        self.current = None

    def submit(self, rng, number):
        """Hands over a job until somebody takes it; its key makes that safe."""
        iterations = rng.randrange(1, 40)
        key = f"job-{number}"
        while not self.stop:
            server = self.current
            status, body = Caller(server).call(
                "POST", f"/v1/jobs?method=laplacian&iterations={iterations}&max_displacement={number + 1000}",
                self.noisy.read_bytes(), {"Idempotency-Key": key}) if server else (None, b"")
            if status == 202:
                identity = json.loads(body)["id"]
                with self.lock:
                    known = self.accepted.setdefault(key, (identity, iterations))
                self.assertEqual(known[0], identity, "one key, one job")
                return identity
            time.sleep(0.005)
        return None

    def callers(self, seed):
        rng, number = random.Random(seed), seed * 100000
        while not self.stop:
            identity = self.submit(rng, number)
            number += 1
            server = self.current
            if not identity or not server:
                continue
            caller = Caller(server)
            choice = rng.random()
            if choice < 0.1:
                caller.call("GET", "/v1/jobs")
            elif choice < 0.3:
                caller.call("GET", f"/v1/jobs/{identity}/mesh")
            elif choice < 0.4:
                caller.call("POST", "/v1/uploads", rng.randbytes(200000))

    def test_no_accepted_job_is_lost_and_none_ends_twice(self):
        rng = random.Random(42)
        with tempfile.TemporaryDirectory() as store:
            threads = [threading.Thread(target=self.callers, args=(seed,)) for seed in range(4)]
            seen = {}
            for thread in threads:
                thread.start()
            try:
                for _ in range(self.KILLS):
                    self.current = server = Server("--workers", 2, "--log-level", "error", store=store)
                    time.sleep(rng.uniform(*self.SECONDS_BETWEEN))
                    self.note_ends(Caller(server), seen, rng)
                    self.current = None
                    server.kill()
            finally:
                self.stop = True
                for thread in threads:
                    thread.join()
            self.check_ends(store, seen)

    def note_ends(self, caller, seen, rng):
        """An end that a caller has seen must be the one that stays."""
        with self.lock:
            known = list(self.accepted.values())
        for identity, _ in rng.sample(known, min(5, len(known))):
            status, body = caller.call("GET", f"/v1/jobs/{identity}")
            if status == 200 and (job := json.loads(body))["state"] in ENDED:
                end = (job["state"], job["endTime"], job["result"]["sha256"])
                self.assertEqual(seen.setdefault(identity, end), end)

    def check_ends(self, store, seen):
        self.assertGreater(len(self.accepted), self.KILLS)
        expected = {}
        with Server(store=store) as server:
            caller = Caller(server)
            for key, (identity, iterations) in self.accepted.items():
                job = caller.ended(identity)
                self.assertEqual(job["state"], "JOB_STATE_SUCCEEDED", job)
                end = (job["state"], job["endTime"], job["result"]["sha256"])
                self.assertEqual(seen.get(identity, end), end)
                if iterations not in expected:
                    expected[iterations] = server.post(
                        self.noisy, f"method=laplacian&iterations={iterations}&max_displacement=1000").body
                self.assertEqual(caller.call("GET", f"/v1/jobs/{identity}/mesh")[1], expected[iterations])
            listed, token = 0, ""
            while True:
                page = json.loads(caller.call("GET", f"/v1/jobs?page_size=1000&page_token={token}")[1])
                listed += len(page["jobs"])
                token = page["nextPageToken"]
                if not token:
                    break
            # A job whose 202 never arrived may be there beside the accepted ones, each once.
            self.assertGreaterEqual(listed, len(self.accepted))
            self.assertLessEqual(listed, len(self.accepted) + 4)
            print(f"{self.KILLS} kills, {len(self.accepted)} accepted jobs, {listed} kept", flush=True)


if __name__ == "__main__":
    unittest.main()
