// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion: a voxel keeps its part outside the tool, which is bounded by a local plane (docs/erosion.md, 3). */
#ifndef REAMSIM_KERNELS_CLIP_H
#define REAMSIM_KERNELS_CLIP_H

#include "bone_face.h"
#include "cube_fraction.h"
#include "cut_law.h"
#include "outline.h"

/* The tool next to a voxel: the voxel's centre (T, mm), outward unit normal of the force, distance of the centre from
 * the surface (mm, negative inside), and the plane that represents the surface. Next to a sharp corner of the outline
 * there are two planes: the inside is their intersection at a convex corner (`corner` 1), their union at a concave one
 * (-1). */
typedef struct {
  rs_real p[3];
  rs_real n[3];
  rs_real distance;
  ClipPlane plane;
  rs_real corner;
  ClipPlane other;
  rs_int piece; /* of the outline, nearest */
} Clip;

/* The direction from the spin axis to `p` at radius r. On the axis it is arbitrary but defined, because the wall of a
 * bore can be next to a voxel there. */
RS_INLINE void rs_axis_direction(const rs_real* p, rs_real r, rs_real per_r, rs_real* c, rs_real* s) {
  *c = r > 0.0f ? p[0] * per_r : RS_REAL(1.0f);
  *s = p[1] * per_r;
}

/* What the rounding of the brick's middle leaves out of the distance along the normal (`nr`, `nz`), mm; (`c`, `s`): the
 * direction from the spin axis. */
RS_INLINE rs_real rs_left_out(const BrickMiddle* brick, rs_real c, rs_real s, rs_real nr, rs_real nz) {
  return nr * (c * brick->rest[0] + s * brick->rest[1]) + nz * brick->rest[2];
}

/* The plane with unit normal `n` (T), with a voxel's centre `away` voxels outside. */
RS_INLINE ClipPlane rs_lattice_plane(RS_GLOBAL const SubstepArgs* a, const rs_real* n, rs_real away) {
  ClipPlane plane;
  for (int j = 0; j < 3; ++j)
    plane.n[j] = a->lattice_from_tool[3 * j] * n[0] + a->lattice_from_tool[3 * j + 1] * n[1] +
                 a->lattice_from_tool[3 * j + 2] * n[2];
  plane.nz = n[2];
  plane.away = away;
  return plane;
}

/* The plane of a surface next to a voxel centre: (`nr`, `nz`) its normal, (`c`, `s`) the direction from the spin axis,
 * `away` the distance of the centre outside (mm), `curvature` that of the outline, `per_r` the inverse distance from
 * the axis. A convex surface recedes from its tangent plane by t^2/2 times the curvature at distance t, on average over
 * a voxel of side h by h^2/24 per direction. The curvature around the axis is bounded, because radii below a voxel are
 * not resolved. */
RS_INLINE ClipPlane rs_clip_plane(RS_GLOBAL const SubstepArgs* a, rs_real c, rs_real s, rs_real nr, rs_real nz,
                                  rs_real away, rs_real curvature, rs_real per_r) {
  const rs_real most = RS_REAL(a->per_voxel_mm); /* more is a corner */
  const rs_real both = curvature + nr * rs_min(per_r, most + most);
  const rs_real bulge = rs_max(rs_min(both, most), -most);
  const rs_real n[3] = {nr * c, nr * s, nz};
  return rs_lattice_plane(a, n, away * a->per_voxel_mm + bulge * (a->voxel_mm * (1.0f / 24.0f)));
}

/* Copies `plane` in the lanes where `there` is set. */
RS_INLINE void rs_select_plane(rs_real there, const ClipPlane* plane, ClipPlane* into) {
  for (int j = 0; j < 3; ++j) into->n[j] = there > 0.0f ? plane->n[j] : into->n[j];
  into->away = there > 0.0f ? plane->away : into->away;
  into->nz = there > 0.0f ? plane->nz : into->nz;
}

