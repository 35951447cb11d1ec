# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Mutants of the C++ and OpenCL C sources, all compiled in at once: MUT(3) in `(MUT(3) ? (a - b) : (a + b))` switches the third.

A site is an operator, a number, a truth value, or a call of min or max, where libclang finds it outside of constant expressions,
which are evaluated before a switch can be set. On the host, MUT reads a table that is filled from REAMSIM_MUTANTS ("3 17") when a
program starts, and marks in the file REAMSIM_MUTANTS_REACHED that the site was executed. In a kernel it is a macro."""

import functools
import json
import pathlib
import re
import shlex

import clang.cindex
from clang.cindex import CursorKind as Kind

SWAPS = {"<": ["<=", ">"], "<=": ["<", ">"], ">": [">=", "<"], ">=": [">", "<"], "==": ["!="], "!=": ["=="], "+": ["-"], "-": ["+"],
         "*": ["/"], "/": ["*"], "&&": ["||"], "||": ["&&"], "+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="], "|=": ["&="],
         "&": ["|"], "|": ["&"], "<<": [">>"], ">>": ["<<"], "%": ["/"], "++": ["--"], "--": ["++"], "true": ["false"], "false": ["true"]}
CALLS = {"min": "max", "max": "min", "fmin": "fmax", "fmax": "fmin"}
NUMBER = re.compile(r"(\d+(?:\.\d*)?|\.\d+)(e[-+]?\d+)?([uUlLfF]*)", re.I)
# Evaluated by the compiler.
CONSTANT = {Kind.STATIC_ASSERT, Kind.ENUM_CONSTANT_DECL, Kind.TEMPLATE_NON_TYPE_PARAMETER, Kind.TYPE_ALIAS_DECL, Kind.TYPEDEF_DECL,
            Kind.CASE_STMT, Kind.ANNOTATE_ATTR, Kind.TEMPLATE_TYPE_PARAMETER}

SWITCH = """#ifndef REAMSIM_MUTANT_SWITCH
#define REAMSIM_MUTANT_SWITCH
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <cstdlib>
#include <type_traits>
namespace reamsim_mutants {
constexpr unsigned kMost = 4096;
struct Table {
  unsigned char on[kMost] = {};
  unsigned char unmapped[kMost] = {};
  unsigned char* reached = unmapped;
  Table() {
    if (const char* name = std::getenv("REAMSIM_MUTANTS_REACHED")) {
      const int file = open(name, O_RDWR);
      void* map = file < 0 ? MAP_FAILED : mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
      if (map != MAP_FAILED) reached = static_cast<unsigned char*>(map);
      if (file >= 0) close(file);
    }
    if (const char* text = std::getenv("REAMSIM_MUTANTS")) {
      for (char* end = nullptr; *text != 0; text = end) {
        const unsigned long number = std::strtoul(text, &end, 10);
        if (end == text) break;
        if (number < kMost) on[number] = 1;
      }
    }
  }
};
inline Table table;
inline bool at(unsigned number) {
  table.reached[number] = 1;
  return table.on[number] != 0;
}
constexpr bool mutant(unsigned number) { return std::is_constant_evaluated() ? false : at(number); }
}  // namespace reamsim_mutants
#define MUT(number) ::reamsim_mutants::mutant(number)
#endif
"""


def first_lines(switch):
    """Above every source with a mutant."""
    return (f'#ifdef __OPENCL_C_VERSION__\n#ifndef MUT\n#define MUT(number) 0\n#endif\n#else\n#include "{switch}"\n#endif\n')


@functools.lru_cache(maxsize=None)
def source(path):
    return pathlib.Path(path).read_bytes()


def replacements(cursor):
    """(begin, end, operands, operator, replacement) for each change of a node: offsets of the whole, ranges of what stays."""
    begin, end = cursor.extent.start.offset, cursor.extent.end.offset
    text = source(cursor.location.file.name)[begin:end].decode()
    kind, parts = cursor.kind, list(cursor.get_children())
    if kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR) and len(parts) == 2:
        left, right = ((part.extent.start.offset, part.extent.end.offset) for part in parts)
        what = source(cursor.location.file.name)[left[1]:right[0]].decode().strip()
        if left[0] == begin and right[1] == end:
            yield from ((begin, end, (left, right), what, other) for other in SWAPS.get(what, []))
    elif kind == Kind.UNARY_OPERATOR and len(parts) == 1 and (found := re.match(r"\+\+|--", text) or re.search(r"(\+\+|--)$", text)):
        yield begin, end, (), found[0], text[:found.start()] + SWAPS[found[0]][0] + text[found.end():]
    elif kind == Kind.CXX_BOOL_LITERAL_EXPR and text in SWAPS:
        yield begin, end, (), text, SWAPS[text][0]
    elif kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL) and (found := NUMBER.fullmatch(text)) and not is_template_argument(cursor):
        digits, exponent, suffix = found[1], found[2] or "", found[3]
        other = str(int(digits) + 1) if digits.isdigit() and not exponent else digits + ("1" if "." in digits else ".1")
        yield begin, end, (), text, other + exponent + suffix
    elif kind == Kind.CALL_EXPR and (found := re.match(r"(std::)?(f?min|f?max)\s*\(", text)):
        yield begin, end, (), found[2], text[:found.start(2)] + CALLS[found[2]] + text[found.end(2):]


def is_template_argument(literal):
    """By the text, in which clang-format writes spaces round comparisons."""
    text = source(literal.location.file.name)
    return text[literal.extent.start.offset - 1:literal.extent.start.offset] == b"<" or text[literal.extent.end.offset:][:1] == b">"


def is_constant(cursor):
    if cursor.kind in CONSTANT:
        return True
    declares = cursor.kind in (Kind.VAR_DECL, Kind.FIELD_DECL)
    if not declares:
        return False
    tokens = []
    for token in cursor.get_tokens():
        if token.spelling in ("=", "{", "(", "["):
            break
        tokens.append(token.spelling)
    array = any(part.kind.is_expression() for part in cursor.get_children()) and "[" in source(cursor.location.file.name)[
        cursor.extent.start.offset:cursor.extent.end.offset].decode().split("=")[0].split("{")[0]
    return "constexpr" in tokens or "__constant" in tokens or array


def visit(cursor, inside, out):
    for child in cursor.get_children():
        file = child.location.file
        if cursor.kind == Kind.TRANSLATION_UNIT and (file is None or not inside(file.name)):
            continue
        if is_constant(child):
            continue
        if file is not None and inside(file.name):
            for change in replacements(child):
                out.setdefault(str(pathlib.Path(file.name).resolve()), set()).add(change)
        visit(child, inside, out)


def parsed(path, options):
    return clang.cindex.Index.create().parse(str(path), args=options)


def kernel_options(kernels):
    """The combinations of macros that sim/engine gives, by kernel."""
    plain = ["-x", "cl", "-cl-std=CL1.2", "-cl-single-precision-constant", "-Xclang", "-finclude-default-header", "-w", "-I", str(kernels)]
    pools = ["-DRS_POOLS=2", "-DRS_POOL_BITS=8"]
    return [plain + extra for extra in ([], ["-DRS_WIDE_CODES", "-DRS_INT64_ATOMICS"], pools, pools + ["-DRS_CPU_SHAPE", "-DRS_LANES=16"],
                                        pools + ["-DRS_BRICK_FILL", "-DRS_INT64_ATOMICS"],
                                        pools + ["-DRS_CPU_SHAPE", "-DRS_LANES=16", "-DRS_DISTANCE_GRID"], pools + ["-DRS_DISTANCE_GRID"])]


def host_options(command):
    """Of a compile command, what libclang needs; a precompiled header as text."""
    out, words = [], shlex.split(command)
    for at, word in enumerate(words):
        if word.startswith(("-I", "-D", "-std")):
            out.append(word)
        elif word in ("-isystem", "-include"):
            out += words[at:at + 2]
    return out + ["-w"]


def find(tree, build, folders):
    """Every change of the sources in folders: sorted (file relative to tree, begin, end, operands, operator, replacement)."""
    tree, found = pathlib.Path(tree).resolve(), {}
    roots = [str(tree / folder) + "/" for folder in folders]

    def inside(name):
        return str(pathlib.Path(name).resolve()).startswith(tuple(roots))

    for entry in json.loads((build / "compile_commands.json").read_text()):
        if any(f"/{folder}/" in entry["file"] for folder in folders) and "embedded_" not in entry["file"]:
            visit(parsed(entry["file"], host_options(entry["command"])).cursor, inside, found)
    for path in sorted((tree / "kernels").glob("*.cl")):
        for options in kernel_options(tree / "kernels"):
            visit(parsed(path, options).cursor, inside, found)
    return sorted((str(pathlib.Path(name).relative_to(tree)), *change) for name, changes in found.items() for change in changes)


def mutated(text, changes):
    """The text (bytes) with changes, (number, begin, end, operands, operator, replacement) each, switched by MUT(number)."""
    def render(begin, end, left_out):
        inner = [change for change in changes if begin <= change[1] and change[2] <= end and change[0] not in left_out]
        outer = [change for change in inner if not any(other is not change and encloses(other, change) for other in inner)]
        out, at = b"", begin
        for number, first, last, operands, operator, replacement in sorted(outer, key=lambda change: change[1]):
            if first < at:
                continue  # overlaps without being inside
            rest = left_out | {number}
            usual = render(first, last, rest)
            other = replacement.encode()
            if operands:
                left, right = (render(*operand, rest) for operand in operands)
                other = left + b" " + replacement.encode() + b" " + right
            out += text[at:first] + b"(MUT(%d) ? (%s) : (%s))" % (number, other, usual)
            at = last
        return out + text[at:end]

    def encloses(outer, inner):
        return (outer[1], -outer[2], outer[0]) < (inner[1], -inner[2], inner[0]) and outer[1] <= inner[1] and inner[2] <= outer[2]

    return render(0, len(text), frozenset())


def broken_kernels(kernels):
    """Numbers of the mutants in lines of kernels that do not compile."""
    out = set()
    for path in sorted(kernels.glob("*.cl")):
        for options in kernel_options(kernels):
            for problem in parsed(path, options).diagnostics:
                if problem.severity >= clang.cindex.Diagnostic.Error and problem.location.file:
                    line = pathlib.Path(problem.location.file.name).read_text().splitlines()[problem.location.line - 1]
                    out |= {int(number) for number in re.findall(r"MUT\((\d+)\)", line)}
    return out
