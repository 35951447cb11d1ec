# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""schema_test.py SCHEMA STUDY...: the schema of studies accepts the shipped ones and refuses mistakes."""

import copy
import json
import sys

import jsonschema
import yaml


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    for path in sys.argv[2:]:
        with open(path, encoding="utf-8") as file:
            study = yaml.safe_load(file)
        errors = list(validator.iter_errors(study))
        assert not errors, f"{path}: {errors[0].message}"
        for change in (
            {"vari": []},
            {"keep": ["picture"]},
            {"vary": [{"motion.plunge.dept_mm": [1]}]},
            {"vary": [{"motion.plunge.depth_mm": 1}]},
            {"vary": [{"zip": {"motion.plunge.depth_mm": []}}]},
            {"sample": {"n": 2}},
            {"sample": {"n": 2, "of": {"cutting.normal_ratio": {"gauss": [0, 1]}}}},
            {"sample": {"n": 2, "of": {"cutting.normal_ratio": {"normal": [0]}}}},
        ):
            wrong = copy.deepcopy(study) | change
            assert list(validator.iter_errors(wrong)), f"accepted: {change}"
        good = study | {"sample": {"n": 2, "of": {"motion.plunge.axis": {"tilt_sd_deg": 2}}}, "keep": "forces"}
        assert not list(validator.iter_errors(good))


main()
