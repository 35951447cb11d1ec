// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The surface of the bone before the run, in voxels that it intersects, and what such a voxel keeps outside the tool
 * (docs/erosion.md, 3). */
#ifndef REAMSIM_KERNELS_BONE_FACE_H
#define REAMSIM_KERNELS_BONE_FACE_H

#include "bricks.h"
#include "cube_fraction.h"

/* A face: the distance of the voxel's centre outside the bone (16 bits, RS_FACE_REACH voxels either way), and the
 * direction of the bone's outward normal in 5 bits per lattice axis: RS_FACE_STEPS plus the component, of which the
 * largest is RS_FACE_STEPS. Where all are 0 the direction is unknown, and the 16 bits are the fill. */
#define RS_FACE_STEPS 15
#define RS_FACE_BITS 5
#define RS_FACE_REACH 0.875f
#define RS_NO_FACE (RS_WHOLE_FILL | (RS_FACE_STEPS << 16 | RS_FACE_STEPS << 21 | RS_FACE_STEPS << 26))

/* A brick with faces: a bit per voxel that has one, and per word the number of the first of its faces. */
typedef struct {
  rs_u32 there[RS_BRICK_WORDS];
  rs_u32 begin[RS_BRICK_WORDS];
} FaceBrick;
RS_SAME_LAYOUT(FaceBrick, 2 * 64);

#ifdef __OPENCL_C_VERSION__
#define RS_BITS_SET(word) popcount(word)
#else
#define RS_BITS_SET(word) __builtin_popcount(word)
#endif

/* The face of the voxel at `place` of a brick (rs_brick_offset), or RS_NO_FACE. `brick`: 0 where it has none. */
RS_INLINE rs_i32 rs_face_at(RS_GLOBAL const FaceBrick* brick, RS_GLOBAL const rs_i32* faces, rs_i32 place) {
  if (brick == 0) return RS_NO_FACE;
  const rs_u32 bit = 1u << (place & 31), there = brick->there[place >> 5];
  return (there & bit) == 0 ? RS_NO_FACE : faces[brick->begin[place >> 5] + (rs_u32)RS_BITS_SET(there & (bit - 1u))];
}

/* The distance of the voxel's centre outside the bone, voxels. */
RS_INLINE rs_real rs_face_away(rs_int face) {
  return RS_TO_REAL(face & RS_WHOLE_FILL) * (2.0f * RS_FACE_REACH / (float)RS_WHOLE_FILL) - RS_FACE_REACH;
}

/* The outward unit normal of the bone in lattice axes; zero of RS_NO_FACE. */
RS_INLINE void rs_face_normal(rs_int face, rs_real* n) {
  rs_real squares = RS_REAL(1e-3f); /* of at least RS_FACE_STEPS^2 */
  for (int i = 0; i < 3; ++i) {
    n[i] = RS_TO_REAL((face >> (16 + RS_FACE_BITS * i)) & (2 * RS_FACE_STEPS + 1)) - (float)RS_FACE_STEPS;
    squares += n[i] * n[i];
  }
  const rs_real per_length = RS_REAL(1.0f) / RS_SQRT(squares);
  for (int i = 0; i < 3; ++i) n[i] *= per_length;
}

/* A face against a plane of the tool. */
typedef struct {
  rs_real fill;      /* of the voxel before the run, 0..1 */
  rs_real touch;     /* the fraction outside the tool from which on the tool does not reach the bone */
  rs_real cosine;    /* between the outward normal of the tool and the inward normal of the bone: 1 where the tool cuts
                      * parallel to the bone's surface from outside, -1 from inside */
  rs_real weight;    /* of the excess of the smaller fraction, and the inverse of the difference of the fractions */
  rs_real per_width; /* beyond which the planes do not cross in the voxel */
} FaceCut;

RS_INLINE FaceCut rs_face_cut_at(rs_real fill, rs_real touch, rs_real cosine) {
  const rs_real one = RS_REAL(1.0f), least = RS_REAL(1e-6f);
  const rs_real c = rs_abs(cosine), sine = RS_SQRT(rs_max(one - c * c, least));
  const FaceCut out = {fill, touch, cosine, sine * (one - c * (1.0f / 3.0f)), c / (0.65f * sine)};
  return out;
}

/* The least distance, voxels, of a voxel's bone along the normal `n` of the tool from the voxel's centre, for a face
 * with the normal `b` and `away`: a linear program with one constraint and bounds, whose dual function has its maximum
 * where a component of n + weight b changes its sign. */
