/* Exact erosion: a voxel keeps the part of it that lies outside the tool, as the tool's local plane cuts it (design
 * §4). */
#ifndef REAMSIM_KERNELS_CLIP_H
#define REAMSIM_KERNELS_CLIP_H

#include "cube_fraction.h"
#include "cut_law.h"
#include "outline.h"

/* A voxel against the tool: its centre, the outward unit normal that the force goes by (both T, mm), how far the tool's
 * surface is (mm, negative inside), and the plane that stands for the surface. Next to a sharp corner of the profile
 * there are two: of a tool that bulges there (`corner` 1) both bound the inside, of one that is hollow (-1) either. */
typedef struct {
  rs_real p[3];
  rs_real n[3];
  rs_real distance;
  ClipPlane plane;
  rs_real corner;
  ClipPlane other;
} Clip;

/* The direction from the spin axis to `p`, r from it; on the axis one is as good as another, but there has to be one,
 * because a bore's wall may be next to a voxel there. */
RS_INLINE void rs_axis_direction(const rs_real* p, rs_real r, rs_real per_r, rs_real* c, rs_real* s) {
  *c = r > 0.0f ? p[0] * per_r : (rs_real)1.0f;
  *s = p[1] * per_r;
}

/* The plane with unit normal `n` (T) that a voxel's centre lies `away` voxels beyond. */
RS_INLINE ClipPlane rs_lattice_plane(RS_GLOBAL const SubstepArgs* a, const rs_real* n, rs_real away) {
  ClipPlane plane;
  for (int j = 0; j < 3; ++j)
    plane.n[j] = a->lattice_from_tool[3 * j] * n[0] + a->lattice_from_tool[3 * j + 1] * n[1] +
                 a->lattice_from_tool[3 * j + 2] * n[2];
  plane.nz = n[2];
  plane.away = away;
  return plane;
}

/* The plane of a surface next to a voxel centre: `nr`, `nz` its normal, (`c`, `s`) the direction from the spin axis to
 * the centre, `away` how far the centre lies beyond it (mm), `curvature` the outline's and `per_r` one over the
 * distance from the axis. A bulging surface falls away from its plane: by t^2/2 times the curvature at t from the point
 * of contact, in the mean over a voxel by h^2/24 in each direction. Round the axis a surface turns with its radius,
 * which means nothing where that is smaller than a voxel. */
RS_INLINE ClipPlane rs_clip_plane(RS_GLOBAL const SubstepArgs* a, rs_real c, rs_real s, rs_real nr, rs_real nz,
                                  rs_real away, rs_real curvature, rs_real per_r) {
  const rs_real most = (rs_real)a->per_voxel_mm; /* more is a corner */
  const rs_real both = curvature + nr * rs_smaller(per_r, most + most);
  const rs_real bulge = rs_larger(rs_smaller(both, most), -most);
  const rs_real n[3] = {nr * c, nr * s, nz};
  return rs_lattice_plane(a, n, away * a->per_voxel_mm + bulge * (a->voxel_mm * (1.0f / 24.0f)));
}

/* Takes `plane` in the lanes that are `there`. */
RS_INLINE void rs_select_plane(rs_real there, const ClipPlane* plane, ClipPlane* into) {
  for (int j = 0; j < 3; ++j) into->n[j] = there > 0.0f ? plane->n[j] : into->n[j];
  into->away = there > 0.0f ? plane->away : into->away;
  into->nz = there > 0.0f ? plane->nz : into->nz;
}

/* The voxels among those whose nearest piece is `mine` that the sharp corner between pieces `first` and `second`
 * reaches take both pieces' planes for theirs. Bone goes where a surface advances along its normal, so that the faces
 * share the force by how fast they do. `least`: squared distance of the nearest corner so far, mm2. */
RS_INLINE void rs_apply_corner(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, const NearestPiece* nearest,
                              rs_i32 mine, rs_i32 first, rs_i32 second, rs_real r, rs_real per_r, rs_real* least,
                              Clip* clip) {
  RS_GLOBAL const OutlinePiece *e = outline->pieces + first, *f = outline->pieces + second;
  /* Both lines as they leave the corner: outward normals, to the right of the way. */
  const float er = e->along_z1, ez = -e->along_r1, fr = f->along_z0, fz = -f->along_r0;
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  const rs_real vr = r - f->r0, vz = clip->p[2] - f->z0;
  const rs_real d2 = vr * vr + vz * vz;
  const rs_real nearer = d2 < *least ? one : zero;
  const rs_real there = nearest->piece == mine ? nearer : zero;
  if (!RS_ANY(there > 0.0f)) return;
  *least = there > 0.0f ? d2 : *least;
  const int bulges = e->along_r1 * f->along_z0 - e->along_z1 * f->along_r0 > 0.0f;
  clip->corner = there > 0.0f ? (rs_real)(bulges ? 1.0f : -1.0f) : clip->corner;
  rs_real c, s;
  rs_axis_direction(clip->p, r, per_r, &c, &s);
  const ClipPlane one_side =
      rs_clip_plane(a, c, s, (rs_real)er, (rs_real)ez, vr * er + vz * ez, (rs_real)e->curvature, per_r);
  const ClipPlane other_side =
      rs_clip_plane(a, c, s, (rs_real)fr, (rs_real)fz, vr * fr + vz * fz, (rs_real)f->curvature, per_r);
  rs_select_plane(there, &one_side, &clip->plane);
  rs_select_plane(there, &other_side, &clip->other);
  const rs_real ne[3] = {c * er, s * er, (rs_real)ez}, nf[3] = {c * fr, s * fr, (rs_real)fz};
  const rs_real we = rs_larger(rs_advance(a, ne, clip->p), zero), wf = rs_larger(rs_advance(a, nf, clip->p), zero);
  const rs_real both = we + wf;
  const rs_real moves = both > 0.0f ? there : zero;
  for (int j = 0; j < 3; ++j) clip->n[j] = moves > 0.0f ? (we * ne[j] + wf * nf[j]) / both : clip->n[j];
}

