# ---- force, torque and removed volume of every run, against time (left) and depth (right)
csv = "curves.csv"
stats csv using "time_s" nooutput name "T"
stats csv using "depth_mm" nooutput name "D"
stats csv using "axial_force_n" nooutput name "F"
stats csv using "spin_torque_nmm" nooutput name "M"
stats csv using "removed_mm3" nooutput name "V"
t_max = T_max > T_min ? T_max : T_min + 1
array column_of[3] = ["axial_force_n", "spin_torque_nmm", "removed_mm3"]
array title_of[3] = ["Axial force (N)", "Spin torque (N·mm)", "Removed volume (mm³)"]
array least[3] = [min(F_min, 0), min(M_min, 0), 0]
array most[3] = [F_max, M_max, V_max]

array shade[8] = [dark_blue, dark_red, green, orange, purple, "#56b4e9", "#000000", "#999999"]
color(i) = shade[(i - 1) % 8 + 1]
# The first run's line is the widest, so that equal curves show as well.
width(i) = i == 1 ? 2.4 : 1.2
of(i, y) = column("run") == i ? y : NaN
touching(i, y) = column("run") == i && column("contact") > 0 ? y : NaN

# The legend has a strip of its own above the panels, mm.
rows_of_key = int(ceil(runs / 2.0))
strip = 4.2 * rows_of_key + 3
panel_height = 42.0
panel_step = 46.5
tall = strip + 3 * panel_step + 9

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, 170, tall)
  set output "compare." . format
  set multiplot
  do for [panel = 1:3] {
    upper_edge = 1 - (strip + panel_step * (panel - 1)) / tall
    set tmargin at screen upper_edge
    set bmargin at screen upper_edge - panel_height / tall
    set yrange [low(least[panel], most[panel]):high(least[panel], most[panel])]
    set format x (panel == 3 ? "%g" : "")

    set lmargin at screen 0.1
    set rmargin at screen 0.535
    set format y "%g"
    set ylabel title_of[panel] offset -0.4
    set xrange [T_min:t_max]
    if (panel == 3) { set xlabel "Time (s)" }
    if (panel == 1) {
      set key at screen 0.1, screen 1 - 1.5 / tall left top vertical Left reverse maxrows rows_of_key
    }
    plot for [i = 1:runs] csv using (of(i, column("time_s"))):(column(column_of[panel])) with lines lw width(i) \
         lc rgb color(i) title label[i] noenhanced
    unset key

    set lmargin at screen 0.565
    set rmargin at screen 0.985
    set format y ""
    unset ylabel
    set xrange [0:high(0, D_max)]
    if (panel == 3) { set xlabel "Tool depth (mm)" }
    plot for [i = 1:runs] csv using (touching(i, column("depth_mm"))):(column(column_of[panel])) with lines lw width(i) \
         lc rgb color(i) notitle
  }
  unset multiplot
  unset xlabel
  unset output
}
