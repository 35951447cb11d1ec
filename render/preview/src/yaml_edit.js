// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Changes single keys of a YAML text in place, line by line; every other byte stays. It knows the YAML that scenarios
// are written in: block mappings and sequences, flow collections, comments. What else it meets, it refuses.

export class EditError extends Error {}

const indentOf = (line) => line.length - line.trimStart().length;
const isContent = (line) => /^\s*[^\s#]/.test(line) && !/^(---|\.\.\.|%)/.test(line);

// Where `text` ends: before a comment, or the end. Quotes and brackets are respected; `depth` is that at the end.
function scan(text, depth = 0) {
  let quote = "";
  for (let i = 0; i < text.length; ++i) {
    const c = text[i];
    if (quote !== "") {
      if (quote === '"' && c === "\\") ++i;
      else if (c === quote) quote = "";
    } else if ((c === '"' || c === "'") && (i === 0 || /[\s[{,:]/.test(text[i - 1]))) quote = c;
    else if (c === "[" || c === "{") ++depth;
    else if (c === "]" || c === "}") --depth;
    else if (c === "#" && (i === 0 || /\s/.test(text[i - 1]))) return { end: i, depth };
  }
  return { end: text.length, depth };
}

// The parts of a line "key: value # comment", or null for another line. `comment` has the spaces before it.
function partsOf(line) {
  const match = /^(\s*)("(?:[^"\\]|\\.)*"|'(?:[^']|'')*'|[^\s#"'[\]{},&*!|>%@`-][^#]*?|-[^\s#][^#]*?)\s*:(?=\s|$)/.exec(line);
  if (match === null) return null;
  const rest = line.slice(match[0].length);
  const value = rest.slice(0, scan(rest).end).trimEnd();
  const name = match[2];
  return {
    indent: match[1].length, key: /^["']/.test(name) ? name.slice(1, -1) : name, head: match[0],
    value: value.trim(), comment: rest.slice(value.length),
  };
}

// The lines of a block below `line` that are deeper than `indent`; a sequence may stand at `indent` itself. Comments
// and blank lines after the last line of content belong to what follows.
function endOf(lines, line, to, indent) {
  let end = line + 1;
  for (let at = line + 1; at < to; ++at) {
    if (!isContent(lines[at])) continue;
    const deeper = indentOf(lines[at]) > indent || (indentOf(lines[at]) === indent && /^\s*-(\s|$)/.test(lines[at]) && partsOf(lines[line])?.value === "");
    if (!deeper) break;
    end = at + 1;
  }
  return end;
}

function childIndent(lines, from, to) {
  for (let at = from; at < to; ++at) if (isContent(lines[at])) return indentOf(lines[at]);
  return -1;
}

function findKey(lines, { from, to, indent }, key) {
  for (let at = from; at < to; ++at) {
    if (!isContent(lines[at]) || indentOf(lines[at]) !== indent) continue;
    const parts = partsOf(lines[at]);
    if (parts !== null && parts.key === key) return { ...parts, line: at, end: endOf(lines, at, to, indent) };
  }
  return null;
}

// The items of "{a: 1, b: [2, 3]}" or "[1, 2]", without the brackets.
function itemsOf(flow) {
  const inner = flow.trim().slice(1, -1), items = [];
  let depth = 0, quote = "", from = 0;
  for (let i = 0; i <= inner.length; ++i) {
    const c = inner[i];
    if (i === inner.length || (c === "," && depth === 0 && quote === "")) {
      if (inner.slice(from, i).trim() !== "") items.push(inner.slice(from, i).trim());
      from = i + 1;
    } else if (quote !== "") quote = c === quote ? "" : quote;
    else if (c === '"' || c === "'") quote = c;
    else if (c === "[" || c === "{") ++depth;
    else if (c === "]" || c === "}") --depth;
  }
  return items;
}

// A flow collection may go on over lines: its text, and its comment if it stands on one.
function flowText(lines, found) {
  if (found.end === found.line + 1) return found.value;
  return lines.slice(found.line, found.end).map((line, i) => {
    const text = i === 0 ? line.slice(found.head.length) : line;
    return text.slice(0, scan(text).end).trim();
  }).join(" ");
}

function refuse(found, path) {
  if (/^[&*!|>]|^<</.test(found.value)) throw new EditError(`${path} is written with ${found.value.slice(0, 12)}, which this page does not change: change it by hand`);
}

// Writes "key: {a: 1}" as a block, so that a key of it can change.
function expandFlow(lines, found, path) {
  const text = flowText(lines, found);
  if (!/^\{.*\}$/s.test(text)) throw new EditError(`${path} has no keys below it: change it by hand`);
  const pad = " ".repeat(found.indent + 2);
  const items = itemsOf(text).map((item) => pad + item.replace(/^("[^"]*"|'[^']*'|[^\s:]+)\s*:\s*/, "$1: "));
  lines.splice(found.line, found.end - found.line, found.head + (found.end === found.line + 1 ? found.comment : ""), ...items);
}

// The block of the sequence item `index` below `found`, as a mapping, or null.
function itemBlock(lines, found, index) {
  let count = -1, start = -1, end = found.end, dash = -1;
  for (let at = found.line + 1; at < found.end; ++at) {
    if (!isContent(lines[at]) || !/^\s*-\s/.test(lines[at])) continue;
    if (dash < 0) dash = indentOf(lines[at]);
    if (indentOf(lines[at]) !== dash) continue;
    if (++count === index) start = at;
    else if (count === index + 1) { end = at; break; }
  }
  if (start < 0) return null;
  const parts = /^(\s*)-(\s+)/.exec(lines[start]);
  const inside = lines[start].replace("-", " ");
  return partsOf(inside) === null ? null : { start, end, indent: parts[0].length };
}

// What stands for the value: text for the line of the key, and lines below it.
function written(value, indent) {
  if (typeof value === "string") return { text: ` ${value}`, below: [] };
  const pad = " ".repeat(indent + 2);
  const below = Array.isArray(value)
    ? value.flatMap((item) => typeof item === "string" ? [`${pad}- ${item}`] : Object.entries(item).map(([k, v], i) => `${pad}${i === 0 ? "- " : "  "}${k}: ${v}`))
    : Object.entries(value).map(([k, v]) => `${pad}${k}: ${v}`);
  return { text: "", below };
}

function insertKey(lines, block, path, value) {
  let indent = block.indent;
  let at = block.from;
  for (let line = block.from; line < block.to; ++line) if (isContent(lines[line])) at = line + 1;
  const made = [];
  path.forEach((key, i) => {
    const last = i + 1 === path.length;
    const { text, below } = last ? written(value, indent) : { text: "", below: [] };
    made.push(`${" ".repeat(indent)}${key}:${text}`, ...below);
    indent += 2;
  });
  lines.splice(at, 0, ...made);
}

// Sets the key `path` (names; numbers for items of a sequence) to `value`: text, a list of texts or of objects of texts,
// or an object of texts; undefined removes the key.
function setKey(lines, path, value) {
  let block = { from: 0, to: lines.length, indent: Math.max(0, childIndent(lines, 0, lines.length)) };
  for (let depth = 0; depth < path.length; ++depth) {
    const name = path.slice(0, depth + 1).join(".");
    let found = findKey(lines, block, path[depth]);
    const last = depth + 1 === path.length;
    if (found === null) {
      if (value !== undefined) insertKey(lines, block, path.slice(depth), value);
      return;
    }
    refuse(found, name);
    if (last) {
      if (value === undefined) {
        lines.splice(found.line, found.end - found.line);
        return;
      }
      const { text, below } = written(value, found.indent);
      // The comment of a flow collection over several lines stands among them, and goes with them.
      const comment = found.value === "" || found.end === found.line + 1 ? found.comment : "";
      lines.splice(found.line, found.end - found.line, found.head + text + comment, ...below);
      return;
    }
    if (typeof path[depth + 1] === "number") {
      const item = itemBlock(lines, found, path[depth + 1]);
      if (item === null) throw new EditError(`${name} is no list of blocks`);
      const dash = lines[item.start].indexOf("-");
      const part = lines.slice(item.start, item.end);
      part[0] = part[0].replace("-", " ");  // a mapping like any other, for the moment
      const inner = findKey(part, { from: 0, to: part.length, indent: item.indent }, path[depth + 2]);
      if (inner === null) throw new EditError(`${name} has an item without ${path[depth + 2]}`);
      part.splice(inner.line, inner.end - inner.line, `${inner.head} ${value}${inner.comment}`);
      part[0] = `${part[0].slice(0, dash)}-${part[0].slice(dash + 1)}`;
      lines.splice(item.start, item.end - item.start, ...part);
      return;
    }
    if (found.value !== "" && found.value !== "null" && found.value !== "~") {
      expandFlow(lines, found, name);
      found = findKey(lines, block, path[depth]);
      // The block has grown.
      block = { ...block, to: Math.max(block.to, found.end) };
    } else if (found.value !== "") {
      lines[found.line] = found.head + found.comment;
    }
    const indent = childIndent(lines, found.line + 1, found.end);
    block = { from: found.line + 1, to: found.end, indent: indent < 0 ? found.indent + 2 : indent };
  }
}

// `changes`: [path, value] pairs, see setKey().
export function edited(text, changes) {
  const end = text.includes("\r\n") ? "\r\n" : "\n";
  const lines = text.split(end);
  for (const [path, value] of changes) setKey(lines, path, value);
  return lines.join(end);
}
