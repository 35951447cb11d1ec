// The cut of `bricked` in C++: cut_bricked.cl as it runs on a CPU, over the same structures, and the cutting law of
// kernels/cut_law.h written again for vectors of the compiler, with the same operations in the same order.
#include "tests/bench/reference/frame.h"
#include "tests/bench/reference/lanes.h"

namespace reamsim::reference::REAMSIM_TARGET {

namespace {

constexpr rs_u32 kBricksAtOnce = 8;  // that a thread takes
constexpr rs_u32 kWaiting = 32;

typedef rs_u8 Bytes __attribute__((vector_size(8)));
typedef rs_u16 Places __attribute__((vector_size(16)));

/// What a thread adds up before it adds to the frame. Records of removed voxels wait until there are some.
struct Tally {
  Sum force[3], torque[3], floor_energy;
  rs_i64 energy = 0, contacts = 0;
  RemovedBlock waiting[kWaiting];
  rs_u32 waiting_count = 0;
};

// ---- The law ----

/// PieceDistance without the signed distance.
struct Piece {
  Reals square, side, r, z, scale;
};

/// rs_piece_distance().
Piece piece_distance(const OutlinePiece& e, Reals r, Reals z) {
  const Reals zero = {}, one = zero + 1.0F;
  const Reals wr = r - e.middle_r, wz = z - e.middle_z;
  const Reals q = e.curvature * (wr * wr + wz * wz) + 2.0F * (wr * e.normal_r + wz * e.normal_z);
  const Reals x = e.curvature * q, size = x < 0.0F ? -x : x;
  Reals distance = q * (0.5F + x * (-0.125F + x * (0.0625F + x * (-5.0F / 128.0F + x * (7.0F / 256.0F)))));
  Reals scale = one + x * (-0.5F + x * (0.375F + x * (-0.3125F + x * (35.0F / 128.0F))));
  if (any(size > RS_NEAR_CIRCLE)) {
    const Reals length = root(one + x > 0.0F ? one + x : zero);
    distance = size > RS_NEAR_CIRCLE ? q / (one + length) : distance;
    scale = size > RS_NEAR_CIRCLE ? (length > 1e-6F ? one / length : zero) : scale;
  }
  Piece out = {distance * distance, distance, e.normal_r + e.curvature * wr, e.normal_z + e.curvature * wz, scale};
  const Reals r0 = r - e.r0, z0 = z - e.z0, r1 = r - e.r1, z1 = z - e.z1;
  const Reals past = r1 * e.along_r1 + z1 * e.along_z1, short_of = -(r0 * e.along_r0 + z0 * e.along_z0);
  const Reals off = past > short_of ? past : short_of;
  if (!any(off > 0.0F)) return out;
  const Reals pr = past > 0.0F ? r1 : r0, pz = past > 0.0F ? z1 : z0;
  const Reals end_side = past > 0.0F ? r1 * e.along_z1 - z1 * e.along_r1 : r0 * e.along_z0 - z0 * e.along_r0;
  const Reals square = pr * pr + pz * pz, length = root(square);
  const Reals per_away = length > 1e-6F ? one / (end_side < 0.0F ? -length : length) : zero;
  out.square = off > 0.0F ? square : out.square;
  out.side = off > 0.0F ? end_side : out.side;
  out.r = off > 0.0F ? pr : out.r;
  out.z = off > 0.0F ? pz : out.z;
  out.scale = off > 0.0F ? per_away : out.scale;
  return out;
}

/// rs_outline_nearest(): the normal alone.
void nearest_normal(const OutlineView& outline, PieceList list, Reals r, Reals z, Reals& normal_r, Reals& normal_z) {
  const Reals zero = {}, one = zero + 1.0F;
  Piece best = piece_distance(outline.pieces[outline.numbers[list.first]], r, z);
  for (rs_u32 i = 1; i < list.count; ++i) {
    const Piece found = piece_distance(outline.pieces[outline.numbers[list.first + i]], r, z);
    const Reals side = found.side < 0.0F ? -found.side : found.side;
    const Reals best_side = best.side < 0.0F ? -best.side : best.side;
    const Reals rounding = best.square * 2e-6F + 1e-10F;
    const Reals tie = found.square <= best.square + rounding ? side - best_side : -one;
    const Reals gain = found.square < best.square - rounding ? one : tie;
    best.square = gain > 0.0F ? found.square : best.square;
    best.side = gain > 0.0F ? found.side : best.side;
    best.r = gain > 0.0F ? found.r : best.r;
    best.z = gain > 0.0F ? found.z : best.z;
    best.scale = gain > 0.0F ? found.scale : best.scale;
  }
  normal_r = best.r * best.scale;
  normal_z = best.scale < 0.0F || best.scale > 0.0F ? best.z * best.scale : -one;
}

/// rs_outline_normal().
void normal_at(const OutlineView& outline, PieceList list, const Reals* p, Reals* normal) {
  const Reals zero = {};
  const Reals r = root(p[0] * p[0] + p[1] * p[1]);
  Reals radial;
  nearest_normal(outline, list, r, p[2], radial, normal[2]);
  const Reals share = r > 0.0F ? radial / r : zero;
  normal[0] = share * p[0];
  normal[1] = share * p[1];
}

/// rs_add_force().
void add_force(Tally& tally, const Reals* f, const Reals* p) {
  constexpr auto kForce = static_cast<float>(RS_FORCE_SCALE), kTorque = static_cast<float>(RS_TORQUE_SCALE);
  for (int i = 0; i < 3; ++i) tally.force[i].add(f[i] * kForce);
  tally.torque[0].add((p[1] * f[2] - p[2] * f[1]) * kTorque);
  tally.torque[1].add((p[2] * f[0] - p[0] * f[2]) * kTorque);
  tally.torque[2].add((p[0] * f[1] - p[1] * f[0]) * kTorque);
}

/// rs_cut_force().
void cut_force(const SubstepArgs& a, const OutlineView& outline, PieceList list, const Reals* p, Reals energy,
               Tally& tally) {
  const Reals zero = {}, one = zero + 1.0F;
  const float *w = a.angular_velocity, *v0 = a.origin_velocity;
  const Reals vx = v0[0] + (w[1] * p[2] - w[2] * p[1]);
  const Reals vy = v0[1] + (w[2] * p[0] - w[0] * p[2]);
  const Reals vz = v0[2] + (w[0] * p[1] - w[1] * p[0]);
  const Reals speed = root(vx * vx + vy * vy + vz * vz);
  const Reals per_speed = speed > 0.0F ? one / speed : zero;
  const Reals tangential = energy * (speed > a.speed_floor ? per_speed * a.per_duration : zero + a.floor_rate);
  const Reals over_floor = speed > a.speed_floor ? zero : energy * (one - speed * a.per_speed_floor);
  tally.floor_energy.add(over_floor * static_cast<float>(RS_ENERGY_SCALE));
  Reals n[3];
  normal_at(outline, list, p, n);
  const Reals along = (n[0] * vx + n[1] * vy + n[2] * vz) * per_speed;
  const Reals normal = speed > 0.0F ? a.normal_ratio * tangential : zero;
  const Reals against = (tangential - normal * along) * per_speed;
  const Reals f[3] = {-(against * vx) - normal * n[0], -(against * vy) - normal * n[1],
                      -(against * vz) - normal * n[2]};
  add_force(tally, f, p);
}

// ---- Bricks ----

/// The edges that can be nearest to any voxel of the brick whose lowest voxel's centre is `corner`, T.
PieceList edges_near_brick(const SubstepArgs& a, const OutlineView& outline, const float* corner) {
  float p[3];
  for (int i = 0; i < 3; ++i) {
    const double* row = a.tool_from_voxel + 3 * i;
    p[i] = corner[i] + static_cast<float>(3.5 * (row[0] + row[1] + row[2]));
  }
  return rs_pieces_near(&outline, __builtin_sqrtf(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/// Lists the places of the touched voxels, in ascending order and padded to a multiple of the lanes; returns how many.
int list_places(const Brick& brick, const rs_u64* bits_of_byte, rs_u16* places) {
  int count = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) {
    const rs_u32 word = brick.touched[w];
    if (word == 0) continue;
    for (int b = 0; b < 4; ++b) {
      const rs_u32 byte = word >> 8 * b & 0xffU;
      const Places bits = __builtin_convertvector(load<Bytes>(bits_of_byte + byte), Places);
      store(bits + static_cast<rs_u16>(32 * w + 8 * b), places + count);
      count += __builtin_popcount(byte);
    }
  }
  store(Shorts{} + places[0], places + count);
  return count;
}

void hand_over_removed(Frame& f, Tally& tally) {
  if (tally.waiting_count == 0) return;
  RemovedBlock* to = f.removed + __atomic_fetch_add(&f.removed_count, tally.waiting_count, __ATOMIC_RELAXED);
  __builtin_memcpy(to, tally.waiting, sizeof(RemovedBlock) * tally.waiting_count);
  tally.waiting_count = 0;
}

/// Takes the listed voxels away: their energies, and their bits out of the brick.
void lose_all(Frame& f, rs_u32 slot, const rs_u16* places, int count, float* energies, Tally& tally) {
  Brick& brick = f.bricks[slot];
  for (int i = 0; i < count; ++i) {
    const rs_u8 grade = brick.grade[places[i]];
    tally.energy += f.units[grade];
    energies[i] = static_cast<float>(f.energy[grade]);
  }
  tally.contacts += count;
  store(Reals{}, energies + count);
  for (rs_u32 block = 0; block < RS_BRICK_WORDS / 2; ++block) {
    const rs_u32 low = brick.touched[2 * block], high = brick.touched[2 * block + 1];
    if ((low | high) == 0) continue;
    brick.bone[2 * block] &= ~low;
    brick.bone[2 * block + 1] &= ~high;
    brick.touched[2 * block] = brick.touched[2 * block + 1] = 0;
    if (tally.waiting_count == kWaiting) hand_over_removed(f, tally);
    tally.waiting[tally.waiting_count++] = {f.lattice_of_slot[slot], block, low | static_cast<rs_u64>(high) << 32};
  }
}

/// The law for the listed voxels of the brick at voxel (x, y, z).
void push_back(const Frame& f, const rs_i32* voxel, const rs_u16* places, const float* energies, int count,
               Tally& tally) {
  const SubstepArgs& a = *f.args;
  float corner[3], step[9];
  rs_brick_in_tool(&a, voxel[0], voxel[1], voxel[2], corner);
  for (int i = 0; i < 9; ++i) step[i] = static_cast<float>(a.tool_from_voxel[i]);
  const PieceList list = edges_near_brick(a, f.outline, corner);
  for (int i = 0; i < count; i += kLanes) {
    const Ints place = ints_of(places + i);
    const Reals x = __builtin_convertvector((place >> 6 & 1) << 2 | (place & 3), Reals);
    const Reals y = __builtin_convertvector((place >> 7 & 1) << 2 | (place >> 2 & 3), Reals);
    const Reals z = __builtin_convertvector((place >> 8 & 1) << 2 | (place >> 4 & 3), Reals);
    Reals p[3];
    for (int c = 0; c < 3; ++c) p[c] = corner[c] + (step[3 * c] * x + step[3 * c + 1] * y + step[3 * c + 2] * z);
    cut_force(a, f.outline, list, p, load<Reals>(energies + i), tally);
  }
}

/// Clears the bit of a brick in which nothing is left.
void clear_if_empty(Frame& f, const Brick& brick, rs_i32 x, rs_i32 y, rs_i32 z) {
  rs_u32 left = 0;
  for (const rs_u32 word : brick.bone) left |= word;
  if (left != 0) return;
  const rs_i32 nx = (f.brick_dims[0] + 3) >> 2, ny = (f.brick_dims[1] + 3) >> 2;
  const rs_i32 superbrick = (x >> 2) + nx * ((y >> 2) + ny * (z >> 2));
  const auto bit = static_cast<rs_u32>((x & 3) | (y & 3) << 2 | (z & 3) << 4);
  __atomic_fetch_and(&f.occupancy[2 * superbrick + static_cast<rs_i32>(bit >> 5)], ~(1U << (bit & 31U)),
                     __ATOMIC_RELAXED);
}

void cut_brick(Frame& f, rs_u32 slot, Tally& tally) {
  rs_u16 places[RS_BRICK_VOXELS + kPadding];
  float energies[RS_BRICK_VOXELS + kPadding];
  Brick& brick = f.bricks[slot];
  f.listed[slot] = 0;
  const rs_u32 index = f.lattice_of_slot[slot];
  const auto nx = static_cast<rs_u32>(f.brick_dims[0]), ny = static_cast<rs_u32>(f.brick_dims[1]);
  const rs_u32 row = index / nx;
  const auto x = static_cast<rs_i32>(index % nx), y = static_cast<rs_i32>(row % ny), z = static_cast<rs_i32>(row / ny);
  const int count = list_places(brick, f.bits_of_byte, places);
  lose_all(f, slot, places, count, energies, tally);
  const rs_i32 voxel[3] = {RS_BRICK_SIDE * x, RS_BRICK_SIDE * y, RS_BRICK_SIDE * z};
  push_back(f, voxel, places, energies, count, tally);
  clear_if_empty(f, brick, x, y, z);
}

void add(rs_i64& total, rs_i64 part) {
  __atomic_fetch_add(&total, part, __ATOMIC_RELAXED);
}

void add_to_frame(Frame& f, const Tally& tally) {
  for (int c = 0; c < 3; ++c) {
    add(f.sums.force[c], tally.force[c].total());
    add(f.sums.torque[c], tally.torque[c].total());
  }
  add(f.sums.energy, tally.energy);
  add(f.sums.floor_energy, tally.floor_energy.total());
  add(f.sums.removed, RS_WHOLE_FILL * tally.contacts);
  add(f.sums.contacts, tally.contacts);
}

}  // namespace

void cut(Frame& f) {
  Tally tally;
  for (;;) {
    const rs_u32 first = __atomic_fetch_add(&f.next_touched, kBricksAtOnce, __ATOMIC_RELAXED);
    if (first >= f.touched_count) break;
    const rs_u32 rest = f.touched_count - first, count = rest < kBricksAtOnce ? rest : kBricksAtOnce;
    for (rs_u32 t = first; t < first + count; ++t) cut_brick(f, f.touched_list[t], tally);
  }
  hand_over_removed(f, tally);
  add_to_frame(f, tally);
}

}  // namespace reamsim::reference::REAMSIM_TARGET
