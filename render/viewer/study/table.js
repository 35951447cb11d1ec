// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The table of runs. Only the rows in sight, and some around them, are in the document.
import { find, part } from "../shared/page.js";

const kRow = 30;  // px, as in style.css
const kMargin = 12;  // rows above and below those in sight

export class Table {
  constructor(study, showRun) {
    // `sorted`: { column, descending }
    Object.assign(this, { study, showRun, runs: new Uint32Array(), sorted: null, place: find("rows") });
    this.head = document.querySelector("#table thead");
    this.body = document.querySelector("#table tbody");
    this.fixed = this.fixedColumns();
    this.place.addEventListener("scroll", () => this.draw());
    this.body.addEventListener("keydown", (event) => this.move(event));
    new ResizeObserver(() => this.draw(true)).observe(this.place);
  }

  fixedColumns() {
    const { study } = this;
    const fixed = [
      { key: "run", title: "Run", chars: 5, values: study.numbers },
      { key: "status", title: "Status", chars: 9, values: study.states, cell: (run) => study.stateText(run) },
    ];
    if (study.reports.includes(1)) fixed.push({ key: "report", title: "Report", chars: 6, values: study.reports });
    if (study.hasMessages) fixed.push({ key: "message", title: "Message", chars: 30, words: (run) => study.message(run), cell: (run) => study.message(run) });
    return fixed;
  }

  // Shows these columns after run, status, report and message.
  showColumns(columns) {
    this.columns = [...this.fixed, ...columns];
    if (this.sorted && !this.columns.includes(this.sorted.column)) this.sorted = null;
    const width = (column) => column.chars ?? this.charsOf(column);
    const heads = this.columns.map((column) => part("th", { scope: "col", style: `width: ${width(column) + 2}ch` }, part("button", { type: "button", title: column.key, onclick: () => this.sortBy(column) }, column.title)));
    this.head.replaceChildren(part("tr", {}, ...heads));
    find("table").style.width = `max(100%, ${this.columns.reduce((sum, column) => sum + width(column) + 2, 0)}ch)`;
    find("table").setAttribute("aria-colcount", this.columns.length);
    this.sort();
  }

  // The width of a column in characters: its cells, and its title on three lines.
  charsOf(column) {
    let most = Math.max(7, ...column.title.split(" ").map((word) => word.length + 1), Math.ceil(column.title.length / 3) + 3);
    const step = Math.max(1, Math.floor(this.study.count / 400));
    for (let run = 0; run < this.study.count; run += step) most = Math.max(most, column.cell(run).length);
    return Math.min(most, 26);
  }

  sortBy(column) {
    const again = this.sorted?.column === column;
    this.sorted = again && this.sorted.descending ? null : { column, descending: again };
    if (this.sorted === null) this.runs = Uint32Array.from(this.runs).sort();
    this.sort();
  }

  show(runs) {
    this.runs = runs;
    this.place.scrollTop = 0;
    this.sort();
  }

  sort() {
    if (this.sorted !== null) {
      const { column, descending } = this.sorted;
      const sign = descending ? -1 : 1;
      const byText = (a, b) => sign * column.words(a).localeCompare(column.words(b));
      const byNumber = (a, b) => {
        const [x, y] = [column.values[a], column.values[b]];
        if (x === y) return 0;
        if (Number.isNaN(x)) return Number.isNaN(y) ? 0 : 1;  // missing values come last
        return Number.isNaN(y) ? -1 : sign * (x - y);
      };
      this.runs = Uint32Array.from([...this.runs].sort(column.words ? byText : byNumber));
    }
    [...this.head.rows[0].cells].forEach((cell, i) => {
      const isSorted = this.sorted?.column === this.columns[i];
      if (isSorted) cell.setAttribute("aria-sort", this.sorted.descending ? "descending" : "ascending");
      else cell.removeAttribute("aria-sort");
    });
    this.draw(true);
  }

  draw(anew = false) {
    if (!this.columns) return;
    const first = Math.max(0, Math.floor(this.place.scrollTop / kRow) - kMargin);
    const last = Math.min(this.runs.length, Math.ceil((this.place.scrollTop + this.place.clientHeight) / kRow) + kMargin);
    if (!anew && first === this.first && last === this.last) return;
    [this.first, this.last] = [first, last];
    const focused = this.body.contains(document.activeElement) ? document.activeElement.dataset.run : undefined;
    const rows = [];
    for (let i = first; i < last; ++i) rows.push(this.row(i));
    const space = (count) => part("tr", { class: "space", "aria-hidden": "true" }, part("td", { colSpan: this.columns.length, style: `height: ${count * kRow}px` }));
    this.body.replaceChildren(...(first > 0 ? [space(first)] : []), ...rows, ...(last < this.runs.length ? [space(this.runs.length - last)] : []));
    find("table").setAttribute("aria-rowcount", this.runs.length + 1);
    if (focused !== undefined) (this.body.querySelector(`button[data-run="${focused}"]`) ?? this.place).focus({ preventScroll: true });
  }

  row(place) {
    const { study } = this, run = this.runs[place], number = study.numbers[run];
    const cells = this.columns.map((column) => {
      if (column.key === "run") {
        return part("th", { scope: "row" }, part("button", { type: "button", "data-run": `${run}`, "data-place": `${place}`, "aria-label": `Run ${number}`, onclick: () => this.showRun(run) }, `${number}`));
      }
      if (column.key === "report") {
        const link = part("a", { href: `runs/${study.ids[run]}/report.html`, "aria-label": `Report of run ${number}` }, "Report");
        return part("td", {}, ...(study.reports[run] ? [link] : []));
      }
      const text = column.cell(run);
      const kind = column.key === "status" ? `state ${text}` : (column.levels && !column.numeric) || column.words ? "words" : "number";
      return part("td", { class: kind, title: text.length > 24 ? text : "" }, text);
    });
    return part("tr", { "aria-rowindex": `${place + 2}` }, ...cells);
  }

  // Arrow keys move the focus from run to run.
  move(event) {
    const place = Number(document.activeElement?.dataset?.place);
    const to = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: this.runs.length - 1 }[event.key];
    if (Number.isNaN(place) || to === undefined || to < 0 || to >= this.runs.length) return;
    event.preventDefault();
    const top = to * kRow, room = this.place.clientHeight - this.head.offsetHeight;
    if (top < this.place.scrollTop) this.place.scrollTop = top;
    if (top + kRow > this.place.scrollTop + room) this.place.scrollTop = top + kRow - room;
    this.draw();
    this.body.querySelector(`button[data-place="${to}"]`)?.focus({ preventScroll: true });
  }
}