/* The voxel (x, y, z), counted within its brick, whose lowest voxel's centre is `brick` in T: how far the surface is
 * from its centre, mm. */
RS_INLINE rs_real rs_clip_distance(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, EdgeList list,
                                   const float* brick, rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  rs_voxel_in_tool(a, brick, x, y, z, p);
  return rs_outline_nearest(outline, list, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]).distance;
}

/* The tool next to the voxel centre `p` (T, mm), by the nearest piece of its outline alone. */
RS_INLINE Clip rs_clip_at(RS_GLOBAL const SubstepArgs* a, const NearestPiece* nearest, const rs_real* p, rs_real r,
                          rs_real per_r) {
  rs_real c, s;
  rs_axis_direction(p, r, per_r, &c, &s);
  Clip clip;
  for (int j = 0; j < 3; ++j) clip.p[j] = p[j];
  clip.n[0] = nearest->normal_r * c;
  clip.n[1] = nearest->normal_r * s;
  clip.n[2] = nearest->normal_z;
  clip.distance = nearest->distance;
  clip.plane =
      rs_clip_plane(a, c, s, nearest->normal_r, nearest->normal_z, nearest->distance, nearest->curvature, per_r);
  clip.other = clip.plane;
  clip.corner = (rs_real)0.0f;
  return clip;
}

/* The tool next to the voxel (x, y, z), counted within its brick. */
RS_INLINE Clip rs_clip(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, EdgeList list, const float* brick,
                       rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  rs_voxel_in_tool(a, brick, x, y, z, p);
  const rs_real r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const rs_real per_r = r > 0.0f ? (rs_real)1.0f / r : (rs_real)0.0f;
  const NearestPiece nearest = rs_outline_nearest(outline, list, r, p[2]);
  Clip clip = rs_clip_at(a, &nearest, p, r, per_r);
  const float reach = RS_CLIP_REACH * a->voxel_mm;
  rs_real least = (rs_real)(reach * reach);
  for (rs_u32 i = 0; i < list.count; ++i) {
    const rs_i32 mine = outline->numbers[list.first + i];
    const rs_i32 before = outline->pieces[mine].before, after = outline->pieces[mine].after;
    if (before >= 0) rs_apply_corner(a, outline, &nearest, mine, before, mine, r, per_r, &least, &clip);
    if (after >= 0) rs_apply_corner(a, outline, &nearest, mine, mine, after, r, per_r, &least, &clip);
  }
  return clip;
}

/* The same for a voxel whose nearest piece is `piece`, further from that piece's ends than its reach. */
RS_INLINE Clip rs_clip_smooth(RS_GLOBAL const SubstepArgs* a, RS_GLOBAL const OutlinePiece* piece, const float* brick,
                              rs_real x, rs_real y, rs_real z) {
  rs_real p[3];
  rs_voxel_in_tool(a, brick, x, y, z, p);
  const rs_real r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const rs_real per_r = r > 0.0f ? (rs_real)1.0f / r : (rs_real)0.0f;
  const PieceDistance away = rs_circle_distance(piece, r, p[2]);
  const NearestPiece nearest = rs_nearest_piece(&away, (rs_real)piece->curvature, (rs_int)0);
  return rs_clip_at(a, &nearest, p, r, per_r);
}

/* Part of a voxel that the tool leaves when its planes have come `ahead` (voxels) further, the first and the other. */
RS_INLINE rs_real rs_clip_fraction(const Clip* clip, float ahead, float other_ahead) {
  ClipPlane a = clip->plane, b = clip->other;
  a.away -= ahead;
  b.away -= other_ahead;
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  const rs_real share = rs_outside_fraction(a.n, a.away);
  if (!RS_ANY(clip->corner != 0.0f)) return share;
  const rs_real other = rs_outside_fraction(b.n, b.away);
  /* What is counted keeps to what the shares leave possible, so that where one plane alone matters it decides. */
  const rs_real least = rs_larger(share + other - one, zero), most = rs_smaller(share, other);
  const rs_real both = rs_larger(rs_smaller(rs_outside_both(&a, &b), most), least);
  const rs_real cornered = clip->corner > 0.0f ? share + other - both : both;
  return clip->corner != 0.0f ? cornered : share;
}

