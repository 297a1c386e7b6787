"""The server under load, when it is told to stop, and when its clients vanish."""

import concurrent.futures
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import unittest.mock

import grpc

from programs import BURNISHD, ENVIRONMENT, MeshTest, Server, error_info, eventually, smooth_request, start_burnish

ENDLESS = {"method": "laplacian", "iterations": 100000}


def healthcheck(*flags):
    done = subprocess.run([BURNISHD, *map(str, flags), "--healthcheck"], env=ENVIRONMENT, capture_output=True,
                          text=True, timeout=60)
    return done.returncode, done.stderr


class Healthcheck(unittest.TestCase):
    def test_is_what_readyz_says(self):
        with Server() as server:
            self.assertEqual(healthcheck("--http-listen", server.http), (0, ""))
            port = server.http.split(":")[1]
            self.assertEqual(healthcheck("--http-listen", f"0.0.0.0:{port}"), (0, ""))
        code, said = healthcheck("--http-listen", server.http)
        self.assertEqual((code, said), (1, "burnishd: not ready: Connection refused\n"))

    def test_reaches_a_unix_socket(self):
        with tempfile.TemporaryDirectory() as folder:
            socket_path = f"{folder}/http"
            with Server(http=f"unix:{socket_path}"):
                self.assertEqual(healthcheck("--http-listen", f"unix:{socket_path}"), (0, ""))
            self.assertEqual(healthcheck("--http-listen", f"unix:{socket_path}")[0], 1)

    def test_does_not_wait_for_ever(self):
        with socket.create_server(("127.0.0.1", 0)) as deaf:
            code, said = healthcheck("--http-listen", "127.0.0.1:%d" % deaf.getsockname()[1])
        self.assertEqual((code, said), (1, "burnishd: not ready: no answer to GET /readyz within 5 s\n"))


class FreedBlocks(unittest.TestCase):
    """What glibc keeps of them per thread it reads from the environment that a program starts with."""

    def tunables(self):
        with Server() as server:
            of_server = pathlib.Path(f"/proc/{server.process.pid}")
            self.assertEqual((of_server / "comm").read_text(), "burnishd\n")
            return re.findall(r"GLIBC_TUNABLES=([^\0]*)", (of_server / "environ").read_text())

    def test_are_not_kept(self):
        self.assertEqual(self.tunables(), ["glibc.malloc.tcache_count=0"])

    def test_are_kept_as_the_environment_says(self):
        for setting in "glibc.malloc.tcache_count=3", "":
            with self.subTest(setting), unittest.mock.patch.dict(ENVIRONMENT, GLIBC_TUNABLES=setting):
                self.assertEqual(self.tunables(), [setting])


    def test_cost_no_setting_that_comes_through_a_pipe(self):
        with tempfile.TemporaryDirectory() as folder:
            pipe, mesh = pathlib.Path(folder, "settings"), pathlib.Path(folder, "mesh.obj")
            os.mkfifo(pipe)
            mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            writer = threading.Thread(target=pipe.write_text, args=('{"max-iterations": 7}',))
            writer.start()
            with Server("--config", pipe) as server:
                writer.join()
                answer = server.post(mesh, "iterations=8&method=taubin")
        self.assertEqual(answer.problem["detail"], "iterations is 8; the limit is 7 (max-iterations)")


class Heaps(MeshTest):
    """glibc gives a thread a heap of its own, in 64 MiB of addresses that end at a multiple of 64 MiB, unless it is told
    how many there shall be."""

    def heaps_of_threads(self, *flags):
        with Server(*flags) as server:
            server.stub().Smooth(smooth_request(self.noisy))
            self.assertEqual(server.post(self.noisy).status, 200)
            maps = pathlib.Path(f"/proc/{server.process.pid}/maps").read_text()
        ends = re.findall(r"^\w+-(\w+) ---p 00000000 00:00 0 $", maps, re.MULTILINE)
        return sum(int(end, 16) % (64 << 20) == 0 for end in ends)

    def test_what_helpers_work_on_passes_through_one(self):
        self.assertEqual(self.heaps_of_threads(), 0)

    def test_without_helpers_threads_have_their_own(self):
        self.assertGreater(self.heaps_of_threads("--sandbox=false"), 0)


