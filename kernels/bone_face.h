// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The surface of the bone before the run, in voxels that it intersects, and what such a voxel keeps outside the tool
 * (docs/erosion.md, 3). */
#ifndef REAMSIM_KERNELS_BONE_FACE_H
#define REAMSIM_KERNELS_BONE_FACE_H

#include "bricks.h"
#include "cube_fraction.h"

/* A face: the voxel's fill before the run in 16 bits, and the direction of the bone's outward normal in 5 bits per
 * lattice axis: RS_FACE_STEPS plus the component, of which the largest is RS_FACE_STEPS. */
#define RS_FACE_STEPS 15
#define RS_FACE_BITS 5
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

/* A face against a plane of the tool. */
typedef struct {
  rs_real fill;      /* before the run, 0..1 */
  rs_real cosine;    /* between the outward normal of the tool and the inward normal of the bone: 1 where the tool cuts
                      * parallel to the bone's surface from outside, -1 from inside */
  rs_real weight;    /* of the excess of the smaller fraction, and the inverse of the difference of the fractions */
  rs_real per_width; /* beyond which the planes do not cross in the voxel */
} FaceCut;

RS_INLINE FaceCut rs_face_cut_at(rs_real fill, rs_real cosine) {
  const rs_real one = RS_REAL(1.0f), least = RS_REAL(1e-6f);
  const rs_real c = rs_abs(cosine), sine = RS_SQRT(rs_max(one - c * c, least));
  const FaceCut out = {fill, cosine, sine * (one - c * (1.0f / 3.0f)), c / (0.65f * sine)};
  return out;
}

RS_INLINE rs_real rs_face_fill(rs_int face) {
  return RS_TO_REAL(face & RS_WHOLE_FILL) * (1.0f / (float)RS_WHOLE_FILL);
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

RS_INLINE FaceCut rs_face_cut(rs_int face, const ClipPlane* plane) {
  const rs_real one = RS_REAL(1.0f);
  rs_real n[3];
  rs_face_normal(face, n);
  const rs_real cosine = -(n[0] * plane->n[0] + n[1] * plane->n[1] + n[2] * plane->n[2]);
  return rs_face_cut_at(rs_face_fill(face), rs_max(rs_min(cosine, one), -one));
}

/* The fraction of a voxel that is both bone and outside the tool. Of two half-spaces with the fractions f and o in a
 * cube this is min(f, o) where they are nested, max(f + o - 1, 0) where they are opposite, and f o on average where
 * they are perpendicular. At other angles it falls below the smaller one only where the planes can cross in the cube:
 * min - weight (1 - |f - o|/width)^2 (min - f o), with width 0.65 tan and weight sin (1 - cos/3), which makes the mean
 * over all positions right to 0.001 of the cube (tests/engine/bone_face_test.cpp); RMS error 0.006. */
RS_INLINE rs_real rs_kept_fraction(const FaceCut* face, rs_real outside) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), f = face->fill;
  const rs_real o = face->cosine >= 0.0f ? outside : one - outside, least = rs_min(f, o);
  const rs_real near = rs_max(one - rs_abs(f - o) * face->per_width, zero);
  const rs_real both = least - face->weight * (near * near) * (least - f * o);
  return face->cosine >= 0.0f ? both : f - both;
}

/* The same in units of fill. */
RS_INLINE rs_int rs_kept_fill(const FaceCut* face, rs_int outside) {
  const rs_real kept = rs_kept_fraction(face, RS_TO_REAL(outside) * (1.0f / (float)RS_WHOLE_FILL));
  return RS_TO_INT(rs_max(kept, RS_REAL(0.0f)) * (float)RS_WHOLE_FILL + 0.5f);
}

#endif
