"""What /metrics says is what was done, and Prometheus' own tool finds nothing to complain about."""

import json
import os
import pathlib
import re
import subprocess
import time
import unittest

import grpc
from burnish.v1 import smoothing_pb2

from programs import PATIENCE_SECONDS, MeshTest, Server, eventually, smooth_request

PROMTOOL = os.environ["PROMTOOL"]
ROOT = pathlib.Path(__file__).resolve().parents[2]
OPERATIONS = (ROOT / "docs/operations.md").read_text()
RULES = ROOT / "docker/prometheus/alerts.yaml"
DASHBOARD = json.loads((ROOT / "docker/grafana/burnish.json").read_text())


def promtool(*arguments, text=None):
    return subprocess.run([PROMTOOL, *map(str, arguments)], input=text, capture_output=True, text=True,
                          timeout=PATIENCE_SECONDS)


def families(text):
    """Type by name."""
    return dict(re.findall(r"^# TYPE (\w+) (\w+)$", text, re.MULTILINE))


class Metrics(MeshTest):
    def ask(self, server):
        """3 good and 2 bad requests to smooth, and 2 to compare, over both transports."""
        stub = server.stub()
        bad = self.folder / "bad.obj"
        bad.write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
        for _ in range(2):
            self.assertEqual(server.post(self.noisy, "iterations=1").status, 200)
        self.assertEqual(server.post(bad).status, 422)
        stub.Smooth(smooth_request(self.noisy, iterations=1))
        with self.assertRaises(grpc.RpcError):
            stub.Smooth(smooth_request(self.noisy, colour="red"))
        compared = server.curl("/v1/compare", "-F", f"reference=@{self.clean}", "-F", f"mesh=@{self.noisy}")
        self.assertEqual(compared.status, 200, compared.body)
        stub.Compare(smoothing_pb2.CompareRequest(reference=self.clean.read_bytes(), mesh=self.noisy.read_bytes()))

    def test_counts_are_what_was_done(self):
        noisy, clean = self.noisy.stat().st_size, self.clean.stat().st_size
        with Server("--workers", 2) as server:
            started = time.time()
            self.ask(server)
            for name, labels, expected in (
                    ("burnish_requests_total", {"transport": "http", "kind": "smooth"}, 3),
                    ("burnish_requests_total", {"transport": "grpc", "kind": "smooth"}, 2),
                    ("burnish_requests_total", {"kind": "compare"}, 2),
                    ("burnish_outcomes_total", {"transport": "http", "kind": "smooth", "code": "ok"}, 2),
                    ("burnish_outcomes_total", {"transport": "http", "code": "index_out_of_range"}, 1),
                    ("burnish_outcomes_total", {"transport": "grpc", "code": "unknown_option"}, 1),
                    ("burnish_outcomes_total", {"kind": "compare", "code": "ok"}, 2),
                    ("burnish_outcomes_total", {}, 7),
                    ("burnish_stage_seconds_count", {"kind": "smooth", "stage": "queue"}, 3),
                    ("burnish_stage_seconds_count", {"kind": "compare", "stage": "measure"}, 2),
                    ("burnish_job_seconds_count", {}, 5),
                    ("burnish_request_mesh_bytes_sum", {"transport": "grpc", "kind": "compare"}, noisy + clean),
                    ("burnish_response_mesh_bytes_count", {}, 3),
                    ("burnish_workers", {}, 2),
                    ("burnish_lifecycle_state", {"state": "serving"}, 1),
                    ("burnish_lifecycle_state", {}, 1),
                    ("burnish_self_test_passed", {}, 1)):
                with self.subTest(name, **labels):
                    self.assertEqual(server.metric(name, **labels), expected)
            self.assertGreater(server.metric("burnish_stage_seconds_sum", kind="smooth", stage="smooth"), 0)
            for name in "burnish_self_test_timestamp_seconds", "process_start_time_seconds":
                self.assertLess(abs(server.metric(name) - started), PATIENCE_SECONDS + 5)
            for name in ("burnish_queue_depth", "burnish_jobs_running", "burnish_reserved_memory_bytes",
                         "burnish_spooled_bytes"):
                eventually(lambda: server.metric(name) == 0, f"{name} returns to 0")

    def test_what_runs_and_waits_is_visible(self):
        with Server("--workers", 1, "--grace-seconds", 0) as server:
            stub = server.stub()
            request = smooth_request(self.noisy, method="laplacian", iterations=100000)
            calls = [stub.Smooth.future(request) for _ in range(3)]
            eventually(lambda: server.metric("burnish_queue_depth") == 2, "two jobs wait")
            self.assertEqual(server.metric("burnish_jobs_running"), 1)
            self.assertGreater(server.metric("burnish_reserved_memory_bytes"), 3 * self.noisy.stat().st_size)
            for call in calls:
                call.cancel()
            eventually(lambda: server.metric("burnish_outcomes_total", code="cancelled") == 3, "all are cancelled")

    def test_promtool_finds_nothing(self):
        with Server() as server:
            self.ask(server)
            text = server.curl("/metrics").body.decode()
        done = promtool("check", "metrics", text=text)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))
        wrong = promtool("check", "metrics", text=text + "# TYPE burnish_extra counter\nburnish_extra 1\n")
        self.assertNotEqual(wrong.returncode, 0, "promtool must be able to complain")

    def test_the_alert_rules_are_rules(self):
        done = promtool("check", "rules", "--lint=all", "--lint-fatal", RULES)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"\b[1-9]\d* rules found")

    def test_documents_name_every_metric_and_no_other(self):
        with Server() as server:
            served = families(server.curl("/metrics").body.decode())
        documented = dict(re.findall(r"^\| `(\w+)` \| (counter|gauge|histogram) \|", OPERATIONS, re.MULTILINE))
        self.assertEqual(documented, served)
        asked = [target["expr"] for panel in DASHBOARD["panels"] for target in panel["targets"]]
        for name in re.findall(r"\b(?:burnish|process)_\w+", RULES.read_text() + " ".join(asked)):
            self.assertIn(re.sub("_(bucket|sum|count)$", "", name), served)

    def test_documents_explain_every_alert_and_no_other(self):
        documented = re.findall(r"^\| `(Burnish\w+)` \|", OPERATIONS, re.MULTILINE)
        self.assertEqual(documented, re.findall(r"alert: (\w+)", RULES.read_text()))


if __name__ == "__main__":
    unittest.main()
