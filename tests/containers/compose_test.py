"""docker/compose.yaml as it stands: one command starts the server and its Prometheus."""

import pathlib
import tempfile
import unittest

from engine import HAS_PAGE, HTTP, Compose, call, eventually, prometheus_targets, sample


class OneServer(unittest.TestCase):
    def test_serves_and_is_watched(self):
        with tempfile.TemporaryDirectory() as folder, Compose("compose.yaml") as compose:
            mesh = sample(pathlib.Path(folder, "noisy.obj"))
            eventually(lambda: call(HTTP, "GET", "/readyz")[0] == 200, "it is ready")
            if HAS_PAGE:
                status, headers, page = call(HTTP, "GET", "/")
                self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"), page[:300])
                self.assertIn(b"<script", page)
            self.assertEqual(call(HTTP, "POST", "/v1/smooth", mesh)[0], 401)
            self.assertEqual(call(HTTP, "POST", "/v1/smooth", mesh, compose.keys.headers)[0], 200)
            eventually(lambda: prometheus_targets() == 1, "Prometheus scrapes it")


if __name__ == "__main__":
    unittest.main()
