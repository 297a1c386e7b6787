"""What `kubectl apply -k` would send is what the Kubernetes API knows, field by field."""

import os
import pathlib
import subprocess
import unittest

from programs import NODE_MODULES, needs_npm

ROOT = pathlib.Path(__file__).parents[2]
KUSTOMIZE = pathlib.Path(os.environ["KUSTOMIZE"])
CHECK = ROOT / "tests" / "npm" / "check_manifests.cjs"
EVERYWHERE = {"ConfigMap", "Service", "Deployment", "StatefulSet", "PodDisruptionBudget", "NetworkPolicy"}


def built(folder):
    return subprocess.run([KUSTOMIZE, "build", ROOT / "docker" / "kubernetes" / folder], check=True, capture_output=True,
                          text=True).stdout


def checked(objects):
    done = subprocess.run(["node", CHECK], input=objects, env={**os.environ, "NODE_PATH": NODE_MODULES}, capture_output=True,
                          text=True)
    return done.returncode, done.stdout + done.stderr


@needs_npm
@unittest.skipUnless(KUSTOMIZE.exists(), "scripts/setup found no kustomize")
class Manifests(unittest.TestCase):
    def test_every_overlay_builds_and_fits_the_schemas(self):
        for folder, kinds in {"base": EVERYWHERE | {"HorizontalPodAutoscaler"}, "overlays/small": EVERYWHERE}.items():
            with self.subTest(folder):
                code, said = checked(built(folder))
                self.assertEqual(code, 0, said)
                self.assertEqual({line.split()[0] for line in said.splitlines()}, kinds)

    def test_overlays_change_what_they_say(self):
        base, small = built("base"), built("overlays/small")
        self.assertIn("storage: 100Gi", base)
        self.assertNotIn("storage: 100Gi", small)
        self.assertIn("storage: 5Gi", small)

    def test_mistakes_are_named(self):
        objects = built("base")
        for right, wrong, said in [
                ("  replicas: 3\n", "  replicas: three\n", "StatefulSet burnish: data/spec/replicas must be integer"),
                ("  replicas: 3\n", "  replica: 3\n", "StatefulSet burnish: /spec/replica is no field of it"),
                ("    kind: StatefulSet\n    name: burnish\n", "    kind: StatefulSet\n",
                 "HorizontalPodAutoscaler burnish: data/spec/scaleTargetRef must have required property name"),
                ("kind: StatefulSet\nmetadata", "kind: StatefulSets\nmetadata", "apps/v1 has no kind StatefulSets"),
                ("apiVersion: policy/v1\n", "apiVersion: policies/v1\n", "policies/v1 has no kind PodDisruptionBudget")]:
            with self.subTest(wrong):
                self.assertIn(right, objects)
                code, found = checked(objects.replace(right, wrong, 1))
                self.assertEqual(code, 1)
                self.assertIn(said, found)


if __name__ == "__main__":
    unittest.main()
