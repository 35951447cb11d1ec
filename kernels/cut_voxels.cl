/* Cut: every voxel of the contact list loses fill, takes energy and pushes back (design §5). Work-items stride over the
 * list, whose length only the device knows, so that nothing waits for the host. */
#ifndef REAMSIM_KERNELS_SHARED_H
#include "shared.h"
#endif
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

void add_sums(__global SubstepSums* total, const SubstepSums* part) {
  for (int c = 0; c < 3; ++c) {
    atom_add(&total->force[c], part->force[c]);
    atom_add(&total->torque[c], part->torque[c]);
  }
  atom_add(&total->energy, part->energy);
  atom_add(&total->floor_energy, part->floor_energy);
  atom_add(&total->removed, part->removed);
  atom_add(&total->contacts, part->contacts);
}

/* energy_of_grade[256]: mJ for a whole voxel; density_of_grade[256]: g/cm3; fill: 16 bits a voxel, or one dummy entry when
 * every voxel is whole (has_fill = 0); removed: (voxel, frame) of voxels that go. */
__kernel void cut_voxels(__global const SubstepArgs* args, const uint substep, __global uchar* bone,
                         __global ushort* fill, const int has_fill, __global uint* claims,
                         __global const uint* contacts, __global const uint* contact_count,
                         __global SubstepSums* sums, __global uint2* removed, __global uint* removed_count,
                         __global const double* energy_of_grade, __global const double* density_of_grade,
                         __global const ProfileEdge* edges, __global const ushort* numbers,
                         __global const EdgeList* lists, __global const ProfileGrid* grid) {
  __global const SubstepArgs* a = args + substep;
  const uint count = contact_count[substep];
  const ProfileView profile = {edges, numbers, lists, grid};
  SubstepSums part = {{0, 0, 0}, {0, 0, 0}, 0, 0, 0, 0};
  LaneSums law = {{0, 0, 0}, {0, 0, 0}, 0};
  for (uint c = get_global_id(0); c < count; c += get_global_size(0)) {
    const uint e = contacts[c];
    const uchar grade = bone[e];
    const int before = has_fill ? fill[e] : RS_WHOLE_FILL;
    const int lost = rs_lost_fill(a, density_of_grade[grade], before);
    part.contacts += 1;
    part.removed += lost;
    const double energy = rs_lost_energy(energy_of_grade[grade], lost);
    part.energy += rs_energy_units(energy);
    if (a->law == RS_LAW_ENERGY) {
      const uint row = e / (uint)a->dims[0];
      rs_voxel_force(a, &profile, (int)(e % (uint)a->dims[0]), (int)(row % (uint)a->dims[1]),
                     (int)(row / (uint)a->dims[1]), energy, &law);
    }
    if (has_fill) fill[e] = (ushort)(before - lost);
    if (lost == before) {
      bone[e] = 0;
      removed[atomic_inc(removed_count)] = (uint2)(e, (uint)a->frame);
    }
    atomic_and(&claims[e >> 5], ~(1u << (e & 31u)));
  }
  rs_add_lanes(&part, &law);
  if (part.contacts != 0) add_sums(&sums[substep], &part);
}