/* Sets both planes of the sharp corner between pieces `first` and `second`, in voxels in its reach whose nearest piece
 * is `mine`. A surface removes bone where it advances along its normal, so the force's normal is the mean of both,
 * weighted by their advance. `least`: squared distance of the nearest corner so far, mm2. */
RS_INLINE void rs_apply_corner(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, const BrickMiddle* brick,
                               const NearestPiece* nearest, rs_i32 mine, rs_i32 first, rs_i32 second, rs_real r,
                               rs_real per_r, rs_real* least, Clip* clip) {
  RS_GLOBAL const OutlinePiece *e = outline->pieces + first, *f = outline->pieces + second;
  /* Outward normals of both pieces at the corner, to the right of the direction of travel. */
  const float er = e->along_z1, ez = -e->along_r1, fr = f->along_z0, fz = -f->along_r0;
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  const rs_real vr = r - f->r0, vz = clip->p[2] - f->z0;
  const rs_real d2 = vr * vr + vz * vz;
  const rs_real nearer = d2 < *least ? one : zero;
  const rs_real there = nearest->piece == mine ? nearer : zero;
  if (!RS_ANY(there > 0.0f)) return;
  *least = there > 0.0f ? d2 : *least;
  const int bulges = e->along_r1 * f->along_z0 - e->along_z1 * f->along_r0 > 0.0f;
  clip->corner = there > 0.0f ? RS_REAL(bulges ? 1.0f : -1.0f) : clip->corner;
  rs_real c, s;
  rs_axis_direction(clip->p, r, per_r, &c, &s);
  const rs_real e_away = vr * er + vz * ez + rs_left_out(brick, c, s, RS_REAL(er), RS_REAL(ez));
  const rs_real f_away = vr * fr + vz * fz + rs_left_out(brick, c, s, RS_REAL(fr), RS_REAL(fz));
  const ClipPlane one_side = rs_clip_plane(a, c, s, RS_REAL(er), RS_REAL(ez), e_away, RS_REAL(e->curvature), per_r);
  const ClipPlane other_side = rs_clip_plane(a, c, s, RS_REAL(fr), RS_REAL(fz), f_away, RS_REAL(f->curvature), per_r);
  rs_select_plane(there, &one_side, &clip->plane);
  rs_select_plane(there, &other_side, &clip->other);
  const rs_real ne[3] = {c * er, s * er, RS_REAL(ez)}, nf[3] = {c * fr, s * fr, RS_REAL(fz)};
  const rs_real we = rs_max(rs_advance(a, ne, clip->p), zero), wf = rs_max(rs_advance(a, nf, clip->p), zero);
  const rs_real both = we + wf;
  const rs_real moves = both > 0.0f ? there : zero;
  for (int j = 0; j < 3; ++j) clip->n[j] = moves > 0.0f ? (we * ne[j] + wf * nf[j]) / both : clip->n[j];
}

/* Distance of the surface from voxel (x, y, z), counted within its brick, mm. */
RS_INLINE rs_real rs_clip_distance(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                                   const BrickMiddle* brick, rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  return rs_outline_nearest(outline, list, r, p[2]).distance;
}

/* The tool next to the voxel centre `p` (T, mm) of a brick, from the nearest piece alone. */
RS_INLINE Clip rs_clip_at(RS_GLOBAL const SubstepArgs* a, const BrickMiddle* brick, const NearestPiece* nearest,
                          const rs_real* p, rs_real r, rs_real per_r) {
  rs_real c, s;
  rs_axis_direction(p, r, per_r, &c, &s);
  Clip clip;
  for (int j = 0; j < 3; ++j) clip.p[j] = p[j];
  clip.n[0] = nearest->normal_r * c;
  clip.n[1] = nearest->normal_r * s;
  clip.n[2] = nearest->normal_z;
  clip.distance = nearest->distance + rs_left_out(brick, c, s, nearest->normal_r, nearest->normal_z);
  clip.plane = rs_clip_plane(a, c, s, nearest->normal_r, nearest->normal_z, clip.distance, nearest->curvature, per_r);
  clip.other = clip.plane;
  clip.corner = RS_REAL(0.0f);
  clip.piece = nearest->piece;
  return clip;
}

