# ---- what the run holds
if (!exists("csv")) csv = "forces.csv"
if (!exists("bucket_rows")) bucket_rows = 1
stats csv using "removed_mm3" nooutput name "V"
stats csv using "axial_force_n" nooutput name "F"
stats csv using "spin_torque_nmm" nooutput name "M"
stats csv using "depth_mm" nooutput name "D"
stats $mean using 2 nooutput name "A"
stats $mean using 3 nooutput name "B"

# Frames with at least 1 % of the greatest force only: drawn back, the tool says nothing, though a tooth may graze bone.
touching(y) = abs(column("axial_force_n")) > 0.01 * F_max ? y : NaN
touching_mean(y) = abs(column(2)) > 0.01 * A_max ? y : NaN
clip(peak, mean) = mean > 0 && peak > 4 * mean ? 4 * mean : peak
note(peak, mean) = mean > 0 && peak > 4 * mean ? sprintf(" (up to %.3g)", peak) : ""
step = bucket_rows > 1 ? 1 : int(ceil(V_records / 12000.0))
light_title = bucket_rows > 1 ? sprintf("extremes of every %d frames", bucket_rows) : \
              step > 1 ? sprintf("every %d frames", step) : "each frame"
mean_title = sprintf("mean over %g mm of travel, one voxel", travel_mm)

set xrange [min(D_min > 0 ? D_min : 0, 0):high(0, D_max)]
set mxtics 2
set key top left reverse Left
# Below the key, where there is one.
label_y = travel_mm > 0 ? 0.72 : 0.93

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, 85, 150)
  set output "plots/forces_depth." . format
  set multiplot layout 3,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8
  set format x ""
  unset xlabel

  set ylabel "Axial force (N)" offset -0.4
  set label 1 headline_force at graph 0.012, graph label_y left front
  top = clip(F_max, A_max)
  set yrange [low(min(F_min, 0), top):high(min(F_min, 0), top)]
  if (travel_mm > 0) {
    plot csv using "depth_mm":(touching(column("axial_force_n"))) every step with lines lw 0.6 lc rgb light_blue \
           title light_title . note(F_max, A_max), \
         $mean using 4:(touching_mean(column(2))) with lines lw 1.5 lc rgb dark_blue title mean_title
  } else {
    plot csv using "depth_mm":(touching(column("axial_force_n"))) every step with lines lw 1.2 lc rgb dark_blue notitle, \
         for [i = 1:passes] $pass_end using 1:2:5 every ::(i - 1)::(i - 1) with labels left offset 0.5, 0 notitle
  }

  set ylabel "Spin torque (N·mm)"
  set label 1 headline_torque
  top = clip(M_max, B_max)
  set yrange [low(min(M_min, 0), top):high(min(M_min, 0), top)]
  if (travel_mm > 0) {
    plot csv using "depth_mm":(touching(column("spin_torque_nmm"))) every step with lines lw 0.6 lc rgb light_red \
           title light_title . note(M_max, B_max), \
         $mean using 4:(touching_mean(column(3))) with lines lw 1.5 lc rgb dark_red title mean_title
  } else {
    plot csv using "depth_mm":(touching(column("spin_torque_nmm"))) every step with lines lw 1.2 lc rgb dark_red notitle, \
         for [i = 1:passes] $pass_end using 1:3:5 every ::(i - 1)::(i - 1) with labels left offset 0.5, 0 notitle
  }

  set format x "%g"
  set label 1 headline_depth at graph 0.012, graph 0.93 left front
  set xlabel "Tool depth (mm)" . (passes ? "; numbers: passes" : "")
  set ylabel "Removed volume (mm³)"
  set yrange [low(0, V_sum):high(0, V_sum)]
  removed = 0.0
  plot csv using "depth_mm":(removed = removed + column("removed_mm3"), touching(removed)) with lines lw 1.5 \
         lc rgb green notitle, \
       for [i = 1:passes] $pass_end using 1:4:5 every ::(i - 1)::(i - 1) with labels left offset 0.5, 0 notitle
  unset label 1
  unset multiplot
  unset output
}
