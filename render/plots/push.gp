# ---- a hand pushes: feed and power over depth and time
stats csv using "time_s" nooutput name "T"
stats csv using "feed_mm_s" nooutput name "V"
stats csv using "hand_power_w" nooutput name "H"
stats csv using "drill_power_w" nooutput name "P"
stats csv using "thrust_n" nooutput name "F"
stats csv using "depth_mm" nooutput name "D"
step = int(ceil(T_records / 12000.0))

do for [format in "png svg pdf"] {
  eval page("plots/push", format, 170, 190)
  set multiplot layout 4,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8, char 3.2

  set xlabel "Tool depth (mm)" offset 0, 0.6
  set ylabel "Feed (mm/s)" offset -0.4
  set xrange [0:max(D_max, 1e-3)]
  set yrange [0:high(0, V_max)]
  plot csv using (column("depth_mm") >= 0 ? column("depth_mm") : NaN):"feed_mm_s" every step with lines lw 1.2 lc rgb dark_blue notitle

  set xlabel "Time (s)" offset 0, 0.6
  set xrange [0:T_max]
  set ylabel "Tool depth (mm)"
  set yrange [min(D_min, 0):high(0, D_max)]
  plot csv using "time_s":"depth_mm" every step with lines lw 1.5 lc rgb purple notitle

  set ylabel "Force (N)"
  set key bottom right
  set yrange [0:high(0, F_max)]
  plot csv using "time_s":"thrust_n" every step with lines lw 1.5 lc rgb light_blue title "thrust", \
       csv using "time_s":"hand_force_n" every step with lines lw 1.2 lc rgb dark_blue title "hand"

  set ylabel "Power (W)"
  set key center right
  set yrange [0:high(0, max(H_max, P_max))]
  plot csv using "time_s":"drill_power_w" every step with lines lw 1.2 lc rgb dark_red title "drive", \
       csv using "time_s":"hand_power_w" every step with lines lw 1.5 lc rgb dark_blue title "hand"
  unset multiplot
  unset output
}
