"""share/carillon/openapi.json is what `carillon serve` does: every answer is of its schema, nothing is
answered that it does not name. Workers that crash or take too long cost their own request alone."""
import concurrent.futures
import json
import os
import re
import signal
import struct
import subprocess
import time

import jsonschema
from program import CARILLON, CONFIGS, FolderTest, run, run_json
from server import CONFIG, Server, ringing, wav_bytes

DOCUMENT = json.loads((CONFIGS.parent / "share/carillon/openapi.json").read_text())


def form(parts):
    return b"".join(b"--x\r\nContent-Disposition: form-data; name=\"%s\"; filename=\"a\"\r\n\r\n%s\r\n" % part
                    for part in parts) + b"--x--\r\n"


FORM = {"Content-Type": "multipart/form-data; boundary=x"}


class ServiceApi(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "small.yaml").write_text(CONFIG)
        assert run("build", "small.yaml", cwd=cls.folder).returncode == 0
        cls.clip = wav_bytes(ringing())
        cls.server = Server("small", "--jobs", "jobs", "--workers", "2", "--time-limit", "30", cwd=cls.folder)

    @classmethod
    def tearDownClass(cls):
        code, err = cls.server.stop()
        super().tearDownClass()
        assert code == 0, err

    def schema_of(self, path, method, status, kind):
        for pattern, methods in DOCUMENT["paths"].items():
            if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", pattern), path.split("?")[0]):
                response = methods[method]["responses"][str(status)]
                if "$ref" in response:
                    response = DOCUMENT["components"]["responses"][response["$ref"].rsplit("/", 1)[1]]
                return response["content"][kind]["schema"]
        raise AssertionError(f"{path} is not in the document")

    def ask(self, path, body=None, headers=None, method=None):
        """The answer, once it is of its schema."""
        status, text = self.server.ask(path, body, headers, method)
        told = json.loads(text)
        schema = self.schema_of(path, (method or ("get" if body is None else "post")).lower(), status,
                                "application/json")
        jsonschema.validate(told, {**schema, "components": DOCUMENT["components"]})
        return status, told

    def test_answers_are_of_their_schemas(self):
        sound = {"reference": self.clip, "other": wav_bytes(ringing(pitch=1.01))}
        both = form((name.encode(), data) for name, data in sound.items())
        job = self.ask("/v1/jobs", CONFIG.encode())[1]["id"]
        for status, path, *request in [
            (200, "/v1/health"), (200, "/v1/datasets"), (200, "/v1/openapi.json"), (200, "/v1/jobs"),
            (200, f"/v1/jobs/{job}"), (404, "/v1/jobs/77"), (404, "/v1/jobs/77", None, None, "DELETE"),
            (403, "/v1/features", self.clip, {"Origin": "http://elsewhere.example"}),
            (200, "/v1/features", self.clip), (400, "/v1/features?max_featurs=1", self.clip),
            (200, "/v1/fit?model=power&estimator=least_squares", self.clip), (400, "/v1/fit?model=x", self.clip),
            (200, "/v1/compare", both, FORM), (400, "/v1/compare", self.clip),
            (501, "/v1/identify", self.clip),
            (200, "/v1/newest?folder=small&count=2"), (404, "/v1/newest?folder=.."),
            (400, "/v1/newest?folder=small&count=99"), (200, "/v1/strike?dataset=small&object=bar-000&as=json"), (400, "/v1/strike?object=cow"),
            (400, "/v1/score", b"sample,class"), (202, "/v1/score?dataset=small&task=material&entry=a", b"sample,class"),
            (400, "/v1/jobs", b"a: ["), (202, "/v1/jobs", CONFIG.encode()),
        ]:
            with self.subTest(path, status=status):
                self.assertEqual(self.ask(path, *request)[0], status)
        for number in range(job, job + 3):
            self.server.job(number)
            self.ask(f"/v1/jobs/{number}")
        self.assertEqual(self.ask(f"/v1/jobs/{job}", method="DELETE")[0], 400)
        status, page = self.server.ask("/")
        self.assertEqual((status, page[:15].lower()), (200, b"<!doctype html>"))

    def test_the_document_names_what_is_answered(self):
        _, told = self.ask("/v1/openapi.json")
        self.assertEqual(told, DOCUMENT)
        jsonschema.validate({"error": {"message": "x"}}, {"$ref": "#/components/schemas/Error", **DOCUMENT})
        # No path that it names is unknown, whatever is wrong with the request; no other method is taken.
        for path, methods in DOCUMENT["paths"].items():
            path = path.replace("{id}", "1")
            for method in ("get", "post", "delete"):
                if path == "/v1/events":
                    continue
                with self.subTest(path, method=method):
                    status, body = self.server.ask(path, b"" if method == "post" else None, method=method.upper())
                    known = method in methods
                    unknown = status == 404 and b"no such page" in body
                    self.assertEqual(known, not unknown, (status, body[:200]))
        # Options are those of the document.
        for path in ("/v1/features", "/v1/fit", "/v1/compare"):
            named = {one["name"] for one in DOCUMENT["paths"][path]["post"]["parameters"]}
            body, headers = (form([(b"reference", self.clip), (b"other", self.clip)]), FORM) \
                if path.endswith("compare") else (self.clip, None)
            _, told = self.server.ask_json(path + "?none=1", body, headers)
            self.assertEqual(set(told["error"]["hint"].removeprefix("there are ").split(", ")), named, path)

    def test_struck(self):
        status, sound = self.server.ask("/v1/strike?dataset=small&object=bar-000/steel/1&at=0,0,0&seed=3", method="POST", data=b"")
        self.assertEqual(status, 200, sound)
        self.assertEqual(sound[:4], b"RIFF")
        self.assertEqual(struct.unpack("<I", sound[24:28])[0], 22050)
        again = self.server.ask("/v1/strike?dataset=small&object=bar-000&at=0,0,0&seed=3")[1]
        self.assertEqual(sound, again)
        # What its features are is what its modes are.
        modes = run_json("modes", "bell", "-m", "bell_bronze", "--max-frequency", "22050 Hz", cwd=self.folder)
        status, bell = self.server.ask("/v1/strike?object=bell&material=bell_bronze&gain=100")
        self.assertEqual(status, 200, bell)
        found = self.server.ask_json("/v1/features?max_features=1", bell)[1]["features"][0]["frequency_hz"]
        nearest = min(abs(mode["frequency_hz"] / found - 1) for mode in modes["modes"])
        self.assertLess(nearest, 1e-3)
        for query, message in [("object=bar-000&at=1,2", "2 values instead of three"), ("object=bar&x=1", 'no option "x"'),
                               ("object=bar-", 'no object "bar-"'), ("", "no object"),
                               ("object=bell&material=cheese", "cheese"),
                               ("object=/etc/passwd&material=steel", "/etc/passwd"),
                               ("object=turned:profile=a.csv&material=steel", "come from files"),
                               ("object=bar-000&direction=0,0,0", "no length"), ("object=bar-000&as=mp3", "as is")]:
            status, told = self.server.ask_json("/v1/strike?dataset=small&" + query if "material" not in query else
                                                   "/v1/strike?" + query)
            self.assertEqual(status, 400, told)
            self.assertIn(message, told["error"]["message"])

    def test_a_worker_that_crashes_costs_its_own_request(self):
        server = Server("small", "--workers", "1", cwd=self.folder)
        try:
            long = wav_bytes(ringing(20))
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                replies = [pool.submit(server.ask_json, "/v1/features", long) for _ in range(2)]
                (worker,) = server.workers()
                time.sleep(0.3)
                os.kill(worker, signal.SIGKILL)
                codes = sorted(reply.result()[0] for reply in replies)
            self.assertEqual(codes, [200, 500])
            self.assertIn("signal 9", next(r.result()[1] for r in replies if r.result()[0] == 500)["error"]["message"])
            self.assertNotEqual(server.workers(), [worker])
        finally:
            self.assertEqual(server.stop()[0], 0)

    def test_what_takes_too_long(self):
        server = Server("small", "--workers", "1", "--time-limit", "0.2", cwd=self.folder)
        try:
            status, told = server.ask_json("/v1/features", wav_bytes(ringing(20)))
            self.assertEqual((status, told["error"]["hint"]), (504, "carillon serve --time-limit"), told)
            self.assertEqual(server.ask("/v1/strike?object=bar-000")[0], 200)
        finally:
            self.assertEqual(server.stop()[0], 0)

    def test_workers_that_cannot_start(self):
        result = run("serve", "small", "--models", "none", "--port", "0", cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertRegex(result.stderr, "none|carillon-learn, which is not installed")

    def test_answers_on_a_stream(self):
        question = json.dumps({"path": "/v1/features", "query": {"max_features": "1"}, "parts": [["", len(self.clip)]]})
        done = subprocess.run([CARILLON, "answer"], input=question.encode() + b"\n" + self.clip, capture_output=True,
                              timeout=100, check=True)
        ready, _, rest = done.stdout.partition(b"\n")
        told, rest = rest[:json.loads(ready)["bytes"]], rest[json.loads(ready)["bytes"]:]
        self.assertTrue(json.loads(told)["ready"])
        header, _, body = rest.partition(b"\n")
        self.assertEqual(json.loads(header), {"status": 200, "type": "application/json", "bytes": len(body)})
        self.assertEqual(len(json.loads(body)["features"]), 1)
        wrong = subprocess.run([CARILLON, "answer"], input=b"{\n", capture_output=True, timeout=100, check=True)
        self.assertIn(b"a line is no request", wrong.stdout)


if __name__ == "__main__":
    import unittest
    unittest.main()
