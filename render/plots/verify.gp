# Figure of `reamsim verify`: makes verification.png and verification.svg. Change what you like and run it again here:
# gnuplot verification.gp

set encoding utf8
set border 3 lw 1.2 lc rgb "#404040"
set tics nomirror out textcolor rgb "#202020"
set grid xtics ytics lt 1 lw 0.8 lc rgb "#dcdcdc"
set logscale xy

# Okabe and Ito's colours, which any colour vision tells apart
array color[8] = ["#0072b2", "#d55e00", "#009e73", "#8c4f86", "#e69f00", "#56b4e9", "#404040", "#a0a000"]
array title_of[2] = ["Volumes", "Forces and torques"]
only(i, p) = column(1) == i && column(2) == p

do for [format in "png svg"] {
  eval "set terminal " . (format eq "png" ? "pngcairo" : "svg dynamic") . \
       " size 1800,900 background rgb 'white' font 'DejaVu Sans,14' linewidth 1.4"
  set output "verification." . format
  set multiplot layout 1,2 title "Error against the closed form under refinement; grey: first and second order" font ",17"
  set key bottom right reverse Left samplen 2 font ",11" textcolor rgb "#202020"
  set ylabel "error (%)" offset 1
  set format y "10^{%L}"
  set format x "%g"
  set xtics (2, 1, 0.5, 0.25, 0.125, 0.0625)
  do for [p = 1:2] {
    set title title_of[p] font ",16"
    set xlabel "voxel (mm)"
    if (curves_in[p] > 0) {
      set autoscale
      stats $errors using ($2 == p ? $3 : NaN) nooutput name "X"
      stats $errors using ($2 == p ? $4 : NaN) nooutput name "Y"
      set xrange [X_min / 1.3:X_max * 1.3]
      # Room for the key below the curves
      set yrange [Y_min / 300:Y_max * 4]
      plot for [i = 1:curves] $errors using 3:(only(i, p) ? $4 : NaN) with linespoints pt 7 ps 0.9 lw 2 \
             lc rgb color[1 + (place[i] - 1) % 8] title (panel[i] == p ? name[i] : ""), \
           Y_max * (x / X_max) with lines lw 1.2 dt 3 lc rgb "#909090" notitle, \
           Y_max * (x / X_max) ** 2 with lines lw 1.2 dt 2 lc rgb "#909090" notitle
    } else {
      set multiplot next
    }
  }
  unset multiplot
  unset output
}
