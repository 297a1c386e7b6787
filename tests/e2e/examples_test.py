"""What is installed serves others: a project that finds the C++ client, and the examples of a scanning app's calls."""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

from programs import ENVIRONMENT, MeshTest, Server, burnish

BUILD = pathlib.Path(os.environ["BUILD"])
EXAMPLES = pathlib.Path(__file__).parents[2] / "client" / "examples"


def run(*command, **environment):
    return subprocess.run([*map(str, command)], env={**ENVIRONMENT, **environment}, capture_output=True, text=True, timeout=300)


class Installed(unittest.TestCase):
    """`cmake --install` into a folder of this test."""

    @classmethod
    def setUpClass(cls):
        cls.prefix = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory(prefix="burnish-prefix-")))
        done = run("cmake", "--install", BUILD, "--prefix", cls.prefix)
        assert done.returncode == 0, done.stdout + done.stderr
        cls.libraries = {"PKG_CONFIG_PATH": str(next(cls.prefix.rglob("burnish.pc")).parent)}

    def assert_done(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout


class Package(Installed):
    def test_the_installed_programs_run(self):
        self.assertIn("Usage", self.assert_done(run(self.prefix / "bin/burnish", "--help")))
        self.assertIn("--grpc-listen", self.assert_done(run(self.prefix / "bin/burnishd", "--help")))
        configuration = self.prefix / "etc/burnish/burnishd.json"
        self.assert_done(run(self.prefix / "bin/burnishd", "--config", configuration, "--print-config"))

    def test_the_manual_and_the_completion_come_along(self):
        self.assertIn(".TH", (self.prefix / "share/man/man1/burnish.1").read_text())
        completion = self.prefix / "share/bash-completion/completions/burnish"
        found = self.assert_done(run("bash", "-c", f"source {completion} && complete -p burnish"))
        self.assertIn("burnish", found)

    def test_versions_are_told_and_asked_for(self):
        version = re.search(r"[\d.]+", self.assert_done(run(self.prefix / "bin/burnish", "--version")))[0]
        self.assertEqual(self.assert_done(run("pkg-config", "--modversion", "burnish", **self.libraries)).strip(), version)
        with tempfile.TemporaryDirectory() as folder:
            listing = pathlib.Path(folder, "CMakeLists.txt")
            for wanted, found in {version: True, "0.0.1": False, "9.0": False}.items():
                listing.write_text(f"cmake_minimum_required(VERSION 3.25)\nproject(consumer LANGUAGES CXX)\n"
                                   f"find_package(Burnish {wanted} REQUIRED)\n")
                done = run("cmake", "-S", folder, "-B", pathlib.Path(folder, wanted), f"-DCMAKE_PREFIX_PATH={self.prefix}")
                self.assertEqual(done.returncode == 0, found, f"{wanted}: {done.stderr}")

    def test_the_unit_of_systemd_is_sound(self):
        unit = next(self.prefix.rglob("burnishd.service"))
        try:
            self.assertEqual(self.assert_done(run("systemd-analyze", "verify", unit)), "")
            said = self.assert_done(run("systemd-analyze", "security", "--offline=true", "--threshold=20", unit))
        except FileNotFoundError:
            self.skipTest("no systemd-analyze here")
        self.assertRegex(said, r"Overall exposure level for burnishd.service: [01]\.\d OK")


class Examples(Installed, MeshTest):
    """Each against a real server: the bytes of the command line, and a sentence with the place when the scan is bad."""

    @classmethod
    def setUpClass(cls):
        MeshTest.setUpClass.__func__(cls)
        Installed.setUpClass.__func__(cls)
        cls.server = Server()
        cls.addClassCleanup(cls.server.__exit__, None)
        cls.expected = cls.folder / "expected.obj"
        assert burnish("smooth", cls.noisy, cls.expected).returncode == 0
        cls.bad = cls.folder / "bad.obj"
        cls.bad.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")

    def check(self, address, *command):
        out = self.folder / "out.obj"
        out.unlink(missing_ok=True)
        said = self.assert_done(run(*command, address, self.noisy, out))
        self.assertRegex(said, r"auto: \d+ triangles with noise of [\d.]+ mean edges, moved by [\d.]+ at most, in [\d.]+ ms\n")
        self.assertEqual(out.read_bytes(), self.expected.read_bytes())
        done = run(*command, address, self.bad, out)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"vertex 9 .*line 4")

    def test_cpp_by_find_package(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assert_done(run("cmake", "-S", EXAMPLES / "cpp", "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}"))
            self.assert_done(run("cmake", "--build", folder))
            self.check(self.server.grpc, pathlib.Path(folder, "smooth_scan"))

    def test_cpp_by_pkg_config(self):
        flags = shlex.split(self.assert_done(run("pkg-config", "--cflags", "--libs", "burnish", **self.libraries)))
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder, "smooth_scan")
            self.assert_done(run("g++", "-std=c++20", EXAMPLES / "cpp" / "smooth_scan.cpp", *flags, "-o", program))
            self.check(self.server.grpc, program)

    def test_python_over_grpc(self):
        self.check(self.server.grpc, sys.executable, "-B", EXAMPLES / "python" / "smooth_scan.py")

    def test_python_over_connections_that_break(self):
        self.check(f"http://{self.server.http}", sys.executable, "-B", EXAMPLES / "python" / "submit_scan.py")

    def test_javascript(self):
        self.check(f"http://{self.server.http}", "node", EXAMPLES / "javascript" / "smooth_scan.mjs")


if __name__ == "__main__":
    unittest.main()
