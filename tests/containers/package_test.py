"""The Debian package in a clean root, under systemd as its unit has it: installed, used, restarted, purged."""

import re
import secrets
import unittest

from engine import ENGINE, engine, eventually, tell

LEFT_OVER = ["/usr/bin/burnish", "/usr/bin/burnishd", "/etc/burnish", "/lib/systemd/system/burnishd.service",
             "/usr/share/man/man1/burnish.1", "/usr/share/bash-completion/completions/burnish", "/var/lib/burnish",
             "/var/lib/private/burnish", "/var/cache/burnish", "/var/cache/private/burnish"]


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.name = f"burnish-test-{secrets.token_hex(4)}"
        cls.addClassCleanup(engine, "rm", "-f", "-t", "0", cls.name, check=False)
        own = ["--systemd=false"] if ENGINE == "podman" else ["--cgroupns=private"]
        engine("run", "-d", "--name", cls.name, "--privileged", *own, "burnish-package")
        eventually(lambda: cls.run_inside("systemctl is-active burnishd", check=False).strip() == "active", "the service runs")
        eventually(lambda: "ready" in cls.run_inside("burnishd --config /etc/burnish/burnishd.json --healthcheck && echo ready",
                                                     check=False), "and is ready")

    @classmethod
    def run_inside(cls, command, check=True):
        done = engine("exec", cls.name, "sh", "-c", command, check=check)
        return done.stdout

    def test_1_serves_with_few_rights(self):
        self.run_inside("burnish sample /tmp/noisy.obj && burnish smooth /tmp/noisy.obj /tmp/local.obj"
                        " && burnish smooth /tmp/noisy.obj /tmp/grpc.obj --server 127.0.0.1:50051"
                        " && smooth_scan 127.0.0.1:50051 /tmp/noisy.obj /tmp/example.obj"
                        " && cmp /tmp/local.obj /tmp/grpc.obj && cmp /tmp/local.obj /tmp/example.obj")
        status = self.run_inside("cat /proc/$(systemctl show -P MainPID burnishd)/status")
        found = dict(re.findall(r"^(\w+):\s+(\S+)", status, re.M))
        self.assertNotEqual(found["Uid"], "0")
        self.assertEqual((int(found["CapEff"], 16), found["NoNewPrivs"], found["Seccomp"]), (0, "1", "2"))
        self.assertIn("/var/cache/private/burnish", self.run_inside("ls -d /var/cache/private/burnish"))
        tell("Debian package", uid=found["Uid"], exposure=re.search(r"Overall exposure level.*: ([\d.]+)", self.run_inside(
            "systemd-analyze security burnishd.service", check=False))[1])

    def test_2_keeps_its_store_over_a_restart(self):
        before = self.run_inside("ls /var/lib/private/burnish")
        self.assertIn("records.sqlite", before)
        self.run_inside("systemctl restart burnishd && systemctl is-active burnishd")
        self.assertEqual(self.run_inside("systemctl show -P Result burnishd").strip(), "success")

    def test_3_leaves_nothing_when_purged(self):
        self.run_inside("dpkg --purge burnish")
        self.assertEqual(self.run_inside(f"ls -d {' '.join(LEFT_OVER)} 2>/dev/null", check=False), "")
        self.assertIn("inactive", self.run_inside("systemctl is-active burnishd", check=False))


if __name__ == "__main__":
    unittest.main()