/* The tool next to the voxel (x, y, z), counted within its brick. */
RS_INLINE Clip rs_clip(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                       const BrickMiddle* brick, rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  const rs_real per_r = r > 0.0f ? RS_REAL(1.0f) / r : RS_REAL(0.0f);
  const NearestPiece nearest = rs_outline_nearest(outline, list, r, p[2]);
  Clip clip = rs_clip_at(a, brick, &nearest, p, r, per_r);
  const float reach = RS_CLIP_REACH * a->voxel_mm;
  rs_real least = RS_REAL(reach * reach);
  for (rs_u32 i = 0; i < list.count; ++i) {
    const rs_i32 mine = outline->numbers[list.first + i];
    const rs_i32 before = outline->pieces[mine].before, after = outline->pieces[mine].after;
    if (before >= 0) rs_apply_corner(a, outline, brick, &nearest, mine, before, mine, r, per_r, &least, &clip);
    if (after >= 0) rs_apply_corner(a, outline, brick, &nearest, mine, mine, after, r, per_r, &least, &clip);
  }
  return clip;
}

/* The same for a voxel whose nearest piece is `piece`, with that piece's ends out of reach. */
RS_INLINE Clip rs_clip_smooth(RS_GLOBAL const SubstepArgs* a, RS_GLOBAL const OutlinePiece* piece,
                              const BrickMiddle* brick, rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  const rs_real per_r = r > 0.0f ? RS_REAL(1.0f) / r : RS_REAL(0.0f);
  const PieceDistance away = rs_circle_distance(piece, r, p[2]);
  const NearestPiece nearest = rs_nearest_piece(&away, RS_REAL(piece->curvature), RS_INT(0));
  return rs_clip_at(a, brick, &nearest, p, r, per_r);
}

/* The fractions of a voxel outside the tool, and outside its first plane, its other plane and both (those of one plane
 * without a corner). */
typedef struct {
  rs_real tool, first, other, both;
} OutsideFractions;

RS_INLINE OutsideFractions rs_clip_fractions(const Clip* clip) {
  const ClipPlane *a = &clip->plane, *b = &clip->other;
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  const rs_real first = rs_outside_fraction(a->n, a->away);
  OutsideFractions out = {first, first, first, first};
  if (!RS_ANY(clip->corner != 0.0f)) return out;
  const rs_real other = rs_outside_fraction(b->n, b->away);
  /* The sampled fraction is limited to its bounds, which makes it exact where one plane alone matters. */
  const rs_real least = rs_max(first + other - one, zero), most = rs_min(first, other);
  const rs_real both = rs_max(rs_min(rs_outside_both(a, b), most), least);
  const rs_real cornered = clip->corner > 0.0f ? first + other - both : both;
  out.tool = clip->corner != 0.0f ? cornered : first;
  out.other = other;
  out.both = both;
  return out;
}

/* The part of the bone in a voxel (of the fraction `bone`) on the same side of two planes, of which each alone has
 * `x` and `y` of the bone, `p` and `q` of the voxel, and both have `pq` of the voxel. What lies beyond one plane is
 * divided by the other as the voxel is. */
RS_INLINE rs_real rs_bone_within_both(rs_real bone, rs_real x, rs_real y, rs_real p, rs_real q, rs_real pq) {
  const rs_real zero = RS_REAL(0.0f), tiny = RS_REAL(1e-6f);
  const rs_real divided = rs_min(x * (pq / rs_max(p, tiny)), y * (pq / rs_max(q, tiny)));
  const rs_real least = rs_max(rs_max(x + y - bone, zero), rs_max(x + pq - p, y + pq - q));
  return rs_min(rs_max(divided, least), rs_min(x, y));
}

