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


def plain(value):
    """What a field says, in one spelling: without braces, dashes and case."""
    return re.sub(r"[{}]", "", str(value)).replace("--", "-").lower()


def fields_of(item):
    """The fields of an item of CSL-JSON by their names in BibTeX."""
    values = {"title": item["title"], "year": item.get("issued", {}).get("date-parts", [[None]])[0][0], "volume": item.get("volume"),
              "journal": item.get("container-title", item.get("publisher")), "doi": item.get("DOI")}
    return {name: plain(value) for name, value in values.items() if value}


def check_references(root):
    """`reamsim cite` and the paper must not name different works by the same key. Pages may be more exact in one of them."""
    references = json.loads((root / "sim/record/references.json").read_text())
    program = {item["id"]: fields_of(item) for item in [*references["works"], *references["data"].values()]}
    entries = re.findall(r"@\w+\{(\w+),(.*?)\n\}", (root / "paper/paper.bib").read_text(), re.S)
    paper = {key: {name: plain(value) for name, value in re.findall(r"(title|year|journal|volume|doi) *= \{(.*)\}", body)}
             for key, body in entries}
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
    assert f'{{"title", "{cff["title"]}"}}' in (root / "sim/record/citation.cpp").read_text()
    # The same work as in the program and in README.
    doi = cff["references"][0]["doi"]
    for place in ("sim/record/references.json", "README.md"):
        assert doi in (root / place).read_text(), place
    check_references(root)
    assert f"## [{version}]" in (root / "CHANGELOG.md").read_text()


main()
