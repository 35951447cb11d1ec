#include "run.gp"
do for [c in "axial_force_n spin_torque_nmm"] { stats $rows using value(c) nooutput name c }
stats $mean using 2 nooutput name "A"
stats $mean using 3 nooutput name "B"

# Force and torque of every frame (of very many, every n-th). Where voxels go whole, frames are spikes: then they stand
# in a light colour, on top the mean over a layer of voxels, and what lies far above the mean leaves the panel.
array load_of[2] = [axial_force_n, spin_torque_nmm]
array title_of[2] = ["Axial force (N)", "Spin torque (N·mm)"]
array headline_of[2] = [headline_force, headline_torque]
array least[2] = [axial_force_n_min, spin_torque_nmm_min]
array most[2] = [axial_force_n_max, spin_torque_nmm_max]
array most_of_means[2] = [A_max, B_max]
array light[2] = [light_blue, light_red]
array dark[2] = [dark_blue, dark_red]
clip(peak, mean) = mean > 0 && peak > 4 * mean ? 4 * mean : peak
note(peak, mean) = mean > 0 && peak > 4 * mean ? sprintf(" (up to %.3g)", peak) : ""
light_title = bucket_rows > 1 ? sprintf("extremes of every %d frames", bucket_rows) : \
              step > 1 ? sprintf("every %d frames", step) : "each frame"
mean_title = sprintf("mean over %g mm of travel, one voxel", travel_mm)
set key top left reverse Left
# Below the key, where there is one.
label_y = travel_mm > 0 ? 0.72 : 0.93

