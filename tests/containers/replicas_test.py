"""docker/compose.replicas.yaml as it stands: three replicas behind nginx, of which any may end at any time."""

import concurrent.futures
import datetime
import hashlib
import json
import pathlib
import subprocess
import tempfile
import threading
import time
import unittest

from engine import (BURNISH, ENGINE, ENVIRONMENT, GRPC, HAS_PAGE, HTTP, PROMETHEUS, ROOT, Compose, call, engine, eventually,
                    prometheus_targets, sample, tell)

REPLICAS = ["burnish-1", "burnish-2", "burnish-3"]
ENDED = ("JOB_STATE_SUCCEEDED", "JOB_STATE_FAILED", "JOB_STATE_CANCELLED")


class Replicas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="burnish-replicas-")))
        cls.mesh_file = cls.folder / "noisy.obj"
        cls.mesh = sample(cls.mesh_file)
        cls.compose = cls.enterClassContext(Compose("compose.replicas.yaml"))
        cls.keys = cls.compose.keys
        eventually(lambda: all(cls.ask(replica, "GET", "/readyz")[0] == 200 for replica in REPLICAS), "three replicas are ready")

    @classmethod
    def ask(cls, replica, verb, target, body=None, headers=None):
        """One replica, or any when it is None."""
        named = {"Burnish-Replica": replica} if replica else {}
        return call(HTTP, verb, target, body, {**cls.keys.headers, **named, **(headers or {})})

    @classmethod
    def back(cls, replica):
        """Podman gives a container another hardware address when it starts again, which its neighbours would learn within
        half a minute; Docker's stays."""
        if ENGINE == "podman":
            balancer = json.loads(engine("inspect", cls.compose.container("balancer")).stdout)[0]["State"]["Pid"]
            subprocess.run(["nsenter", "-t", str(balancer), "-n", "ip", "neigh", "flush", "all"], check=True)
        eventually(lambda: cls.ask(replica, "GET", "/readyz")[0] == 200, f"{replica} is back")

    @classmethod
    def seconds_to_stop(cls, replica):
        """From the signal to burnishd's last word, as its log has it: the engine takes time of its own."""
        log = engine("logs", cls.compose.container(replica))
        times = {}
        for line in (log.stdout + log.stderr).splitlines():
            for event in (": stopping within", " info stopped"):
                if event in line:
                    times[event] = datetime.datetime.fromisoformat(line.split()[0].replace("Z", "+00:00"))
        return (times[" info stopped"] - times[": stopping within"]).total_seconds()

    def submit(self, replica=None, headers=None, options="method=taubin&iterations=10", body=None):
        status, _, answer = self.ask(replica, "POST", f"/v1/jobs?{options}", self.mesh if body is None else body, headers)
        self.assertEqual(status, 202, answer)
        return json.loads(answer)["id"]

    def ended(self, identity):
        def job():
            status, _, body = self.ask(None, "GET", f"/v1/jobs/{identity}", headers={"Prefer": "wait=2"})
            return json.loads(body) if status == 200 and json.loads(body)["state"] in ENDED else None
        return eventually(job, f"job {identity} ends")

    def assert_succeeded(self, jobs, expected):
        for identity in jobs:
            job = self.ended(identity)
            self.assertEqual((job["state"], job["result"]["sha256"]), ("JOB_STATE_SUCCEEDED", expected))

    def quiet_result(self):
        status, _, mesh = self.ask(None, "POST", "/v1/smooth?method=taubin&iterations=10", self.mesh)
        self.assertEqual(status, 200)
        return hashlib.sha256(mesh).hexdigest()

    def test_what_a_replica_keeps_is_asked_of_it(self):
        jobs = [self.submit() for _ in range(9)]
        self.assertEqual({identity.rpartition("-")[0] for identity in jobs}, set(REPLICAS))
        self.assert_succeeded(jobs, self.quiet_result())
        for identity in jobs:
            status, _, mesh = self.ask(None, "GET", f"/v1/jobs/{identity}/mesh")
            self.assertEqual((status, hashlib.sha256(mesh).hexdigest()), (200, self.quiet_result()))

    def test_an_idempotency_key_finds_its_job(self):
        for key in "abcdef":
            again = {self.submit(headers={"Idempotency-Key": f"key-{key}"}) for _ in range(4)}
            self.assertEqual(len(again), 1, again)

    def test_an_upload_goes_on_where_it_began(self):
        half = len(self.mesh) // 2
        status, headers, _ = self.ask(None, "POST", "/v1/uploads", self.mesh[:half], {"Upload-Complete": "?0"})
        self.assertEqual(status, 201)
        place = headers["location"]
        status, headers, _ = self.ask(None, "HEAD", place)
        self.assertEqual((status, headers["upload-offset"]), (200, str(half)))
        status, _, body = self.ask(None, "PATCH", place, self.mesh[half:],
                                   {"Upload-Offset": str(half), "Upload-Complete": "?1",
                                    "Content-Type": "application/partial-upload"})
        self.assertIn(status, (200, 204), body)
        replica = place.rpartition("/")[2].rpartition("-")[0]
        sha256 = hashlib.sha256(self.mesh).hexdigest()
        job = self.submit(replica, options=f"mesh_sha256={sha256}&method=taubin&iterations=10", body=b"")
        self.assert_succeeded([job], self.quiet_result())

    @unittest.skipUnless(HAS_PAGE, "scripts/setup found no npm registry")
    def test_a_page_stays_with_the_replica_that_has_its_uploads(self):
        status, headers, _ = self.ask(None, "GET", "/")
        self.assertEqual(status, 200)
        cookie = {"Cookie": headers["set-cookie"].partition(";")[0]}
        jobs = []
        for n in range(6):
            status, _, body = self.ask(None, "POST", "/v1/uploads", b"# %d\n" % n + self.mesh, cookie)
            self.assertEqual(status, 201, body)
            status, _, body = self.ask(None, "POST", f"/v1/jobs?mesh_sha256={json.loads(body)['sha256']}", headers=cookie)
            self.assertEqual(status, 202, body)
            jobs.append(json.loads(body)["id"])
        self.assertEqual({identity.rpartition("-")[0] for identity in jobs}, {cookie["Cookie"].partition("=")[2]})

    def test_the_balancer_of_kubernetes_has_a_sound_configuration(self):
        done = engine("run", "--rm", "--tmpfs", "/tmp", "-v", f"{ROOT}/docker/kubernetes/base/nginx.conf:/nginx.conf:ro", "--entrypoint",
                      "sh", "burnish-nginx", "-ec", "sed 's/NAMESERVER/127.0.0.1/; s/NAMESPACE/default/' /nginx.conf >/tmp/nginx.conf;"
                      " nginx -e stderr -t -c /tmp/nginx.conf")
        self.assertIn("test is successful", done.stderr)

    def under_load(self, disturb, seconds):
        """Calls over gRPC with the C++ client's retries and over HTTP, and jobs, while `disturb` runs."""
        load = subprocess.Popen([BURNISH, "bench", "--server", f"127.0.0.1:{GRPC}", "--mesh", str(self.mesh_file), "--method",
                                 "taubin", "--concurrency", "4", "--rate", "20", "--duration", str(seconds), "--retries", "8",
                                 "--json"], env={**ENVIRONMENT, "BURNISH_TOKEN": self.keys.token}, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        stop, jobs, refused, answers = threading.Event(), [], [], []

        def submit():
            while not stop.is_set():
                status, _, body = self.ask(None, "POST", "/v1/jobs?method=taubin&iterations=10", self.mesh)
                (jobs if status == 202 else refused).append(json.loads(body)["id"] if status == 202 else status)
                time.sleep(0.1)

        def smooth():
            while not stop.is_set():
                status, _, mesh = self.ask(None, "POST", "/v1/smooth?method=taubin&iterations=10", self.mesh)
                answers.append((status, hashlib.sha256(mesh).hexdigest()))
                time.sleep(0.05)

        with concurrent.futures.ThreadPoolExecutor(3) as threads:
            running = [threads.submit(each) for each in (submit, smooth, smooth)]
            try:
                disturb(jobs)
                out, said = load.communicate(timeout=seconds + 60)
            finally:
                stop.set()
                load.kill()
            for each in running:
                each.result()
        self.assertEqual(load.returncode, 0, said)
        return json.loads(out), jobs, refused, answers

    def test_a_rolling_restart_fails_no_call_and_loses_no_job(self):
        expected = self.quiet_result()

        took = []

        def restart(jobs):
            for replica in REPLICAS:
                began = time.monotonic()
                engine("restart", "-t", 40, self.compose.container(replica))
                restarted = time.monotonic()
                self.back(replica)
                took.append(f"{restarted - began:.1f} ({self.seconds_to_stop(replica):.1f} of burnishd) + {time.monotonic() - restarted:.1f}")
                seen = len(jobs)  # for a second nginx takes one that did not answer for dead
                eventually(lambda: any(identity.startswith(f"{replica}-") for identity in jobs[seen:]), f"{replica} has work")

        calls, jobs, refused, answers = self.under_load(restart, 12)
        tell("rolling restart", seconds_to_restart_and_until_ready=took, grpc_calls=calls["outcomes"], http_answers=len(answers),
             other_than_200=[status for status, _ in answers if status != 200], jobs=len(jobs), refused_jobs=refused)
        self.assertEqual(list(calls["outcomes"]), ["ok"])
        self.assertEqual(set(answers), {(200, expected)})
        self.assert_succeeded(jobs, expected)

    def test_kill_9_of_a_replica_costs_only_what_was_in_flight_there(self):
        expected = self.quiet_result()
        before = [self.submit("burnish-2") for _ in range(10)]

        def kill(jobs):
            eventually(lambda: len(jobs) >= 10, "the load has begun")
            engine("kill", "-s", "KILL", self.compose.container("burnish-2"))
            seen = len(jobs)
            eventually(lambda: len(jobs) >= seen + 20, "the others carry on")
            engine("start", self.compose.container("burnish-2"))
            self.back("burnish-2")

        calls, jobs, refused, answers = self.under_load(kill, 10)
        tell("kill -9 of one of three", grpc_calls=calls["outcomes"], http_answers=len(answers),
             other_than_200=[status for status, _ in answers if status != 200], jobs=len(jobs), refused_jobs=refused)
        self.assertEqual(list(calls["outcomes"]), ["ok"])
        self.assertEqual(set(answers), {(200, expected)})
        self.assertLessEqual(len(refused), 2, "only what was in flight on it")
        self.assert_succeeded(before + jobs, expected)

    def test_prometheus_scrapes_all_and_evaluates_the_alerts(self):
        eventually(lambda: prometheus_targets() == 3, "three targets are up")
        rules = json.loads(call(PROMETHEUS, "GET", "/api/v1/rules")[2])["data"]["groups"][0]["rules"]
        eventually(lambda: all(rule["health"] == "ok" for rule in json.loads(
            call(PROMETHEUS, "GET", "/api/v1/rules")[2])["data"]["groups"][0]["rules"]), "every rule is evaluated")
        tell("Prometheus", targets=3, rules=len(rules))


if __name__ == "__main__":
    unittest.main()