class Lifecycle(MeshTest):
    RESOLUTION = 100  # 120000 triangles: ENDLESS takes minutes

    def wait_for_running(self, server, count):
        eventually(lambda: server.metric("burnish_jobs_running") == count, f"{count} jobs run")

    def test_sigterm_answers_every_accepted_request(self):
        calls = 12
        with Server("--workers", 1, "--queue", calls, "--grace-seconds", 60) as server, \
                concurrent.futures.ThreadPoolExecutor(calls) as threads:
            request, stub = smooth_request(self.noisy, method="laplacian", iterations=50), server.stub()
            by_grpc = [threads.submit(stub.Smooth, request) for _ in range(calls // 2)]
            by_http = [threads.submit(server.post, self.noisy, "method=laplacian&iterations=50")
                       for _ in range(calls // 2)]

            def accepted():
                done = server.metric("burnish_outcomes_total", code="ok")
                return done + server.metric("burnish_queue_depth") + server.metric("burnish_jobs_running") >= calls

            eventually(accepted, "every request is accepted")
            server.terminate()
            meshes = {call.result().mesh for call in by_grpc}
            for answer in (call.result() for call in by_http):
                self.assertEqual(answer.status, 200, answer.body[:300])
                meshes.add(answer.body)
            self.assertEqual(len(meshes), 1)
            self.assertEqual(server.exit_code(), 0, server.log_text())

    def test_a_short_grace_ends_endless_jobs(self):
        with Server("--workers", 1, "--grace-seconds", 0) as server:
            running = server.stub().Smooth.future(smooth_request(self.noisy, **ENDLESS))
            self.wait_for_running(server, 1)
            server.terminate()
            self.assertEqual(server.exit_code(), 0, server.log_text())
            self.assertIn(running.code(), (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED))

    def test_a_client_that_never_finishes_asking_cannot_hold_the_server(self):
        with Server("--grace-seconds", 2) as server, socket.create_connection(server.http.split(":")) as slow:
            slow.sendall(b"POST /v1/smooth HTTP/1.1\r\nHost: slow\r\n")
            server.terminate()
            while server.process.poll() is None:  # one more byte of a header within every time limit of a read
                try:
                    slow.sendall(b"X")
                except OSError:
                    pass
                time.sleep(0.05)
            self.assertEqual(server.exit_code(), 0, server.log_text())
            self.assertIn("stopped", server.log_text())

    def test_a_full_queue_refuses_at_once(self):
        with Server("--workers", 1, "--queue", 1, "--grace-seconds", 0) as server:
            stub = server.stub()
            calls = [stub.Smooth.future(smooth_request(self.noisy, **ENDLESS)) for _ in range(2)]
            eventually(lambda: server.metric("burnish_queue_depth") == 1, "one job waits")
            answer = server.post(self.noisy)
            self.assertEqual((answer.status, answer.problem["code"]), (429, "queue_full"))
            self.assertIn("retry-after", answer.headers)
            with self.assertRaises(grpc.RpcError) as raised:
                stub.Smooth(smooth_request(self.noisy))
            self.assertEqual(raised.exception.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
            self.assertEqual(error_info(raised.exception)[0].reason, "QUEUE_FULL")
            for call in calls:
                call.cancel()
            self.wait_for_running(server, 0)

    def test_a_vanished_client_frees_its_worker(self):
        with Server("--workers", 1, "--grace-seconds", 0) as server:
            flags = ["smooth", self.noisy, self.folder / "never.obj", "--server", server.grpc, "--method",
                     ENDLESS["method"], "--iterations", ENDLESS["iterations"]]
            post = server.curl_command("/v1/smooth?method=laplacian&iterations=100000", "-o", "/dev/null",
                                       "--data-binary", f"@{self.noisy}")
            starts = {"killed command line": (lambda: start_burnish(*flags), signal.SIGKILL),
                      "interrupted command line": (lambda: start_burnish(*flags), signal.SIGINT),
                      "killed curl": (lambda: subprocess.Popen(post, env=ENVIRONMENT, stderr=subprocess.PIPE),
                                      signal.SIGKILL)}
            for name, (start, how) in starts.items():
                with self.subTest(name), start() as client:
                    self.wait_for_running(server, 1)
                    client.send_signal(how)
                    gone = time.monotonic()
                    self.wait_for_running(server, 0)
                    freed = time.monotonic() - gone
                    print(f"{name}: worker free after {1000 * freed:.0f} ms, as seen through /metrics")
                    self.assertLess(freed, 1)  # promised: 50 ms; the rest is for a busy machine and for polling
            self.assertEqual(server.post(self.noisy, "iterations=1").status, 200)
            self.assertFalse((self.folder / "never.obj").exists())

    def test_the_server_logs_one_line_per_request(self):
        with Server() as server:
            request_id = server.post(self.noisy, "iterations=1").headers["burnish-request-id"]
            reply = server.stub().Smooth(smooth_request(self.noisy, iterations=1))
            for wanted in request_id, reply.report.request_id:
                self.assertEqual(server.log_text().count(wanted), 1)

    def test_the_ports_file_names_both_addresses(self):
        with Server() as server:
            self.assertRegex(json.dumps([server.grpc, server.http]), r'\["127.0.0.1:\d+", "127.0.0.1:\d+"\]')
            self.assertNotEqual(server.grpc, server.http)


if __name__ == "__main__":
    unittest.main()
