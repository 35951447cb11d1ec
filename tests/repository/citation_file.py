# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""citation_file.py ROOT VERSION: CITATION.cff is what the Citation File Format 1.2.0 asks for (its guide to the schema: required keys,
types, patterns), names the version of the program and the paper, and the other places name that version too. The references of the
program and of paper/paper.bib that have the same key are the same work."""

import pathlib
import re
import sys

import yaml

KEYS = {"abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license",
        "license-url", "message", "preferred-citation", "references", "repository", "repository-artifact", "repository-code",
        "title", "type", "url", "version"}
PERSON = {"address", "affiliation", "alias", "city", "country", "email", "family-names", "fax", "given-names", "name-particle",
          "name-suffix", "orcid", "post-code", "region", "tel", "website"}
ENTITY = {"address", "alias", "city", "country", "date-end", "date-start", "email", "fax", "location", "name", "orcid", "post-code",
          "region", "tel", "website"}
# Those that this file uses.
REFERENCE = {"authors", "doi", "journal", "scope", "start", "end", "title", "type", "url", "volume", "year"}
DOI = r"10\.\d{4,9}(\.\d+)?/[A-Za-z0-9:/_;\-.()\[\]\\]+"


def text(value):
    return isinstance(value, str) and value != ""


def check_authors(authors):
    assert isinstance(authors, list) and authors
    for author in authors:
        allowed = ENTITY if "name" in author else PERSON
        assert author and set(author) <= allowed and all(map(text, author.values())), author


def check_reference(reference):
    assert {"authors", "title", "type"} <= set(reference) <= REFERENCE, reference
    assert reference["type"] in ("article", "data", "software")
    check_authors(reference["authors"])
    assert isinstance(reference["year"], int) and text(reference["journal"])
    for key in ("volume", "start"):
        assert isinstance(reference[key], (str, int))
    assert re.fullmatch(DOI, reference["doi"])


def check(cff):
    assert {"authors", "cff-version", "message", "title"} <= set(cff) <= KEYS, set(cff) - KEYS
    assert cff["cff-version"] == "1.2.0" and text(cff["message"]) and text(cff["title"]) and text(cff["abstract"])
    assert cff["type"] in ("software", "dataset")
    check_authors(cff["authors"])
    assert all(map(text, cff["keywords"])) and len(set(cff["keywords"])) == len(cff["keywords"])
    for reference in cff["references"]:
        check_reference(reference)


def check_that_mistakes_are_found(cff):
    for change in ({"cff-version": "1.3"}, {"authors": []}, {"colour": "red"}, {"authors": [{"title": "Dr"}]},
                   {"references": [{**cff["references"][0], "doi": "https://doi.org/10.1016/x"}]}):
        try:
            check({**cff, **change})
        except AssertionError:
            continue
        raise SystemExit(f"not found: {change}")


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
    check_that_mistakes_are_found(cff)
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
