"""The engine that docker/test found, and what the tests run in it. Everything has this run's own names."""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shutil
import secrets
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).parents[2]
ENGINE = os.environ.get("ENGINE", "docker")
BURNISH = str(ROOT / "build/release/bin/burnish")
STUBS = str(ROOT / "build/release/tests/e2e/stubs")
sys.path.insert(0, STUBS)
sys.path.append(str(ROOT / "tests/e2e"))
ENVIRONMENT = {**os.environ, "no_proxy": "127.0.0.1,localhost", "NO_PROXY": "127.0.0.1,localhost"}
PATIENCE_SECONDS = 60
HAS_PAGE = (ROOT / "client/web/node_modules/installed.json").exists()  # there is a registry of npm
COMPOSE = ["docker-compose"] if ENGINE == "podman" else [ENGINE, "compose"]  # over podman's socket
HTTP, GRPC, PROMETHEUS = 8080, 50051, 9090  # of the compose files


def engine(*arguments, check=True, timeout=120):
    done = subprocess.run([ENGINE, *map(str, arguments)], capture_output=True, text=True, timeout=timeout)
    if check and done.returncode != 0:
        raise AssertionError(f"{ENGINE} {' '.join(map(str, arguments))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def eventually(ready, what, seconds=PATIENCE_SECONDS):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        result = ready()
        if result:
            return result
        time.sleep(0.02)
    raise AssertionError(f"not within {seconds} s: {what}")


def tell(test, **figures):
    """What the log of docker/test shows of a test beside ok."""
    print(f"\n  {test}: " + ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in figures.items()),
          file=sys.stderr, flush=True)


class Secrets:
    """A token, as docker/make-token makes it."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        script = folder / "make-token"
        script.write_bytes((ROOT / "docker/make-token").read_bytes())
        subprocess.run(["bash", script], check=True, capture_output=True)
        self.token_file, self.tokens_file = folder / "secrets/burnish_token", folder / "secrets/burnish_tokens"
        self.token = self.token_file.read_text()
        self.headers = {"Authorization": f"Bearer {self.token}"}


def call(port, verb, target, body=None, headers=None, timeout=PATIENCE_SECONDS):
    """Status, headers and body of an HTTP call; status 0 when there is no answer."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=timeout)
    try:
        connection.request(verb, target, body, headers or {})
        answer = connection.getresponse()
        return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
    except (OSError, http.client.HTTPException):
        return 0, {}, b""
    finally:
        connection.close()


def sample(path, resolution=32):
    subprocess.run([BURNISH, "sample", str(path), "--amplitude", "0.3", "--resolution", str(resolution)], check=True,
                   capture_output=True)
    return pathlib.Path(path).read_bytes()


class Burnishd:
    """One container of the image as docker/compose.yaml runs it; gone afterwards, with its volume unless that is given."""

    HTTP, GRPC = 18080, 15051

    def __init__(self, keys, *flags, volume=None, store=None, environment=None, network=None):
        self.keys = keys
        self.name = f"burnish-test-{secrets.token_hex(4)}"
        self.volume = volume or self.name
        self.own_volume = volume is None
        self.flags, self.environment = flags, environment or {}
        self.network = ["--network", network] if network else []
        self.store = store or ["-v", f"{self.volume}:/var/lib/burnish"]

    def start(self):
        variables = [part for name, value in self.environment.items() for part in ("-e", f"{name}={value}")]
        engine("run", "-d", "--name", self.name, "--read-only", "--tmpfs", "/tmp", "--cap-drop", "ALL", "--security-opt",
               "no-new-privileges", "-v", f"{self.keys.tokens_file}:/run/secrets/burnish_tokens:ro", *self.store, *variables, *self.network,
               "-p", f"127.0.0.1:{self.HTTP}:8080", "-p", f"127.0.0.1:{self.GRPC}:50051", "burnish", *self.flags)
        return self

    def __enter__(self):
        self.start()
        eventually(self.ready, f"{self.name} is ready")
        return self

    def __exit__(self, *_):
        engine("rm", "-f", self.name, check=False)
        if self.own_volume:
            engine("volume", "rm", "-f", self.volume, check=False)

    def ready(self):
        status = self.inspect()["State"]
        assert status["Status"] not in ("exited", "dead"), self.log()
        return call(self.HTTP, "GET", "/readyz")[0] == 200

    def inspect(self):
        return json.loads(engine("inspect", self.name).stdout)[0]

    def log(self):
        done = engine("logs", self.name, check=False)
        return done.stdout + done.stderr

    def exit_code(self):
        eventually(lambda: self.inspect()["State"]["Status"] == "exited", f"{self.name} ends")
        return self.inspect()["State"]["ExitCode"]

    def call(self, verb, target, body=None, headers=None):
        return call(self.HTTP, verb, target, body, {**self.keys.headers, **(headers or {})})

    def job(self, identity):
        return json.loads(self.call("GET", f"/v1/jobs/{identity}", headers={"Prefer": "wait=5"})[2])

    def processes(self):
        """Of the container: burnishd and its helpers."""
        first = self.inspect()["State"]["Pid"]
        children = pathlib.Path(f"/proc/{first}/task/{first}/children").read_text().split()
        return [first, *map(int, children)]

    def memory_mb(self):
        def share(pid):
            rollup = pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text()
            return int(re.search(r"^Pss:\s+(\d+)", rollup, re.M)[1]) / 1024
        return sum(map(share, self.processes()))


@contextlib.contextmanager
def new_secrets():
    with tempfile.TemporaryDirectory(prefix="burnish-containers-") as folder:
        yield Secrets(folder)


@contextlib.contextmanager
def checks_run():
    """Podman runs no health check by itself where there is no systemd."""
    stop = threading.Event()

    def check():
        while ENGINE == "podman" and not stop.wait(0.2):
            for name in engine("ps", "--format", "{{.Names}}").stdout.split():
                engine("healthcheck", "run", name, check=False)

    checking = threading.Thread(target=check)
    checking.start()
    try:
        yield
    finally:
        stop.set()
        checking.join()


class Compose:
    """A compose file as it stands, with secrets of this run beside it; all of it is gone afterwards. The images are there."""

    def __init__(self, file):
        self.folder = tempfile.TemporaryDirectory(prefix="burnish-compose-")
        self.file = shutil.copy(ROOT / "docker" / file, self.folder.name)
        self.keys = Secrets(self.folder.name)

    def run(self, *arguments):
        done = subprocess.run([*COMPOSE, "-f", self.file, *arguments], capture_output=True, text=True, cwd=self.folder.name,
                              timeout=180)
        assert done.returncode == 0, done.stdout + done.stderr

    def __enter__(self):
        try:
            with checks_run():
                self.run("up", "-d", "--no-build")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.run("down", "-v")
        self.folder.cleanup()

    def container(self, service):
        names = engine("ps", "-a", "--format", "{{.Names}}").stdout.split()
        return next(name for name in names if name.endswith((f"_{service}_1", f"-{service}-1")))


def prometheus_targets():
    """How many burnishd Prometheus scrapes without an error."""
    status, _, body = call(PROMETHEUS, "GET", "/api/v1/query?query=count(up%7Bjob%3D%22burnish%22%7D%3D%3D1)")
    result = json.loads(body)["data"]["result"] if status == 200 else []
    return int(result[0]["value"][1]) if result else 0