/* Whether the edge between the planes of a convex corner is outside the bone of a voxel: 1 where it surely is. A sum of
 * the three planes' inequalities with weights >= 0 has no solution in the voxel then (the weights are those of the
 * shortest sum of the normals). */
RS_INLINE rs_real rs_edge_beyond_bone(const Clip* clip, rs_int face) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), least = RS_REAL(1e-3f);
  const ClipPlane *a = &clip->plane, *b = &clip->other;
  rs_real n[3], na = zero, nb = zero, ab = zero, size = zero;
  rs_face_normal(face, n);
  for (int i = 0; i < 3; ++i) {
    na += n[i] * a->n[i];
    nb += n[i] * b->n[i];
    ab += a->n[i] * b->n[i];
  }
  const rs_real per_sine2 = one / rs_max(one - ab * ab, least);
  const rs_real of_a = rs_max((ab * nb - na) * per_sine2, zero), of_b = rs_max((ab * na - nb) * per_sine2, zero);
  for (int i = 0; i < 3; ++i) size += rs_abs(n[i] + of_a * a->n[i] + of_b * b->n[i]);
  const rs_real away = rs_face_away(face) + of_a * a->away + of_b * b->away;
  const rs_real beyond = away > 0.5f * size ? one : zero;
  return RS_IS_UNDIRECTED(face) ? zero : beyond;
}

/* The fraction of a voxel with a face of the bone that is bone and outside the tool. */
RS_INLINE rs_real rs_clip_kept_fraction(const Clip* clip, rs_int face) {
  const OutsideFractions o = rs_clip_fractions(clip);
  const FaceCut first_cut = rs_face_cut(face, &clip->plane);
  const rs_real first = rs_kept_fraction(&first_cut, o.first);
  if (!RS_ANY(clip->corner != 0.0f)) return first;
  const FaceCut other_cut = rs_face_cut(face, &clip->other);
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), f = first_cut.fill;
  const rs_real other = rs_kept_fraction(&other_cut, o.other), in_both = one - o.first - o.other + o.both;
  const rs_real removed = rs_bone_within_both(f, f - first, f - other, one - o.first, one - o.other, in_both);
  const rs_real beyond = RS_ANY(clip->corner > 0.0f) ? rs_edge_beyond_bone(clip, face) : zero;
  const rs_real convex = f - (beyond > 0.0f ? zero : removed);
  const rs_real concave = rs_bone_within_both(f, first, other, o.first, o.other, o.both);
  const rs_real cornered = clip->corner > 0.0f ? convex : concave, kept = clip->corner != 0.0f ? cornered : first;
  return face != RS_NO_FACE ? kept : o.tool;
}

/* Remaining fill of a voxel that was whole before the run, and of one with a face of the bone. */
RS_INLINE rs_int rs_fill_outside(const Clip* clip) {
  return RS_TO_INT(rs_clip_fractions(clip).tool * (float)RS_WHOLE_FILL + 0.5f);
}
RS_INLINE rs_int rs_clip_kept(const Clip* clip, rs_int face) {
  if (!RS_ANY(face != RS_NO_FACE)) return rs_fill_outside(clip);
  return rs_fill_of(rs_clip_kept_fraction(clip, face), rs_face_cut(face, &clip->plane).fill);
}

/* Loss of a voxel with fill `fill` of which the tool leaves at most `kept`. Losses within the rounding of positions are
 * ignored, unless nothing remains. */
RS_INLINE rs_int rs_clip_loss(RS_GLOBAL const SubstepArgs* a, rs_int fill, rs_int kept) {
  const rs_int lost = fill - kept;
  const rs_int enough = kept == 0 ? RS_INT(1) : RS_INT(a->min_loss);
  return lost >= enough ? lost : RS_INT(0);
}

/* Whether voxels keep what they lose, because the motion is only tried. */
RS_INLINE int rs_is_trial(RS_GLOBAL const SubstepArgs* a) {
  return a->erosion == RS_EROSION_TRIAL;
}

