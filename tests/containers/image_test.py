"""The image: what is in it, what it may do, and what it bears."""

import contextlib
import datetime
import hashlib
import json
import pathlib
import re
import socket
import tempfile
import time
import unittest

from engine import Burnishd, call, engine, eventually, new_secrets, sample, tell

ENDED = ("JOB_STATE_SUCCEEDED", "JOB_STATE_FAILED", "JOB_STATE_CANCELLED")


class ImageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.keys = cls.enterClassContext(new_secrets())
        folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.mesh = sample(pathlib.Path(folder, "noisy.obj"))

    def submit(self, server, options="method=taubin&iterations=10"):
        status, _, body = server.call("POST", f"/v1/jobs?{options}", self.mesh)
        self.assertEqual(status, 202, body)
        return json.loads(body)["id"]

    def ended(self, server, identity):
        return eventually(lambda: (lambda job: job if job.get("state") in ENDED else None)(server.job(identity)),
                          f"job {identity} ends")


class Image(ImageTest):
    def test_is_small_and_says_what_it_is(self):
        image, base = (json.loads(engine("image", "inspect", name).stdout)[0] for name in ("burnish", "debian:bookworm-slim"))
        over = (image["Size"] - base["Size"]) / 1e6
        tell("image", over_its_base=f"{over:.0f} MB", whole=f"{image['Size'] / 1e6:.0f} MB")
        self.assertLess(over, 120)
        self.assertEqual(image["Config"]["User"], "burnish:burnish")
        self.assertEqual(image["Config"]["StopSignal"], "SIGTERM")
        check = image["Config"].get("Healthcheck") or image["Healthcheck"]  # Docker's place, podman's place
        self.assertEqual(check["Test"], ["CMD", "burnishd", "--healthcheck"])
        self.assertEqual(image["Config"]["Labels"]["org.opencontainers.image.title"], "burnish")
        self.assertIn("/var/lib/burnish", image["Config"]["Volumes"])

    def test_does_not_start_without_tokens(self):
        done = engine("run", "--rm", "burnish", check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("/run/secrets/burnish_tokens", done.stderr)

    def test_starts_soon_has_no_rights_and_ends_with_0(self):
        server = Burnishd(self.keys)
        began = time.monotonic()
        with server:
            ready = time.monotonic() - began
            tell("start", ready_in_ms=round(1000 * ready), idle_memory=f"{server.memory_mb():.0f} MB")
            status = pathlib.Path(f"/proc/{server.processes()[0]}/status").read_text()
            self.assertEqual(re.search(r"^Uid:\s+(\d+)", status, re.M)[1], "10001")
            self.assertEqual(int(re.search(r"^CapEff:\s+(\w+)", status, re.M)[1], 16), 0)
            self.assertEqual(re.search(r"^NoNewPrivs:\s+(\d)", status, re.M)[1], "1")
            self.assertEqual(engine("exec", server.name, "burnishd", "--healthcheck").returncode, 0)
            self.assertNotEqual(engine("exec", server.name, "touch", "/etc/x", check=False).returncode, 0)
            self.assertEqual(call(server.HTTP, "POST", "/v1/smooth", self.mesh)[0], 401)
            status, headers, mesh = server.call("POST", "/v1/smooth", self.mesh)
            self.assertEqual((status, len(mesh) > 0), (200, True))
            engine("stop", "-t", 30, server.name)
            self.assertEqual(server.exit_code(), 0, server.log())


class Faults(ImageTest):
    """One server and what may happen to it."""

    OPTIONS = "method=taubin&iterations=10"

    def test_kill_9_loses_no_job(self):
        with Burnishd(self.keys) as server:
            jobs = [self.submit(server, f"method=taubin&iterations={n}") for n in range(1, 21)]
            engine("kill", "-s", "KILL", server.name)
            server.exit_code()
            engine("start", server.name)
            eventually(server.ready, "it is back")
            states = [self.ended(server, job)["state"] for job in jobs]
        self.assertEqual(states, ["JOB_STATE_SUCCEEDED"] * len(jobs))
        tell("kill -9, start again", jobs=len(jobs), succeeded=len(states))

    def test_a_new_container_takes_the_volume_over(self):
        name = "burnish-test-volume"
        try:
            with Burnishd(self.keys, volume=name) as server:
                done = self.ended(server, self.submit(server))
                waiting = self.submit(server, "method=adaptive&iterations=3000")
                engine("stop", "-t", 1, server.name)
            with Burnishd(self.keys, volume=name) as server:
                self.assertEqual(hashlib.sha256(server.call("GET", f"/v1/jobs/{done['id']}/mesh")[2]).hexdigest(),
                                 done["result"]["sha256"])
                self.assertEqual(self.ended(server, waiting)["state"], "JOB_STATE_SUCCEEDED")
        finally:
            engine("volume", "rm", "-f", name, check=False)

    def test_sigterm_answers_what_was_accepted(self):
        with Burnishd(self.keys) as server:
            job = self.submit(server)
            engine("kill", "-s", "TERM", server.name)
            self.assertEqual(server.exit_code(), 0, server.log())
            engine("start", server.name)
            eventually(server.ready, "it is back")
            self.assertEqual(self.ended(server, job)["state"], "JOB_STATE_SUCCEEDED")

    def test_an_upload_goes_on_after_a_cut_of_the_network(self):
        network = "burnish-test-cut"
        engine("network", "create", network)
        try:
            with Burnishd(self.keys, network=network) as server:
                place = server.call("POST", "/v1/uploads")[1]["location"]
                token = self.keys.headers["Authorization"]
                half = len(self.mesh) // 2
                with socket.create_connection(("127.0.0.1", server.HTTP), 10) as client:
                    client.sendall(f"PATCH {place} HTTP/1.1\r\nHost: x\r\nAuthorization: {token}\r\nUpload-Offset: 0\r\n"
                                   f"Upload-Complete: ?1\r\nContent-Type: application/partial-upload\r\n"
                                   f"Content-Length: {len(self.mesh)}\r\n\r\n".encode() + self.mesh[:half])
                    eventually(lambda: int(server.call("HEAD", place)[1]["upload-offset"]) > 0, "bytes have come")
                    engine("network", "disconnect", network, server.name)
                    with contextlib.suppress(OSError):
                        client.sendall(self.mesh[half:])
                engine("network", "connect", network, server.name)
                eventually(lambda: server.call("GET", "/readyz")[0] == 200, "the network is back")

                began = time.monotonic()
                offset = int(server.call("HEAD", place)[1]["upload-offset"])
                # The server does not know yet that nobody is at the other end of the first connection.
                status, _, body = server.call("PATCH", place, self.mesh[offset:],
                                              {"Upload-Offset": str(offset), "Upload-Complete": "?1",
                                               "Content-Type": "application/partial-upload"})
                self.assertEqual((status, json.loads(body).get("sha256")), (200, hashlib.sha256(self.mesh).hexdigest()))
                tell("network cut in an upload", bytes=len(self.mesh), kept=offset, again_after=f"{time.monotonic() - began:.1f} s")
        finally:
            engine("network", "rm", "-f", network, check=False)

    def test_a_jump_of_the_clock_loses_no_job(self):
        # Only this server's clock: libfaketime reads how far it is off. Monotonic time goes on as it does in a real jump.
        library = next(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder).chmod(0o755)
            off = pathlib.Path(folder, "off")
            off.write_text("+0")
            server = Burnishd(self.keys, environment={
                "LD_PRELOAD": "/faketime.so", "FAKETIME_TIMESTAMP_FILE": "/clock/off", "FAKETIME_NO_CACHE": "1",
                "FAKETIME_DONT_FAKE_MONOTONIC": "1", "DONT_FAKE_MONOTONIC": "1"})
            server.store += ["-v", f"{library}:/faketime.so:ro", "-v", f"{folder}:/clock:ro"]
            with server:
                expected = hashlib.sha256(server.call("POST", f"/v1/smooth?{self.OPTIONS}", self.mesh)[2]).hexdigest()
                for jump, hours in {"+1h": 1, "-1h": -1, "+0": 0}.items():
                    place = server.call("POST", "/v1/uploads", self.mesh[:9999], {"Upload-Complete": "?0"})[1]["location"]
                    jobs = [self.submit(server, f"method=adaptive&iterations={400 + n}&max_displacement={1 + n + hours}")
                            for n in range(4)]
                    off.write_text(jump)
                    seconds = self.clock(server) - time.time()
                    self.assertLess(abs(seconds - 3600 * hours), 60, "the server's clock has jumped")
                    states = [self.ended(server, job)["state"] for job in jobs]
                    self.assertEqual(states, ["JOB_STATE_SUCCEEDED"] * len(jobs), jump)
                    status, _, body = server.call("PATCH", place, self.mesh[9999:], {
                        "Upload-Offset": "9999", "Upload-Complete": "?1", "Content-Type": "application/partial-upload"})
                    self.assertEqual(status, 200, body)
                    status, _, mesh = server.call("POST", f"/v1/smooth?{self.OPTIONS}", self.mesh)
                    self.assertEqual((status, hashlib.sha256(mesh).hexdigest()), (200, expected))
                old = self.ended(server, self.submit(server))["id"]
                off.write_text("+3d")  # beyond --keep-seconds
                eventually(lambda: server.call("GET", f"/v1/jobs/{old}")[0] == 410, "what is out of time expires")
                self.assertTrue(server.ready())
                self.assertEqual(self.ended(server, self.submit(server, "method=taubin&iterations=7"))["state"],
                                 "JOB_STATE_SUCCEEDED")
        tell("clock jump", hours="+1 -2 +1 +72", jobs=14, failed=0)

    def clock(self, server):
        """What the server takes for now, in Unix time."""
        created = json.loads(server.call("POST", "/v1/uploads", headers={"Upload-Complete": "?0"})[2])["createTime"]
        return datetime.datetime.fromisoformat(created.replace("Z", "+00:00")).timestamp()

    def test_a_full_volume_is_answered_and_survived(self):
        volume = ["--tmpfs", "/var/lib/burnish:size=4m,mode=1777"]
        with Burnishd(self.keys, store=volume) as server:
            kept, status, body = [], 202, b""
            while status == 202 and len(kept) < 200:
                status, _, body = server.call("POST", f"/v1/jobs?method=taubin&iterations={len(kept) + 1}",
                                              b"# %d\n" % len(kept) + self.mesh)
                if status == 202:
                    kept.append(json.loads(body)["id"])
            self.assertEqual((status, json.loads(body)["code"]), (507, "storage_full"))
            self.assertEqual(server.call("POST", "/v1/smooth", self.mesh)[0], 200)
            for job in kept:
                eventually(lambda: server.call("DELETE", f"/v1/jobs/{job}")[0] in (204, 404), "it is removed")
            eventually(lambda: server.call("POST", "/v1/jobs", self.mesh)[0] == 202, "there is room again")
            tell("full volume", jobs_until_507=len(kept))

    def test_a_read_only_volume_is_named(self):
        server = Burnishd(self.keys)
        server.store = ["-v", f"{server.volume}:/var/lib/burnish:ro"]
        try:
            server.start()
            self.assertNotEqual(server.exit_code(), 0)
            self.assertRegex(server.log(), "Read-only file system")
        finally:
            server.__exit__()


if __name__ == "__main__":
    unittest.main()
