"""Both ports inside TLS: who trusts the certificate is served, who shows none where one is asked for is not."""

import pathlib
import socket
import subprocess
import tempfile
import unittest

import grpc
from burnish.v1 import smoothing_pb2, smoothing_pb2_grpc

from programs import BURNISHD, CURL, ENVIRONMENT, PATIENCE_SECONDS, MeshTest, Server, eventually


class Tls(MeshTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.authority("ca")
        cls.authority("stranger")
        for name in "server", "client", "later":
            cls.certificate(name, "ca")
        cls.certificate("forged", "stranger")

    @classmethod
    def openssl(cls, *arguments):
        done = subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, cwd=cls.folder)
        assert done.returncode == 0, done.stderr

    @classmethod
    def authority(cls, name):
        cls.openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", 2, "-keyout", f"{name}.key", "-out",
                    f"{name}.pem", "-subj", f"/CN={name}")

    @classmethod
    def certificate(cls, name, authority):
        (cls.folder / "names").write_text("subjectAltName=DNS:localhost,IP:127.0.0.1\n")
        cls.openssl("req", "-newkey", "rsa:2048", "-nodes", "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj",
                    f"/CN={name}")
        cls.openssl("x509", "-req", "-in", f"{name}.csr", "-CA", f"{authority}.pem", "-CAkey", f"{authority}.key",
                    "-CAcreateserial", "-days", 2, "-extfile", "names", "-out", f"{name}.pem")

    def flags(self, *more):
        return ["--tls-certificate", self.folder / "server.pem", "--tls-key", self.folder / "server.key", *more]

    def curl(self, server, *flags, target="/v1/methods"):
        """The status, or 0 when there is no answer."""
        done = subprocess.run([CURL, "-sS", "--max-time", str(PATIENCE_SECONDS), "-o", self.folder / "answer", "-w",
                               "%{http_code}", *map(str, flags), f"https://{server.http}{target}"], env=ENVIRONMENT,
                              capture_output=True, text=True)
        return int(done.stdout or 0)

    def bytes(self, name):
        return (self.folder / name).read_bytes()

    def grpc_methods(self, server, authority="ca", own=None):
        credentials = grpc.ssl_channel_credentials(self.bytes(f"{authority}.pem"),
                                                   self.bytes(f"{own}.key") if own else None,
                                                   self.bytes(f"{own}.pem") if own else None)
        with grpc.secure_channel(server.grpc, credentials, options=[("grpc.enable_http_proxy", 0)]) as channel:
            stub = smoothing_pb2_grpc.SmoothingServiceStub(channel)
            try:
                return len(stub.ListMethods(smoothing_pb2.ListMethodsRequest(), timeout=10).methods)
            except grpc.RpcError as error:
                self.assertEqual(error.code(), grpc.StatusCode.UNAVAILABLE)
                return 0

    def test_who_trusts_the_authority_is_served(self):
        with Server(*self.flags()) as server:
            self.assertEqual(self.curl(server, "--cacert", self.folder / "ca.pem"), 200)
            self.assertEqual(self.curl(server, "--cacert", self.folder / "stranger.pem"), 0)
            self.assertGreater(self.grpc_methods(server), 10)
            self.assertEqual(self.grpc_methods(server, "stranger"), 0)
            plain = subprocess.run([CURL, "-sS", f"http://{server.http}/livez"], env=ENVIRONMENT, capture_output=True)
            self.assertNotEqual(plain.returncode, 0, "nothing is said in the open")
            for size in 0, 1000000:  # a comment that makes the body longer than what is encrypted at once
                (self.folder / "large.obj").write_bytes(self.noisy.read_bytes() + b"#" + b"x" * size)
                self.assertEqual(self.curl(server, "--cacert", self.folder / "ca.pem", "--data-binary",
                                           f"@{self.folder / 'large.obj'}", target="/v1/smooth?method=taubin"), 200)
                here = self.folder / "here.obj"
                self.run_burnish("smooth", self.folder / "large.obj", here, "--method", "taubin")
                self.assertEqual(self.bytes("answer"), here.read_bytes())
            there = self.folder / "there.obj"
            self.run_burnish("smooth", self.folder / "large.obj", there, "--method", "taubin", "--server",
                             server.grpc.replace("127.0.0.1", "localhost"), "--tls-ca", self.folder / "ca.pem")
            self.assertEqual(there.read_bytes(), here.read_bytes())

    def test_the_health_check_speaks_it_and_shows_the_servers_certificate(self):
        for more in (), ("--tls-client-ca", self.folder / "ca.pem"):
            with Server(*self.flags(*more)) as server:
                done = subprocess.run([BURNISHD, *map(str, self.flags(*more)), "--http-listen", server.http,
                                       "--healthcheck"], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_who_shows_no_certificate_is_not_served_where_one_is_asked_for(self):
        with Server(*self.flags("--tls-client-ca", self.folder / "ca.pem")) as server:
            trust = ["--cacert", self.folder / "ca.pem"]
            own = ["--cert", self.folder / "client.pem", "--key", self.folder / "client.key"]
            forged = ["--cert", self.folder / "forged.pem", "--key", self.folder / "forged.key"]
            self.assertEqual(self.curl(server, *trust, *own), 200)
            self.assertEqual(self.curl(server, *trust), 0)
            self.assertEqual(self.curl(server, *trust, *forged), 0)
            self.assertGreater(self.grpc_methods(server, own="client"), 10)
            self.assertEqual(self.grpc_methods(server), 0)
            self.assertEqual(self.grpc_methods(server, own="forged"), 0)

    def test_a_new_certificate_serves_without_a_restart(self):
        with tempfile.TemporaryDirectory() as folder:
            certificate, key = pathlib.Path(folder, "c.pem"), pathlib.Path(folder, "k.pem")
            certificate.write_bytes(self.bytes("server.pem"))
            key.write_bytes(self.bytes("server.key"))
            with Server("--tls-certificate", certificate, "--tls-key", key) as server:
                def subject():
                    done = subprocess.run([CURL, "-svo", "/dev/null", "--cacert", self.folder / "ca.pem",
                                           f"https://{server.http}/livez"], env=ENVIRONMENT, capture_output=True, text=True)
                    return "later" if "CN=later" in done.stderr else "server" if "CN=server" in done.stderr else ""
                self.assertEqual(subject(), "server")
                certificate.write_text("half a")
                eventually(lambda: "the former certificate stays" in server.log_text(), "it is logged")
                self.assertEqual(subject(), "server")
                key.write_bytes(self.bytes("later.key"))
                certificate.write_bytes(self.bytes("later.pem"))
                eventually(lambda: subject() == "later", "the new one is shown")
                self.assertGreater(self.grpc_methods(server), 10)

    def test_slow_handshakes_keep_nobody_waiting(self):
        with Server(*self.flags("--head-seconds", 2)) as server:
            host, port = server.http.rsplit(":", 1)
            slow = [socket.create_connection((host, int(port))) for _ in range(200)]
            self.assertEqual(self.curl(server, "--cacert", self.folder / "ca.pem"), 200)
            for connection in slow:
                connection.settimeout(PATIENCE_SECONDS)
                self.assertEqual(connection.recv(1), b"", "the server ends it")
                connection.close()

    def test_files_that_cannot_serve_stop_the_start(self):
        for flags, word in ((["--tls-certificate", self.folder / "server.pem"], "tls-key"),
                            (["--tls-certificate", self.folder / "none.pem", "--tls-key", self.folder / "server.key"],
                             "tls-certificate"),
                            (["--tls-certificate", self.folder / "server.pem", "--tls-key", self.folder / "client.key"],
                             "tls-key"),
                            (self.flags("--tls-client-ca", self.folder / "server.key"), "tls-client-ca")):
            with self.subTest(word), self.assertRaisesRegex(AssertionError, word):
                Server(*flags)


if __name__ == "__main__":
    unittest.main()
