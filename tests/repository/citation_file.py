# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""citation_file.py ROOT VERSION: CITATION.cff is valid by the schema of the Citation File Format 1.2.0, names the version of the program
and the paper, and the other places name that version too. The references of the program and of paper/paper.bib that have the same key
are the same work."""

import json
import pathlib
import re
import sys

import jsonschema
import yaml

# Unchanged; docs/third-party.md says where it is from.
SCHEMA = pathlib.Path(__file__).with_name("cff-1.2.0.schema.json")


def complaints_of(cff):
    """What the schema says of a citation; dates as the text that they are in the file."""
    validator = jsonschema.Draft7Validator(json.loads(SCHEMA.read_text()), format_checker=jsonschema.draft7_format_checker)
    return [error.message for error in validator.iter_errors(json.loads(json.dumps(cff, default=str)))]


def check(cff):
    jsonschema.Draft7Validator.check_schema(json.loads(SCHEMA.read_text()))
    assert not complaints_of(cff), complaints_of(cff)
    reference = cff["references"][0]
    for change in ({"cff-version": "1.3"}, {"authors": []}, {"colour": "red"}, {"authors": [{"title": "Dr"}]}, {"title": ""},
                   {"date-released": "26 November 2026"}, {"references": [{**reference, "doi": "https://doi.org/10.1016/x"}]}):
        assert complaints_of({**cff, **change}), f"not found: {change}"


def fields_of(text, entry, field):
    """Per key of an entry, what its fields say, in one spelling: without braces, dashes and case."""
    found = {}
    for key, body in re.findall(entry, text, re.S):
        fields = dict(re.findall(field, body))
        found[key] = {name: re.sub(r"[{}]", "", value).replace("--", "-").lower() for name, value in fields.items()}
    return found


def check_references(root):
    """`reamsim cite` and the paper must not name different works by the same key. Pages may be more exact in one of them."""
    program = fields_of((root / "sim/record/references.cpp").read_text(), r'\.key = "(\w+)",(.*?)(?=\.key = |std::string joined)',
                        r'\.(title|year|journal|volume|doi) =\s+"?((?<=")[^"]*|\d+)')
    paper = fields_of((root / "paper/paper.bib").read_text(), r"@\w+\{(\w+),(.*?)\n\}",
                      r"(title|year|journal|volume|doi) *= \{(.*)\}")
    common = set(program) & set(paper)
    assert {"faieghi2020", "museth2013", "jaaskelainen2015", "armato2015"} <= common, common
    for key in common:
        for name in set(program[key]) & set(paper[key]):
            assert program[key][name] == paper[key][name], f"{key}: {program[key][name]} and {paper[key][name]}"
        assert {"title", "year", "doi"} <= set(program[key]) & set(paper[key]), key


def main():
    root, version = pathlib.Path(sys.argv[1]), sys.argv[2]
    cff = yaml.safe_load((root / "CITATION.cff").read_text())
    check(cff)
    assert cff["version"] == version, f"CITATION.cff has {cff['version']}, the program {version}"
    assert cff["license"] in (root / ".reuse/dep5").read_text()
    assert f'.title = "{cff["title"]}"' in (root / "sim/record/citation.cpp").read_text()
    # The same work as in the program and in README.
    doi = cff["references"][0]["doi"]
    for place in ("sim/record/references.cpp", "README.md"):
        assert doi in (root / place).read_text(), place
    check_references(root)
    assert f"## [{version}]" in (root / "CHANGELOG.md").read_text()


main()
