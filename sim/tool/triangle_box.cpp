// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/triangle_box.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Whether `axis` separates the triangle (relative to the box's centre) from the box.
bool separates(const Vec3& axis, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& half) {
  const double pa = axis.dot(a), pb = axis.dot(b), pc = axis.dot(c);
  const double reach = half.x() * std::abs(axis.x()) + half.y() * std::abs(axis.y()) + half.z() * std::abs(axis.z());
  return std::min({pa, pb, pc}) > reach || std::max({pa, pb, pc}) < -reach;
}

/// The three cross products of the box's axes with `edge`.
bool edge_separates(const Vec3& edge, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& half) {
  return separates({0, -edge.z(), edge.y()}, a, b, c, half) || separates({edge.z(), 0, -edge.x()}, a, b, c, half) ||
         separates({-edge.y(), edge.x(), 0}, a, b, c, half);
}

}  // namespace

bool triangle_touches_box(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& center, const Vec3& half) {
  const Vec3 p = a - center, q = b - center, r = c - center;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::min({p[axis], q[axis], r[axis]}) > half[axis]) return false;
    if (std::max({p[axis], q[axis], r[axis]}) < -half[axis]) return false;
  }
  const Vec3 pq = q - p, qr = r - q, rp = p - r;
  if (separates(pq.cross(qr), p, q, r, half)) return false;
  return !edge_separates(pq, p, q, r, half) && !edge_separates(qr, p, q, r, half) && !edge_separates(rp, p, q, r, half);
}

}  // namespace reamsim
