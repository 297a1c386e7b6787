"""GET /openapi.json is right: the linter agrees, and every path, verb and error answers as it says."""

import base64
import copy
import json
import pathlib
import subprocess
import unittest

from jsonschema import Draft202012Validator, RefResolver

from programs import ENVIRONMENT, NODE_MODULES, PATIENCE_SECONDS, MeshTest, Server, needs_npm

LINT = pathlib.Path(__file__).parents[1] / "npm" / "lint_openapi.cjs"
VERBS = ("get", "head", "post", "patch", "delete", "options")


def closed(schema):
    """The schema with every object's properties as the only ones, so that what is not described is found."""
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    result = {name: closed(member) for name, member in schema.items()}
    if isinstance(schema.get("properties"), dict):
        result.setdefault("additionalProperties", False)
    return result


def every_schema(node):
    if isinstance(node, list):
        for item in node:
            yield from every_schema(item)
    elif isinstance(node, dict):
        for name, member in node.items():
            if name == "schema":
                yield member
            yield from every_schema(member)


class Document:
    def __init__(self, text):
        self.text = text
        self.json = json.loads(text)
        self.resolver = RefResolver.from_schema(copy.deepcopy(self.json) | {
            "components": self.json["components"] | {"schemas": closed(self.json["components"]["schemas"])}})

    def resolve(self, node):
        return self.resolver.resolve(node["$ref"])[1] if "$ref" in node else node

    def operations(self):
        for path, item in self.json["paths"].items():
            for verb, operation in item.items():
                yield path, verb, operation

    def response(self, path, verb, status):
        """What the document says of this status; a range such as 4XX serves where there is no more precise word."""
        responses = self.json["paths"][path][verb]["responses"]
        found = responses.get(str(status)) or responses.get(f"{status // 100}XX")
        return found and self.resolve(found)

    def validate(self, schema, value):
        Draft202012Validator(closed(schema), resolver=self.resolver).validate(value)


