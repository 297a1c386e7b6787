#!/usr/bin/env python3
"""What a mesh costs a server: capacity.py BURNISHD BURNISH [TRIANGLES...]. CPU seconds and resident memory of burnishd and its
helpers per call, as a Markdown table; CPU time is much the same beside other work, so cores / seconds are calls a second."""

import http.client
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

METHODS = ("auto", "adaptive", "taubin")
LEAST_CPU_SECONDS = 1.0  # of calls for one figure


def processes(pid):
    children = (path.read_text().split() for path in pathlib.Path(f"/proc/{pid}/task").glob("*/children"))
    return [pid, *(int(child) for each in children for child in each)]


def cpu_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def peak_mb(pids, reset):
    """Since the last reset, each process's own peak, summed."""
    peak = sum(int(re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text())[1]) for pid in pids) / 1024
    if reset:
        for pid in pids:
            pathlib.Path(f"/proc/{pid}/clear_refs").write_text("5")
    return peak


def smooth(port, mesh, method):
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request("POST", f"/v1/smooth?method={method}", mesh)
    answer = connection.getresponse()
    result = answer.read()
    assert answer.status == 200, result[:300]
    connection.close()


def measure(pid, port, mesh, method):
    smooth(port, mesh, method)  # warm
    pids = processes(pid)
    peak_mb(pids, reset=True)
    calls, before = 0, sum(map(cpu_seconds, pids))
    while True:
        smooth(port, mesh, method)
        calls += 1
        used = sum(map(cpu_seconds, pids)) - before
        if used >= LEAST_CPU_SECONDS:
            return used / calls, peak_mb(pids, reset=False)


def main(burnishd, burnish, *sizes):
    print("| triangles | OBJ | method | CPU seconds a call | calls a second and core | peak memory |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        ports = pathlib.Path(folder, "ports")
        server = subprocess.Popen([burnishd, "--grpc-listen", "127.0.0.1:0", "--http-listen", "127.0.0.1:0", "--ports-file", ports,
                                   "--store", f"{folder}/store", "--workers", "1", "--log-level", "warn"])
        try:
            while not ports.exists():
                assert server.poll() is None
                time.sleep(0.05)
            port = int(json.loads(ports.read_text())["http"].rpartition(":")[2])
            for size in map(int, sizes or ("20000", "200000", "2000000")):
                file = pathlib.Path(folder, "mesh.obj")
                subprocess.run([burnish, "sample", file, "--resolution", str(round((size / 12) ** 0.5))], check=True, capture_output=True)
                mesh = file.read_bytes()
                triangles = mesh.count(b"\nf ")
                for method in METHODS:
                    seconds, peak = measure(server.pid, port, mesh, method)
                    print(f"| {triangles} | {len(mesh) / 1e6:.1f} MB | {method} | {seconds:.3g} | {1 / seconds:.3g} | {peak:.0f} MB |", flush=True)
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
