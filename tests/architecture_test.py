"""Who may include what: core knows no network and no contract, the client library no core."""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)

# folder: what its files must not include
FORBIDDEN = {
    "core": r"(server|client|tests|burnish/v1|grpc|grpcpp|google|httplib|spdlog|prometheus|nlohmann)",
    "server/service": r"(client|server/(grpc|http|jobs|observe)|grpc|grpcpp|httplib)",
    "server/jobs": r"(client|server/(grpc|http)/|grpc|grpcpp|httplib)",
    "server/store": r"(client|server/(grpc|http|jobs|service|observe)|grpc|grpcpp|httplib)",
    "server/security": r"(client|server/(grpc|jobs|service)|grpc|grpcpp|httplib)",
    "server/sandbox": r"(client|server/(grpc|http|jobs|observe|security)|grpc|grpcpp|httplib)",
    "server/grpc": r"(client|server/http|httplib)",
    "server/http": r"(client|server/grpc|grpc|grpcpp)",
    "client/render": r"(server|client/(?!render)|burnish/v1|grpc|grpcpp|google|nlohmann|CLI)",
    "client/*": r"(core|server|client/cli|httplib|draco)",
}

# The one file of core that reads JSON: a format's, not the contract's.
JSON_OF_GLTF = ("core/io/glb_json.cpp", "nlohmann/json.hpp")


class Architecture(unittest.TestCase):
    def test_no_file_includes_what_its_layer_must_not_know(self):
        seen = 0
        for prefix, pattern in FORBIDDEN.items():
            folder = ROOT / prefix
            files = folder.rglob("*.*") if folder.is_dir() else folder.parent.glob(folder.name + ".*")
            for path in (p for p in files if p.suffix in (".h", ".cpp")):
                seen += 1
                for name in INCLUDE.findall(path.read_text()):
                    if (path.relative_to(ROOT).as_posix(), name) == JSON_OF_GLTF:
                        continue
                    self.assertIsNone(re.match(pattern + r"\b", name), f"{path.relative_to(ROOT)} includes {name}")
        self.assertGreater(seen, 50)

    def test_one_file_alone_compiles_httplib(self):
        includes = {path.relative_to(ROOT).as_posix(): set(INCLUDE.findall(path.read_text()))
                    for top in ("core", "server", "client") for path in (ROOT / top).rglob("*.*")
                    if path.suffix in (".h", ".cpp")}
        users = {"httplib.h"}
        while more := {name for name, of in includes.items() if of & users} - users:
            users |= more
        self.assertEqual([name for name in users if name.endswith(".cpp")], ["server/http/conversation.cpp"])


if __name__ == "__main__":
    sys.exit(unittest.main())
