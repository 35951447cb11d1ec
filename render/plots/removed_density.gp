csv = "plots/removed_density.csv"
stats csv using "removed_mm3" nooutput name "V"
stats csv using "density_to_g_cm3" nooutput name "R"

set key off
set style fill solid 0.85 border rgb "white"
set xrange [0:R_max]
set yrange [0:high(0, V_max)]
set xlabel "Bone density (g/cm³)"
set ylabel "Removed volume (mm³)"
set mxtics 2
middle(a, b) = 0.5 * (a + b)

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, 85, 65)
  set output "plots/removed_density." . format
  set lmargin 9; set rmargin 2; set tmargin 1; set bmargin 3.5
  plot csv using (middle(column("density_from_g_cm3"), column("density_to_g_cm3"))):"removed_mm3": \
         (column("density_to_g_cm3") - column("density_from_g_cm3")) with boxes lc rgb dark_blue
  unset output
}
