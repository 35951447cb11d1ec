# ---- what the run holds
if (!exists("csv")) csv = "forces.csv"
if (!exists("bucket_rows")) bucket_rows = 1
stats csv using "time_s" nooutput name "T"
rows = T_records
t_min = T_min
t_max = T_max > T_min ? T_max : T_min + 1
stats csv using "axial_force_n" nooutput name "F"
stats csv using "spin_torque_nmm" nooutput name "M"
#include "contact.gp"
stats csv using (in_view(column("depth_mm"))) nooutput name "D"

# Force and torque of every frame (of very many, every n-th). Where voxels go whole, frames are spikes: then they stand
# in a light colour, on top the mean over a layer of voxels, and what lies far above the mean leaves the panel.
stats $mean using 2 nooutput name "A"
stats $mean using 3 nooutput name "B"
clip(peak, mean) = mean > 0 && peak > 4 * mean ? 4 * mean : peak
note(peak, mean) = mean > 0 && peak > 4 * mean ? sprintf(" (up to %.3g)", peak) : ""
step = bucket_rows > 1 ? 1 : int(ceil(rows / 12000.0))
light_title = bucket_rows > 1 ? sprintf("extremes of every %d frames", bucket_rows) : \
              step > 1 ? sprintf("every %d frames", step) : "each frame"
mean_title = sprintf("mean over %g mm of travel, one voxel", travel_mm)

set key top left reverse Left
# Below the key, where there is one.
label_y = travel_mm > 0 ? 0.72 : 0.93

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, 170, 190)
  set output "forces." . format
  set multiplot layout 4,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8
  set format x ""
  eval bare_tics
  eval pass_labels
  unset xlabel

  set ylabel "Axial force (N)" offset -0.4
  set label 1 headline_force at graph 0.012, graph label_y left front
  top = clip(F_max, A_max)
  set yrange [low(min(F_min, 0), top):high(min(F_min, 0), top)]
  if (travel_mm > 0) {
    plot csv using (shown(column("time_s"))):"axial_force_n" every step with lines lw 0.6 lc rgb light_blue \
           title light_title . note(F_max, A_max), \
         $mean using (shown(column(1))):2 with lines lw 1.5 lc rgb dark_blue title mean_title
  } else {
    plot csv using (shown(column("time_s"))):"axial_force_n" every step with lines lw 1.2 lc rgb dark_blue notitle
  }

  set ylabel "Spin torque (N·mm)"
  set label 1 headline_torque
  top = clip(M_max, B_max)
  set yrange [low(min(M_min, 0), top):high(min(M_min, 0), top)]
  if (travel_mm > 0) {
    plot csv using (shown(column("time_s"))):"spin_torque_nmm" every step with lines lw 0.6 lc rgb light_red \
           title light_title . note(M_max, B_max), \
         $mean using (shown(column(1))):3 with lines lw 1.5 lc rgb dark_red title mean_title
  } else {
    plot csv using (shown(column("time_s"))):"spin_torque_nmm" every step with lines lw 1.2 lc rgb dark_red notitle
  }

  unset label 1
  set ylabel "Removed volume (mm³)"
  set yrange [low(0, V_sum):high(0, V_sum)]
  removed = 0.0
  plot csv using (shown(column("time_s"))):(removed = removed + column("removed_mm3")) with lines lw 1.5 lc rgb green notitle

  set format x "%g"
  eval labelled_tics
  set xlabel "Time (s)" . time_note
  set ylabel "Tool depth (mm)"
  # Drawn back, the tool is far above the bone; that part of the curve leaves the panel.
  bottom = D_max > 0 ? max(min(D_min, 0), -0.25 * D_max) : min(D_min, 0)
  set yrange [low(bottom, D_max):high(bottom, D_max)]
  set label 1 headline_depth at graph 0.012, graph 0.93 left front
  plot csv using (shown(column("time_s"))):"depth_mm" with lines lw 1.5 lc rgb purple notitle
  unset label 1
  unset multiplot
  unset output
}
