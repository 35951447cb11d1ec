# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""yaml_blocks.py ROOT: every YAML block of the documents is valid by the schema of scenarios or of studies.

A block with `base` is a study, one with `version` a whole scenario. Any other is a part of a scenario: its sections replace those of a
minimal scenario. Motions exclude each other, so `motion` is replaced as a whole."""

import json
import pathlib
import re
import sys

import jsonschema
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
import documented  # noqa: E402

MINIMAL = {
    "version": 2,
    "bone": {"source": "phantom", "side": "left"},
    "tool": {"mesh": "reamer.stl"},
    "motion": {"plunge": {}},
}


def validator(path):
    schema = json.loads(path.read_text())
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def completed(part):
    """A whole scenario of which `part` is what the page shows."""
    whole = {**MINIMAL, **part}
    if "bone" in part:
        whole["bone"] = {"source": "phantom", **part["bone"]}
    return whole


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    scenarios = validator(root / "assets/scenario.schema.json")
    studies = validator(root / "assets/study.schema.json")
    counts = {"scenario": 0, "study": 0, "part": 0}
    for page in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        text = page.read_text()
        assert not re.search(r"^    (bone|ct|tool|motion):$", documented.parts(text)[1], re.M), f"{page}: YAML without a fence"
        for block in documented.blocks(text, "yaml"):
            content = yaml.safe_load(block)
            if content is None:
                continue  # a comment alone
            kind = "study" if "base" in content else "scenario" if "version" in content else "part"
            checker = studies if kind == "study" else scenarios
            errors = list(checker.iter_errors(completed(content) if kind == "part" else content))
            assert not errors, f"{page}: {errors[0].json_path}: {errors[0].message}\n{block}"
            counts[kind] += 1
    wrong = completed({"motion": {"plunge": {"depth": 1}}})
    assert list(scenarios.iter_errors(wrong)), "the schema accepts an unknown key"
    assert min(counts.values()) >= 2, counts
    print(counts)


main()