/* Adds energy and force of a voxel that loses `lost` of its fill. `whole`: energy of a whole voxel, mJ. */
RS_INLINE void rs_clip_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_real whole, rs_int lost,
                             LaneSums* sums) {
  if (a->law == RS_LAW_NONE) return;
  const rs_real energy = whole * (RS_TO_REAL(lost) * (1.0f / (float)RS_WHOLE_FILL));
  sums->energy += RS_TO_SUM(energy * (float)RS_ENERGY_SCALE);
  rs_cut_force(a, clip->n, clip->p, energy, sums);
}

/* Advance of the tool that probes contact with bone, voxels. */
#define RS_EDGE_PROBE (1.0f / 64.0f)

/* A surface whose normal has a smaller component towards the bone (-z of T) is the tool's side or back, and has no
 * cutting edges. */
#define RS_LEAST_FACING 0.01f

/* Fraction of a voxel that a plane with normal component `nz` would remove by an advance; 0 where it has no cutting
 * edges. `now`: fraction kept. */
RS_INLINE rs_real rs_probe_loss(const Clip* clip, rs_int face, rs_real nz, rs_real now, float ahead,
                                float other_ahead) {
  Clip advanced = *clip;
  advanced.plane.away -= ahead;
  advanced.other.away -= other_ahead;
  const rs_real next = now - rs_clip_kept_fraction(&advanced, face);
  return -nz > RS_LEAST_FACING ? rs_max(next, RS_REAL(0.0f)) : RS_REAL(0.0f);
}

/* Area of the tool's face in contact with a voxel, mm2: the volume that a small advance would remove, over the advance.
 * The areas of all voxels add up to the face. `remaining`: fill of the voxel; `kept`: the most that the tool leaves. */
RS_INLINE rs_real rs_contact_area(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int face, rs_int remaining,
                                  rs_int kept) {
  const rs_real zero = RS_REAL(0.0f);
  const rs_real now = rs_clip_kept_fraction(clip, face);
  rs_real probed = rs_probe_loss(clip, face, clip->plane.nz, now, RS_EDGE_PROBE, 0.0f);
  if (RS_ANY(clip->corner != 0.0f)) {
    const rs_real other = rs_probe_loss(clip, face, clip->other.nz, now, 0.0f, RS_EDGE_PROBE);
    probed += clip->corner != 0.0f ? other : zero;
  }
  const rs_real area = probed * (a->voxel_mm * a->voxel_mm / RS_EDGE_PROBE);
  const rs_real near = clip->distance <= RS_CLIP_REACH * a->voxel_mm ? area : zero;
  const rs_real touched = remaining + a->min_loss >= kept ? near : zero;
  return remaining > 0 ? touched : zero;
}

RS_INLINE int rs_has_edge(RS_GLOBAL const SubstepArgs* a) {
  return a->edge_tangential > 0.0f && a->law == RS_LAW_ENERGY;
}

/* Edge force on the tool in contact with a voxel. A surface of revolution swept by n cutting edges carries n/(2·pi·r)
 * mm of edge per mm2. It needs no speed floor, because it does not depend on the speed. */
RS_INLINE void rs_edge_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int face, rs_int remaining,
                             rs_int kept, LaneSums* sums) {
  const rs_real zero = RS_REAL(0.0f);
  const rs_real r = RS_SQRT(clip->p[0] * clip->p[0] + clip->p[1] * clip->p[1]);
  const rs_real edge = rs_contact_area(a, clip, face, remaining, kept) / rs_max(r, RS_REAL(0.5f * a->voxel_mm));
  const ToolMotion m = rs_tool_motion(a, clip->p);
  const rs_real engaged = m.speed > 0.0f ? edge : zero;
  const rs_real tangential = engaged * a->edge_tangential;
  sums->energy += RS_TO_SUM(tangential * (m.speed * a->duration) * (float)RS_ENERGY_SCALE);
  rs_real f[3];
  rs_resistance(&m, clip->n, tangential, engaged * a->edge_normal, f);
  rs_add_force(sums, f, clip->p);
}

#endif
