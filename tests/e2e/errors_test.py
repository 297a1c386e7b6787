"""Errors are named by cause on every way, and bad files harm nobody."""

import socket
import subprocess
import unittest

import grpc

from programs import (BURNISHD, ENVIRONMENT, PATIENCE_SECONDS, MeshTest, Server, error_info, smooth_request,
                      start_burnish)

BAD_MESHES = {
    "index_out_of_range": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "non_finite_position": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "empty_mesh": b"# nothing\n",
    "malformed_mesh": b"v 0 0 0\nv 1 0 zero\nv 0 1 0\nf 1 2 3\n",
    "unsupported_format": b"\x00\x01\x02\x03\x89PNG",
}


class Errors(MeshTest):
    def bad_mesh(self, code):
        path = self.folder / f"{code}.obj"
        path.write_bytes(BAD_MESHES[code])
        return path

    def grpc_error(self, server, request, timeout=None):
        with self.assertRaises(grpc.RpcError) as raised:
            server.stub().Smooth(request, timeout=timeout)
        return raised.exception

    def test_bad_meshes_have_one_name_everywhere(self):
        out = self.folder / "never.obj"
        with Server() as server:
            for code in BAD_MESHES:
                with self.subTest(code):
                    mesh = self.bad_mesh(code)
                    for flags in [], ["--server", server.grpc]:
                        done = self.run_burnish("smooth", mesh, out, *flags, code=3)
                        self.assertTrue(done.stderr.startswith(f"burnish: {code}: "), done.stderr)
                        self.assertEqual(done.stderr.count("\n"), 1)
                    answer = server.post(mesh)
                    self.assertIn(answer.status, (415, 422))
                    self.assertEqual(answer.problem["code"], code)
                    self.assertEqual(answer.problem["status"], answer.status)
                    error = self.grpc_error(server, smooth_request(mesh))
                    self.assertEqual(error.code(), grpc.StatusCode.INVALID_ARGUMENT)
                    self.assertEqual(error_info(error)[0].reason, code.upper())
                    self.assertEqual(error_info(error)[0].domain, "burnish")
            self.assertFalse(out.exists())
            self.assertEqual(server.post(self.noisy).status, 200)

    def test_messages_point_at_the_line(self):
        done = self.run_burnish("smooth", self.bad_mesh("index_out_of_range"), self.folder / "never.obj", code=3)
        self.assertRegex(done.stderr, r"line 4")
        self.assertRegex(done.stderr, r"\b9\b")

    def test_bad_options_name_the_option(self):
        rows = [("lambda=many&method=taubin", "bad_option", "lambda", {"method": "taubin", "lambda": "many"}),
                ("iterations=999999999", "bad_option", "iterations", {"iterations": 999999999}),
                ("colour=red", "unknown_option", "colour", {"colour": "red"}),
                ("method=sanding", "unknown_method", None, {"method": "sanding"})]
        with Server() as server:
            for query, code, field, options in rows:
                with self.subTest(query):
                    problem = server.post(self.noisy, query).problem
                    self.assertEqual((problem["status"], problem["code"]), (400, code))
                    info, bad_request = error_info(self.grpc_error(server, smooth_request(self.noisy, **options)))
                    self.assertEqual(info.reason, code.upper())
                    if field:
                        self.assertEqual(problem["field"], field)
                        self.assertEqual(bad_request.field_violations[0].field, field)

    def test_wrong_addresses_are_problems(self):
        with Server() as server:
            for target, flags, status, code in (("/v2", [], 404, "not_found"),
                                                ("/v1/smooth", [], 405, "method_not_allowed"),
                                                ("/v1/methods", ["-X", "DELETE"], 405, "method_not_allowed")):
                answer = server.curl(target, *flags)
                self.assertEqual((answer.status, answer.problem["code"]), (status, code), target)

    def test_too_many_bytes_are_refused(self):
        with Server("--max-bytes", 1000) as server:
            answer = server.post(self.noisy)
            self.assertEqual((answer.status, answer.problem["code"]), (413, "too_large"))
            error = self.grpc_error(server, smooth_request(self.noisy))
            self.assertEqual(error.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
            self.run_burnish("smooth", self.noisy, self.folder / "never.obj", "--server", server.grpc, code=4)

    def test_deadlines_are_kept(self):
        out = self.folder / "never.obj"
        endless = ["--method", "laplacian", "--iterations", 100000]
        with Server() as server:
            for flags in [], ["--server", server.grpc]:
                done = self.run_burnish("smooth", self.noisy, out, *endless, "--timeout", 0.05, *flags, code=4)
                self.assertIn("deadline_exceeded", done.stderr)
            request = smooth_request(self.noisy, method="laplacian", iterations=100000)
            self.assertEqual(self.grpc_error(server, request, timeout=0.05).code(), grpc.StatusCode.DEADLINE_EXCEEDED)
        self.assertFalse(out.exists())

    def test_ctrl_c_ends_cleanly(self):
        folder = self.folder / "interrupted"
        folder.mkdir()
        process = start_burnish("smooth", self.noisy, folder / "out.obj", "--method", "laplacian",
                                "--iterations", 100000)
        process.send_signal(2)
        _, errors = process.communicate(timeout=PATIENCE_SECONDS)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("burnish: cancelled: ", errors)
        self.assertEqual(list(folder.iterdir()), [])

    def test_an_absent_server_is_unreachable(self):
        done = self.run_burnish("smooth", self.noisy, self.folder / "never.obj", "--server", "127.0.0.1:1", code=5)
        self.assertIn("burnish: unreachable: ", done.stderr)

    def test_a_port_in_use_stops_the_start(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            address = "127.0.0.1:%d" % taken.getsockname()[1]
            for flags in (["--grpc-listen", address, "--http-listen", "127.0.0.1:0"],
                          ["--grpc-listen", "127.0.0.1:0", "--http-listen", address]):
                done = subprocess.run([BURNISHD, *flags, "--store", self.folder / "store"], env=ENVIRONMENT,
                                      capture_output=True, text=True, timeout=PATIENCE_SECONDS)
                self.assertNotEqual(done.returncode, 0, flags)
                self.assertIn(address, done.stderr)


if __name__ == "__main__":
    unittest.main()
