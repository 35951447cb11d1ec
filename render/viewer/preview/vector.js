// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Points and directions as [x, y, z].
export const add = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
export const minus = (a, b) => add(a, b, -1);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a) => Math.sqrt(dot(a, a));
export const scaled = (a, factor) => [factor * a[0], factor * a[1], factor * a[2]];
export const unit = (a) => scaled(a, 1 / (length(a) || 1));
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const distance = (a, b) => length(minus(a, b));
export const same = (a, b) => a === b || JSON.stringify(a) === JSON.stringify(b);
export const rounded = (a, digits) => a.map((v) => Number(v.toFixed(digits)) + 0);
