#include "means.gp"
stats $rows using depth_mm nooutput name "depth_mm"

# Frames with at least 1 % of the greatest force only: drawn back, the tool says nothing, though a tooth may graze bone.
touching(y) = abs(column(axial_force_n)) > 0.01 * axial_force_n_max ? y : NaN
touching_mean(y) = abs(column(2)) > 0.01 * A_max ? y : NaN

set xrange [min(depth_mm_min > 0 ? depth_mm_min : 0, 0):high(0, depth_mm_max)]
set mxtics 2

do for [format in "png svg pdf"] {
  eval page("plots/forces_depth", format, 85, 150)
  set multiplot layout 3,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8
  set format x ""
  unset xlabel

  do for [i = 1:2] {
    set ylabel title_of[i] offset -0.4
    set label 1 headline_of[i] at graph 0.012, graph label_y left front
    top = clip(most[i], most_of_means[i])
    set yrange [low(min(least[i], 0), top):high(min(least[i], 0), top)]
    if (travel_mm > 0) {
      plot $rows using depth_mm:(touching(column(load_of[i]))) every step with lines lw 0.6 lc rgb light[i] \
             title light_title . note(most[i], most_of_means[i]), \
           $mean using 4:(touching_mean(column(1 + i))) with lines lw 1.5 lc rgb dark[i] title mean_title
    } else {
      plot $rows using depth_mm:(touching(column(load_of[i]))) every step with lines lw 1.2 lc rgb dark[i] notitle, \
           for [k = 1:passes] $pass_end using 1:(column(1 + i)):5 every ::(k - 1)::(k - 1) with labels left offset 0.5, 0 notitle
    }
  }

  set format x "%g"
  set label 1 headline_depth at graph 0.012, graph 0.93 left front
  set xlabel "Tool depth (mm)" . (passes ? "; numbers: passes" : "")
  set ylabel "Removed volume (mm³)"
  set yrange [low(0, removed_mm3_sum):high(0, removed_mm3_sum)]
  removed = 0.0
  plot $rows using depth_mm:(removed = removed + column(removed_mm3), touching(removed)) with lines lw 1.5 \
         lc rgb green notitle, \
       for [i = 1:passes] $pass_end using 1:4:5 every ::(i - 1)::(i - 1) with labels left offset 0.5, 0 notitle
  unset label 1
  unset multiplot
  unset output
}