class OpenApi(MeshTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server = Server("--cors-origin", "https://scans.example", "--max-bytes", 1000000)
        cls.addClassCleanup(cls.server.__exit__, None)
        cls.document = Document(cls.server.curl("/openapi.json").body.decode())
        cls.drc = cls.folder / "noisy.drc"
        cls.drc.write_bytes(cls.server.post(cls.noisy, "iterations=0&output=drc").body)

    def expect(self, path, verb, status, *flags, query="", place=None):
        """Calls, and holds the answer against the document."""
        shape = {"head": ["--head"], "get": []}.get(verb, ["-X", verb.upper()])
        answer = self.server.curl((place or path) + query, *shape, *flags)
        self.assertEqual(answer.status, status, answer.body[:500])
        response = self.document.response(path, verb, status)
        self.assertIsNotNone(response, f"{verb} {path} documents no {status}")
        for name, header in response.get("headers", {}).items():
            value = answer.headers.get(name.lower())
            if name in ("Burnish-Request-Id", "Allow"):
                self.assertIsNotNone(value, name)
            if value is not None:
                self.validate_header(self.document.resolve(header), value)
        if verb != "head" and response.get("content"):
            self.validate_body(response["content"], answer)
        return answer

    def validate_header(self, header, value):
        if "content" in header:
            self.document.validate(header["content"]["application/json"]["schema"], json.loads(value))
        else:
            kind = header["schema"]["type"]
            self.document.validate(header["schema"], int(value) if kind == "integer" else value)

    def validate_body(self, content, answer):
        media_type = answer.headers["content-type"].split(";")[0]
        self.assertIn(media_type, content)
        schema = content[media_type].get("schema", {})
        if media_type.endswith("json"):
            self.document.validate(schema, json.loads(answer.body))
        elif schema:
            self.document.validate(schema, answer.body.decode())

    def form(self, **files):
        return [flag for name, path in files.items() for flag in ("-F", f"{name}=@{path}")]

    @needs_npm
    def test_the_linter_finds_nothing(self):
        done = subprocess.run(["node", LINT], input=self.document.text, capture_output=True, text=True,
                              env={**ENVIRONMENT, "NODE_PATH": NODE_MODULES}, timeout=PATIENCE_SECONDS)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    @needs_npm
    def test_the_linter_finds_mistakes(self):
        broken = copy.deepcopy(self.document.json)
        broken["paths"]["/v1/smooth"]["post"]["operationId"] = "compare"  # as another is called
        done = subprocess.run(["node", LINT], input=json.dumps(broken), capture_output=True, text=True,
                              env={**ENVIRONMENT, "NODE_PATH": NODE_MODULES}, timeout=PATIENCE_SECONDS)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("operation-operationId-unique", done.stdout)

    def test_schemas_are_json_schema_2020_12(self):
        schemas = [*self.document.json["components"]["schemas"].values(), *every_schema(self.document.json)]
        self.assertGreater(len(schemas), 50)
        for schema in schemas:
            Draft202012Validator.check_schema(schema)

    def test_every_operation_answers_as_documented(self):
        mesh = ["-H", "Content-Type: model/obj", "--data-binary", f"@{self.noisy}"]
        bodies = {"/v1/smooth": mesh, "/v1/compare": self.form(reference=self.clean, mesh=self.noisy)}
        for path, verb, _ in self.document.operations():
            if path.startswith(("/v1/jobs", "/v1/uploads")) and verb != "options":
                continue  # test_jobs_and_uploads_answer_as_documented
            with self.subTest(f"{verb} {path}"):
                self.expect(path, verb, 204 if verb == "options" else 200,
                            *(bodies[path] if verb == "post" else []))

    def test_jobs_and_uploads_answer_as_documented(self):
        def expect(path, verb, status, *flags, **ids):
            return self.expect(path, verb, status, *flags, place=path.replace("{id}", ids.get("id", "")))
        mesh = ["-H", "Content-Type: model/obj", "--data-binary", f"@{self.noisy}"]
        job = json.loads(expect("/v1/jobs", "post", 202, *mesh).body)["id"]
        expect("/v1/jobs", "get", 200)
        expect("/v1/jobs", "head", 200)
        done = json.loads(expect("/v1/jobs/{id}", "get", 200, "-H", "Prefer: wait=60", id=job).body)
        self.assertEqual(done["state"], "JOB_STATE_SUCCEEDED")
        expect("/v1/jobs/{id}", "get", 303, "-H", "Accept: model/obj", id=job)
        for path in "/v1/jobs/{id}", "/v1/jobs/{id}/mesh", "/v1/jobs/{id}/report":
            expect(path, "get", 200, id=job)
            expect(path, "head", 200, id=job)
        expect("/v1/jobs/{id}/mesh", "get", 206, "-r", "0-9", id=job)
        expect("/v1/jobs/{id}/mesh", "get", 416, "-r", "99999999-", id=job)
        expect("/v1/jobs/{id}/mesh", "get", 304, "-H", f'If-None-Match: "{done["result"]["sha256"]}"', id=job)
        expect("/v1/jobs/{id}/events", "get", 200, id=job)
        expect("/v1/jobs/{id}", "delete", 204, id=job)
        expect("/v1/jobs/{id}", "get", 404, id=job)
        self.expect("/v1/jobs", "post", 404, query=f"?mesh_sha256={'0' * 64}")
        upload = json.loads(expect("/v1/uploads", "post", 201, "-H", "Upload-Length: 20").body)["id"]
        part = ["-H", "Content-Type: application/partial-upload", "--data-binary", "v 0 0 0"]
        expect("/v1/uploads/{id}", "patch", 200, "-H", "Upload-Offset: 0", *part, id=upload)
        expect("/v1/uploads/{id}", "patch", 409, "-H", "Upload-Offset: 0", *part, id=upload)
        expect("/v1/uploads/{id}", "get", 200, id=upload)
        expect("/v1/uploads/{id}", "head", 200, id=upload)
        expect("/v1/uploads/{id}", "delete", 204, id=upload)
        expect("/v1/uploads/{id}", "get", 404, id=upload)

    def test_every_other_verb_is_refused(self):
        for path, item in self.document.json["paths"].items():
            for verb in [v for v in (*VERBS, "put") if v not in item]:
                with self.subTest(f"{verb} {path}"):
                    answer = self.server.curl(path, *(["--head"] if verb == "head" else ["-X", verb.upper()]))
                    self.assertEqual(answer.status, 405)
                    allowed = {name.strip().lower() for name in answer.headers["allow"].split(",")}
                    self.assertEqual(allowed, set(item))

    def test_every_media_type_of_meshes_is_taken_and_given(self):
        operation = self.document.json["paths"]["/v1/smooth"]["post"]
        output = next(p for p in operation["parameters"] if p.get("name") == "output")
        files = {"application/octet-stream": self.drc}
        for ending in output["schema"]["enum"]:
            answer = self.server.post(self.noisy, f"iterations=0&output={ending}")
            self.assertEqual(answer.status, 200, answer.body[:500])
            files[answer.headers["content-type"]] = self.folder / f"noisy.{ending}"
            files[answer.headers["content-type"]].write_bytes(answer.body)
        self.assertLessEqual(set(files), set(operation["requestBody"]["content"]))
        for sent in operation["requestBody"]["content"]:
            flags = (["-H", f"Content-Type: {sent}", "--data-binary", f"@{files[sent]}"] if sent in files else
                     self.form(mesh=self.noisy, reference=self.clean))
            self.expect("/v1/smooth", "post", 200, *flags)
        for wanted in operation["responses"]["200"]["content"]:
            answer = self.expect("/v1/smooth", "post", 200, "-H", f"Accept: {wanted}", "--data-binary",
                                 f"@{files.get(wanted, self.noisy)}")
            self.assertEqual(answer.headers["content-type"], wanted)

    def test_json_holds_the_same_mesh(self):
        options = {"method": "taubin", "iterations": 5, "parameters": {"lambda": 0.4}, "output": {"format": "drc"}}
        schema = self.document.json["components"]["schemas"]["SmoothOptions"]
        self.document.validate(schema, options)
        flags = [*self.form(mesh=self.noisy), "-F", f"options={json.dumps(options)};type=application/json"]
        raw = self.expect("/v1/smooth", "post", 200, *flags)
        answer = json.loads(self.expect("/v1/smooth", "post", 200, "-H", "Accept: application/json", *flags).body)
        self.assertEqual(base64.b64decode(answer["mesh"]), raw.body)
        self.assertEqual(answer["report"]["parameters"]["lambda"], 0.4)
        self.assertEqual(answer["format"], "MESH_FORMAT_DRACO")

    def test_errors_are_documented_problems(self):
        mesh = ["--data-binary", f"@{self.noisy}"]
        broken = self.folder / "broken.obj"
        broken.write_text("v 0 0 0\nf 1 2 3\n")
        large = self.folder / "large.obj"
        large.write_bytes(b"# " + b"x" * 1000000)
        options = [*self.form(mesh=self.noisy), "-F", 'options={"output":{"draco":{"speed":-1}}}']
        rows = [("/v1/smooth", 400, "unknown_option", "?colour=red", mesh, "colour"),
                ("/v1/smooth", 400, "unknown_method", "?method=sanding", mesh, "method"),
                ("/v1/smooth", 400, "bad_option", "", options, "options.output.draco.speed"),
                ("/v1/smooth", 400, "bad_option", "", self.form(reference=self.noisy), "mesh"),
                ("/v1/smooth", 406, "not_acceptable", "", ["-H", "Accept: text/html", *mesh], None),
                ("/v1/smooth", 413, "too_large", "", ["--data-binary", f"@{large}"], None),
                ("/v1/smooth", 415, "unsupported_format", "", ["-H", "Content-Type: image/png", *mesh], None),
                ("/v1/smooth", 422, "index_out_of_range", "", ["--data-binary", f"@{broken}"], None),
                ("/v1/smooth", 504, "deadline_exceeded", "?method=laplacian&iterations=100000&timeout_ms=5", mesh,
                 None),
                ("/v1/compare", 415, "unsupported_format", "", mesh, None),
                ("/v1/compare", 400, "bad_option", "", self.form(mesh=self.noisy), "reference"),
                ("/v1/compare", 422, "index_out_of_range", "", self.form(mesh=broken, reference=self.noisy), None)]
        for path, status, code, query, flags, field in rows:
            with self.subTest(f"{path}{query} {code}"):
                problem = self.expect(path, "post", status, *flags, query=query).problem
                self.assertEqual((problem["code"], problem.get("field")), (code, field))

    def test_pages_of_listed_origins_may_call(self):
        def preflight(origin):
            return self.expect("/v1/smooth", "options", 204, "-H", f"Origin: {origin}", "-H",
                               "Access-Control-Request-Method: POST").headers
        headers = preflight("https://scans.example")
        self.assertEqual(headers["access-control-allow-origin"], "https://scans.example")
        self.assertIn("POST", headers["access-control-allow-methods"])
        self.assertNotIn("access-control-allow-origin", preflight("https://other.example"))

    def test_the_log_names_the_callers_ids(self):
        self.expect("/v1/smooth", "post", 200, "-H", "Burnish-Request-Id: scan-7", "-H",
                    "traceparent: 00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01", "--data-binary",
                    f"@{self.noisy}")
        lines = [line for line in self.server.log_text().splitlines() if "scan-7" in line]
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("4bf92f3577b34da6a3ce929d0e0e4736", lines[0])


if __name__ == "__main__":
    unittest.main()
