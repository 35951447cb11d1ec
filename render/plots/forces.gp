#include "contact.gp"
#include "means.gp"
stats $rows using (in_view(column(depth_mm))) nooutput name "D"

do for [format in "png svg pdf"] {
  eval page("forces", format, 170, 190)
  set multiplot layout 4,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8
  set format x ""
  eval bare_tics
  eval pass_labels
  unset xlabel

  do for [i = 1:2] {
    set ylabel title_of[i] offset -0.4
    set label 1 headline_of[i] at graph 0.012, graph label_y left front
    top = clip(most[i], most_of_means[i])
    set yrange [low(min(least[i], 0), top):high(min(least[i], 0), top)]
    if (travel_mm > 0) {
      plot $rows using @at:load_of[i] every step with lines lw 0.6 lc rgb light[i] \
             title light_title . note(most[i], most_of_means[i]), \
           $mean using @mean_at:i + 1 with lines lw 1.5 lc rgb dark[i] title mean_title
    } else {
      plot $rows using @at:load_of[i] every step with lines lw 1.2 lc rgb dark[i] notitle
    }
  }

  unset label 1
  set ylabel "Removed volume (mm³)"
  set yrange [low(0, removed_mm3_sum):high(0, removed_mm3_sum)]
  removed = 0.0
  plot $rows using @at:(removed = removed + column(removed_mm3)) with lines lw 1.5 lc rgb green notitle

  set format x "%g"
  eval labelled_tics
  set xlabel "Time (s)" . time_note
  set ylabel "Tool depth (mm)"
  # Drawn back, the tool is far above the bone; that part of the curve leaves the panel.
  bottom = D_max > 0 ? max(min(D_min, 0), -0.25 * D_max) : min(D_min, 0)
  set yrange [low(bottom, D_max):high(bottom, D_max)]
  set label 1 headline_depth at graph 0.012, graph 0.93 left front
  plot $rows using @at:depth_mm with lines lw 1.5 lc rgb purple notitle
  unset label 1
  unset multiplot
  unset output
}
