// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Lines where a function on a grid is `level`, by marching squares.

// `value(column, row)`; `segment(x0, y0, x1, y1)` gets the ends of each piece in columns and rows.
export function contour(columns, rows, value, level, segment) {
  let above = new Float32Array(columns), below = new Float32Array(columns);
  for (let column = 0; column < columns; ++column) below[column] = value(column, 0) - level;
  const ends = new Float64Array(8);
  for (let row = 0; row + 1 < rows; ++row) {
    [above, below] = [below, above];
    for (let column = 0; column < columns; ++column) below[column] = value(column, row + 1) - level;
    for (let column = 0; column + 1 < columns; ++column) {
      const corners = [above[column], above[column + 1], below[column + 1], below[column]];
      if (corners[0] > 0 === corners[1] > 0 && corners[1] > 0 === corners[2] > 0 && corners[2] > 0 === corners[3] > 0) continue;
      let count = 0;
      for (let side = 0; side < 4; ++side) {
        const a = corners[side], b = corners[(side + 1) % 4];
        if (a > 0 === b > 0) continue;
        const t = a / (a - b);
        ends[count++] = column + [t, 1, 1 - t, 0][side];
        ends[count++] = row + [0, t, 1, 1 - t][side];
      }
      // With four crossings the sign of the mean decides which corners are connected.
      const first = count === 8 && (corners[0] + corners[1] + corners[2] + corners[3] > 0) === corners[0] > 0 ? 2 : 0;
      for (let i = 0; i < count; i += 4) {
        const from = (first + i) % count, to = (first + i + 2) % count;
        segment(ends[from], ends[from + 1], ends[to], ends[to + 1]);
      }
    }
  }
}