RS_INLINE rs_real rs_nearest_bone(const rs_real* b, rs_real away, const rs_real* n) {
  const rs_real zero = RS_REAL(0.0f), least = RS_REAL(1e-3f);
  rs_real nearest = -0.5f * (rs_abs(n[0]) + rs_abs(n[1]) + rs_abs(n[2]));
  for (int i = 0; i < 3; ++i) {
    const rs_real weight = n[i] * b[i] < 0.0f ? rs_abs(n[i]) / rs_max(rs_abs(b[i]), least) : zero;
    const rs_real size = rs_abs(n[0] + weight * b[0]) + rs_abs(n[1] + weight * b[1]) + rs_abs(n[2] + weight * b[2]);
    nearest = rs_max(nearest, weight * away - 0.5f * size);
  }
  return nearest;
}

/* Of a voxel with the fill `fill` (0..1). `b`, `away`: outward unit normal of the bone in lattice axes, and distance of
 * the voxel's centre outside it, voxels; `n`: outward unit normal of the tool. */
RS_INLINE FaceCut rs_face_cut_between(rs_real fill, const rs_real* b, rs_real away, const rs_real* n) {
  const rs_real one = RS_REAL(1.0f), cosine = -(b[0] * n[0] + b[1] * n[1] + b[2] * n[2]);
  const rs_real touch = rs_outside_fraction(n, -rs_nearest_bone(b, away, n));
  return rs_face_cut_at(fill, touch, rs_max(rs_min(cosine, one), -one));
}

/* Whether the direction of a face is unknown. */
#define RS_IS_UNDIRECTED(face) (((face) | RS_WHOLE_FILL) == RS_NO_FACE)

RS_INLINE FaceCut rs_face_cut(rs_int face, const ClipPlane* plane) {
  const rs_real one = RS_REAL(1.0f), away = rs_face_away(face);
  if (!RS_ANY(face != RS_NO_FACE)) return rs_face_cut_at(one, one, RS_REAL(0.0f));
  rs_real b[3];
  rs_face_normal(face, b);
  FaceCut out = rs_face_cut_between(one - rs_outside_fraction(b, away), b, away, plane->n);
  const rs_real fill = RS_TO_REAL(face & RS_WHOLE_FILL) * (1.0f / (float)RS_WHOLE_FILL);
  out.fill = RS_IS_UNDIRECTED(face) ? fill : out.fill;
  out.touch = RS_IS_UNDIRECTED(face) ? one : out.touch;
  return out;
}

/* The fraction of a voxel that is both bone and outside the tool. Of two half-spaces with the fractions f and o in a
 * cube this is min(f, o) where they are nested, max(f + o - 1, 0) where they are opposite, and f o on average where
 * they are perpendicular. At other angles it falls below the smaller one only where the planes can cross in the cube:
 * min - weight (1 - |f - o|/width)^2 (min - f o), with width 0.65 tan and weight sin (1 - cos/3), which makes the mean
 * over all positions right to 0.001 of the cube (tests/engine/bone_face_test.cpp); RMS error 0.006. Nothing is lost
 * before the tool can reach the bone. */
RS_INLINE rs_real rs_kept_fraction(const FaceCut* face, rs_real outside) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), f = face->fill;
  const rs_real o = face->cosine >= 0.0f ? outside : one - outside, least = rs_min(f, o);
  const rs_real near = rs_max(one - rs_abs(f - o) * face->per_width, zero);
  const rs_real both = least - face->weight * (near * near) * (least - f * o);
  const rs_real kept = face->cosine >= 0.0f ? both : f - both;
  return outside < face->touch ? kept : f;
}

/* The most fill of a voxel that keeps the fraction `kept`; no limit where it keeps all of its bone. */
RS_INLINE rs_int rs_fill_of(rs_real kept, rs_real fill) {
  const rs_real most = kept < fill ? rs_max(kept, RS_REAL(0.0f)) : RS_REAL(1.0f);
  return RS_TO_INT(most * (float)RS_WHOLE_FILL + 0.5f);
}

/* The same in units of fill. */
RS_INLINE rs_int rs_kept_fill(const FaceCut* face, rs_int outside) {
  return rs_fill_of(rs_kept_fraction(face, RS_TO_REAL(outside) * (1.0f / (float)RS_WHOLE_FILL)), face->fill);
}

#endif
