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

/// Outward unit normal of the profile at the point nearest to (r, z): rs_profile_nearest().
void profile_normal(const ProfileView& profile, EdgeList list, Reals r, Reals z, Reals& normal_r, Reals& normal_z) {
  const Reals zero = {}, one = zero + 1.0F;
  Reals best = zero + 1e30F, best_side = zero, beside = zero, dr = zero, dz = zero, nr = zero, nz = -one;
  for (rs_u32 i = 0; i < list.count; ++i) {
    const ProfileEdge& e = profile.edges[profile.numbers[list.first + i]];
    const Reals vr = r - e.r0, vz = z - e.z0;
    const Reals along = (vr * e.along_r + vz * e.along_z) * e.inverse_length2;
    Reals t = along > 0.0F ? along : zero;
    t = t < 1.0F ? t : one;
    const Reals pr = t < 1.0F ? vr - t * e.along_r : r - e.r1, pz = t < 1.0F ? vz - t * e.along_z : z - e.z1;
    const Reals d2 = pr * pr + pz * pz;
    const Reals side = pr * e.normal_r + pz * e.normal_z;
    const Reals abs_side = side < 0.0F ? -side : side, abs_best = best_side < 0.0F ? -best_side : best_side;
    const Reals rounding = best * 2e-6F + 1e-10F;
    const Reals tie = d2 <= best + rounding ? abs_side - abs_best : -one;
    const Reals gain = d2 < best - rounding ? one : tie;
    best = gain > 0.0F ? d2 : best;
    best_side = gain > 0.0F ? side : best_side;
    beside = gain > 0.0F ? (t == along ? one : zero) : beside;
    dr = gain > 0.0F ? pr : dr;
    dz = gain > 0.0F ? pz : dz;
    nr = gain > 0.0F ? zero + e.normal_r : nr;
    nz = gain > 0.0F ? zero + e.normal_z : nz;
  }
  const Reals signed_inverse = (best_side < 0.0F ? -one : one) / root(best);
  beside = best > 1e-12F ? beside : one;
  normal_r = beside > 0.0F ? nr : dr * signed_inverse;
  normal_z = beside > 0.0F ? nz : dz * signed_inverse;
}

/// rs_tool_nearest().
void normal_at(const ProfileView& profile, EdgeList list, const Reals* p, Reals* normal) {
  const Reals zero = {};
  const Reals r = root(p[0] * p[0] + p[1] * p[1]);
  Reals radial;
  profile_normal(profile, list, r, p[2], radial, normal[2]);
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
void cut_force(const SubstepArgs& a, const ProfileView& profile, EdgeList list, const Reals* p, Reals energy,
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
  normal_at(profile, list, p, n);
  const Reals along = (n[0] * vx + n[1] * vy + n[2] * vz) * per_speed;
  const Reals normal = speed > 0.0F ? a.normal_ratio * tangential : zero;
  const Reals against = (tangential - normal * along) * per_speed;
  const Reals f[3] = {-(against * vx) - normal * n[0], -(against * vy) - normal * n[1],
                      -(against * vz) - normal * n[2]};
  add_force(tally, f, p);
}

// ---- Bricks ----

/// The edges that can be nearest to any voxel of the brick whose lowest voxel's centre is `corner`, T.
EdgeList edges_near_brick(const SubstepArgs& a, const ProfileView& profile, const float* corner) {
  float p[3];
  for (int i = 0; i < 3; ++i) {
    const double* row = a.tool_from_voxel + 3 * i;
    p[i] = corner[i] + static_cast<float>(3.5 * (row[0] + row[1] + row[2]));
  }
  return rs_edges_near(&profile, __builtin_sqrtf(p[0] * p[0] + p[1] * p[1]), p[2]);
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
  const EdgeList list = edges_near_brick(a, f.profile, corner);
  for (int i = 0; i < count; i += kLanes) {
    const Ints place = ints_of(places + i);
    const Reals x = __builtin_convertvector((place >> 6 & 1) << 2 | (place & 3), Reals);
    const Reals y = __builtin_convertvector((place >> 7 & 1) << 2 | (place >> 2 & 3), Reals);
    const Reals z = __builtin_convertvector((place >> 8 & 1) << 2 | (place >> 4 & 3), Reals);
    Reals p[3];
    for (int c = 0; c < 3; ++c) p[c] = corner[c] + (step[3 * c] * x + step[3 * c + 1] * y + step[3 * c + 2] * z);
    cut_force(a, f.profile, list, p, load<Reals>(energies + i), tally);
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
