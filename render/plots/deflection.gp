# ---- a tool on springs: deflection and force over time
do for [c in "time_s deflection_x_mm deflection_y_mm deflection_z_mm axial_force_n depth_mm"] { stats csv using c nooutput name c }
lateral(x, y) = sqrt(x**2 + y**2)
across(fx, fy, fz, axial) = sqrt(max(fx**2 + fy**2 + fz**2 - axial**2, 0))
stats csv using (across(column("force_x_n"), column("force_y_n"), column("force_z_n"), column("axial_force_n"))) nooutput name "L"
step = int(ceil(time_s_records / 12000.0))

do for [format in "png svg pdf"] {
  eval page("plots/deflection", format, 170, 150)
  set multiplot layout 3,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8, char 3.2
  set key top left

  set xlabel "Time (s)" offset 0, 0.6
  set xrange [0:time_s_max]
  set ylabel "Deflection (mm)" offset -0.4
  least = min(deflection_x_mm_min, min(deflection_y_mm_min, deflection_z_mm_min))
  most = max(deflection_x_mm_max, max(deflection_y_mm_max, deflection_z_mm_max))
  set yrange [low(least, most):high(least, most)]
  plot csv using "time_s":"deflection_x_mm" every step with lines lw 1.2 lc rgb dark_blue title "x of the tool", \
       csv using "time_s":"deflection_y_mm" every step with lines lw 1.2 lc rgb dark_red title "y", \
       csv using "time_s":"deflection_z_mm" every step with lines lw 1.2 lc rgb green title "z"

  set ylabel "Force (N)"
  set yrange [low(min(axial_force_n_min, 0), max(axial_force_n_max, L_max)):high(min(axial_force_n_min, 0), max(axial_force_n_max, L_max))]
  plot csv using "time_s":"axial_force_n" every step with lines lw 1.2 lc rgb dark_blue title "axial", \
       csv using "time_s":(across(column("force_x_n"), column("force_y_n"), column("force_z_n"), column("axial_force_n"))) every step with lines lw 1.2 lc rgb orange title "lateral"

  set xlabel "Lateral deflection (mm)" offset 0, 0.6
  set xrange [0:high(0, max(lateral(deflection_x_mm_max, deflection_y_mm_max), lateral(deflection_x_mm_min, deflection_y_mm_min)))]
  set ylabel "Tool depth (mm)"
  set yrange [high(0, max(depth_mm_max, 0)):0]
  plot csv using (lateral(column("deflection_x_mm"), column("deflection_y_mm"))):"depth_mm" every step with lines lw 1.5 lc rgb purple notitle
  unset multiplot
  unset output
}