/* Fill that is left of a whole voxel. */
RS_INLINE rs_int rs_fill_outside(const Clip* clip) {
  return RS_TO_INT(rs_clip_fraction(clip, 0.0f, 0.0f) * (float)RS_WHOLE_FILL + 0.5f);
}

/* Fill that a voxel with `fill` left loses when the tool leaves `outside` of it: what little the rounding of positions
 * could make stays, unless nothing is left. */
RS_INLINE rs_int rs_clip_loss(RS_GLOBAL const SubstepArgs* a, rs_int fill, rs_int outside) {
  const rs_int lost = fill - outside;
  const rs_int enough = outside == 0 ? (rs_int)1 : (rs_int)a->least_loss;
  return lost >= enough ? lost : (rs_int)0;
}

/* What a voxel that loses `lost` of its fill does to the tool, when the whole of it takes `whole` mJ. */
RS_INLINE void rs_clip_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_real whole, rs_int lost,
                             LaneSums* sums) {
  if (a->law == RS_LAW_NONE) return;
  const rs_real energy = whole * (RS_TO_REAL(lost) * (1.0f / (float)RS_WHOLE_FILL));
  sums->energy += RS_TO_SUM(energy * (float)RS_ENERGY_SCALE);
  rs_cut_force(a, clip->n, clip->p, energy, sums);
}

/* How far the tool is advanced to see what bone it rests against, voxels. */
#define RS_EDGE_PROBE (1.0f / 64.0f)

/* Where the tool's normal points less than this towards the bone (-z of T), the surface is its side or its back, and
 * has no lips. */
#define RS_LEAST_FACING 0.01f

/* What of a voxel the tool's plane with normal part `nz` along the spin axis would take if it went a little further,
 * `outside` being what the tool leaves; nothing where that plane has no lips. */
RS_INLINE rs_real rs_probe_loss(const Clip* clip, rs_real nz, rs_real outside, float ahead, float other_ahead) {
  const rs_real next = outside - rs_clip_fraction(clip, ahead, other_ahead);
  return -nz > RS_LEAST_FACING ? next : (rs_real)0.0f;
}

/* Area, mm2, of the tool's face that rests against what is left of a voxel: what the face would take if it went a
 * little further, over how far that is. Over the voxels round a face it adds up to the face, because their outside
 * shares do. `left`: the voxel's fill, `outside`: what the tool leaves of a whole voxel. */
RS_INLINE rs_real rs_contact_area(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int left, rs_int outside) {
  const rs_real zero = (rs_real)0.0f;
  const rs_real now = rs_clip_fraction(clip, 0.0f, 0.0f);
  rs_real share = rs_probe_loss(clip, clip->plane.nz, now, RS_EDGE_PROBE, 0.0f);
  if (RS_ANY(clip->corner != 0.0f)) {
    const rs_real other = rs_probe_loss(clip, clip->other.nz, now, 0.0f, RS_EDGE_PROBE);
    share += clip->corner != 0.0f ? other : zero;
  }
  const rs_real area = share * (a->voxel_mm * a->voxel_mm / RS_EDGE_PROBE);
  const rs_real met = clip->distance <= RS_CLIP_REACH * a->voxel_mm ? area : zero;
  const rs_real touched = left + a->least_loss >= outside ? met : zero;
  return left > 0 ? touched : zero;
}

RS_INLINE int rs_has_edge(RS_GLOBAL const SubstepArgs* a) {
  return a->edge_tangential > 0.0f && a->law == RS_LAW_ENERGY;
}

/* Force of the lips' edges on the tool where it rests against a voxel. A surface of revolution that `lips` lips sweep
 * carries lips/(2·pi·r) mm of lip per mm2. It takes no speed floor, because it does not grow where the tool is slow. */
RS_INLINE void rs_edge_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int left, rs_int outside,
                             LaneSums* sums) {
  const rs_real zero = (rs_real)0.0f;
  const rs_real r = RS_SQRT(clip->p[0] * clip->p[0] + clip->p[1] * clip->p[1]);
  const rs_real lip = rs_contact_area(a, clip, left, outside) / rs_larger(r, (rs_real)(0.5f * a->voxel_mm));
  const ToolMotion m = rs_tool_motion(a, clip->p);
  const rs_real engaged = m.speed > 0.0f ? lip : zero;
  const rs_real tangential = engaged * a->edge_tangential;
  sums->energy += RS_TO_SUM(tangential * (m.speed * a->duration) * (float)RS_ENERGY_SCALE);
  rs_add_resistance(&m, clip->n, clip->p, tangential, engaged * a->edge_normal, sums);
}

#endif
