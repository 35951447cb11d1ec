csv = "plots/removed_density.csv"
do for [c in "removed_mm3 density_to_g_cm3"] { stats csv using c nooutput name c }

# A histogram says nothing of bone that has about one density: a line of text says it.
stats csv using (column("removed_mm3") == removed_mm3_max ? column("density_to_g_cm3") : NaN) nooutput name "M"
stats csv using (column("removed_mm3") == removed_mm3_max ? column("density_from_g_cm3") : NaN) nooutput name "L"
uniform = removed_mm3_max >= 0.98 * removed_mm3_sum
sentence = removed_mm3_sum > 0 ? \
           sprintf("%.4g mm³ removed, %.4g %% of it with\n%g to %g g/cm³: no histogram", removed_mm3_sum, 100 * removed_mm3_max / removed_mm3_sum, L_min, M_max) : \
           "No bone was removed: no histogram"

set key off
set style fill solid 0.85 border rgb "white"
set xrange [0:density_to_g_cm3_max]
set yrange [0:high(0, removed_mm3_max)]
set xlabel "Bone density (g/cm³)"
set ylabel "Removed volume (mm³)"
set mxtics 2
middle(a, b) = 0.5 * (a + b)

do for [format in "png svg pdf"] {
  eval page("plots/removed_density", format, 85, uniform ? 14 : 65)
  if (uniform) {
    unset border; unset tics; unset grid; unset xlabel; unset ylabel
    set lmargin 0; set rmargin 0; set tmargin 0; set bmargin 0
    set label 1 sentence at screen 0.5, screen 0.65 center
    plot NaN notitle
    unset output
    continue
  }
  set lmargin 9; set rmargin 2; set tmargin 1; set bmargin 3.5
  plot csv using (middle(column("density_from_g_cm3"), column("density_to_g_cm3"))):"removed_mm3": \
         (column("density_to_g_cm3") - column("density_from_g_cm3")) with boxes lc rgb dark_blue
  unset output
}
