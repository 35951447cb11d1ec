# ---- a hand pushes: feed and power over depth and time
do for [c in "time_s feed_mm_s hand_power_w drill_power_w thrust_n depth_mm"] { stats csv using c nooutput name c }
step = int(ceil(time_s_records / 12000.0))

do for [format in "png svg pdf"] {
  eval page("plots/push", format, 170, 190)
  set multiplot layout 4,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8, char 3.2

  set xlabel "Tool depth (mm)" offset 0, 0.6
  set ylabel "Feed (mm/s)" offset -0.4
  set xrange [0:max(depth_mm_max, 1e-3)]
  set yrange [0:high(0, feed_mm_s_max)]
  plot csv using (column("depth_mm") >= 0 ? column("depth_mm") : NaN):"feed_mm_s" every step with lines lw 1.2 lc rgb dark_blue notitle

  set xlabel "Time (s)" offset 0, 0.6
  set xrange [0:time_s_max]
  set ylabel "Tool depth (mm)"
  set yrange [min(depth_mm_min, 0):high(0, depth_mm_max)]
  plot csv using "time_s":"depth_mm" every step with lines lw 1.5 lc rgb purple notitle

  set ylabel "Force (N)"
  set key bottom right
  set yrange [0:high(0, thrust_n_max)]
  plot csv using "time_s":"thrust_n" every step with lines lw 1.5 lc rgb light_blue title "thrust", \
       csv using "time_s":"hand_force_n" every step with lines lw 1.2 lc rgb dark_blue title "hand"

  set ylabel "Power (W)"
  set key center right
  set yrange [0:high(0, max(hand_power_w_max, drill_power_w_max))]
  plot csv using "time_s":"drill_power_w" every step with lines lw 1.2 lc rgb dark_red title "drive", \
       csv using "time_s":"hand_power_w" every step with lines lw 1.5 lc rgb dark_blue title "hand"
  unset multiplot
  unset output
}
