# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""mkdocs_site.py ROOT: the site of docs/ builds strictly, and a reader without network finds everything in it.

Checks of the pages as they are built: every page is in the navigation; every link has its page and its anchor, every picture is there;
scripts, styles and pictures come from the site; no table, list or fence is left as plain text. Then the links of the Markdown files beside
docs/, whose anchors are those of GitHub and GitLab."""

import html.parser
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.parse

BESIDE = ["README.md", "SECURITY.md", "CHANGELOG.md", "CONTRIBUTING.md", "assets/README.md"]
LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("source", "src"), ("iframe", "src")}
LEFT_OVER = re.compile(r"^ *(?:\| ?--|```|[-*] \S|\d+\. \S)", re.M)
SHALLOW = re.compile(r"^ {1,3}```\w*$", re.M)


class Page(html.parser.HTMLParser):
    """Anchors, links and loaded files of a page, and the text of its paragraphs."""

    def __init__(self, path):
        super().__init__()
        self.ids, self.links, self.loaded, self.paragraphs = set(), [], [], []
        self.open_paragraph = False
        text = path.read_text()
        self.escaped_bar = any("\\|" in cell for cell in re.findall(r"<td.*?</td>", text, flags=re.S))
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids.add(values.get("id"))
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        for loading, key in LOADED:
            if tag == loading and values.get(key) and values.get("rel") != "canonical":
                self.loaded.append(values[key])
        if tag == "p":
            self.open_paragraph = True
            self.paragraphs.append("")

    def handle_endtag(self, tag):
        self.open_paragraph &= tag != "p"

    def handle_data(self, data):
        if self.open_paragraph:
            self.paragraphs[-1] += data


def is_external(link):
    return bool(urllib.parse.urlsplit(link).scheme) or link.startswith("//")


def target_of(page, link):
    """File and anchor that a link of a page leads to."""
    parts = urllib.parse.urlsplit(link)
    path = urllib.parse.unquote(parts.path)
    return (page.parent / path).resolve() if path else page, urllib.parse.unquote(parts.fragment)


def check_site(site):
    pages = {path.resolve(): Page(path) for path in site.rglob("*.html") if path.name != "404.html"}
    mistakes = []
    for path, page in pages.items():
        name = path.relative_to(site.resolve())
        mistakes += [f"{name} loads {link}" for link in page.loaded if is_external(link)]
        for link in page.links + page.loaded:
            if is_external(link):
                continue
            target, anchor = target_of(path, link)
            if not target.exists() or (anchor and target in pages and anchor not in pages[target].ids):
                mistakes.append(f"{name}: {link} leads nowhere")
        mistakes += [f"{name}: a bar is shown with its backslash"] if page.escaped_bar else []
        mistakes += [f"{name}: Markdown left as text: {text[:80]!r}" for text in page.paragraphs if LEFT_OVER.search(text)]
    return len(pages), sorted(set(mistakes))


def check_sources(docs):
    """A block in a step of a list needs four spaces: with fewer the site ends the list there."""
    return [f"{path}: a block indented by fewer than four spaces" for path in docs.rglob("*.md") if SHALLOW.search(path.read_text())]


def anchors_of(path):
    """Anchors of the headings of a Markdown file, as GitHub makes them."""
    text = re.sub(r"^ *```.*?^ *```", "", path.read_text(), flags=re.M | re.S)
    titles = [re.sub(r"`|\[([^\]]*)\]\([^)]*\)", r"\1", title) for title in re.findall(r"^#+ +(.+)$", text, flags=re.M)]
    return {re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-") for title in titles}


def check_beside(root):
    mistakes = []
    for name in BESIDE:
        page = root / name
        text = re.sub(r"^ *```.*?^ *```", "", page.read_text(), flags=re.M | re.S) if page.exists() else ""
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            target, anchor = target_of(page.resolve(), link)
            if not is_external(link) and (not target.exists() or (anchor and anchor not in anchors_of(target))):
                mistakes.append(f"{name}: {link} leads nowhere")
    return mistakes


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        built = subprocess.run(["/usr/bin/mkdocs", "build", "--strict", "--site-dir", folder], cwd=root, capture_output=True, text=True)
        assert built.returncode == 0, built.stderr
        assert "not included in the \"nav\"" not in built.stderr, built.stderr
        count, mistakes = check_site(pathlib.Path(folder))
    mistakes += check_beside(root) + check_sources(root / "docs")
    assert count >= 20 and not mistakes, "\n".join(mistakes)
    print(f"{count} pages")


main()
