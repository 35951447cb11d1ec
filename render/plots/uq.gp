# ---- bands of force and torque over time (left), and what the inputs change of their peaks (right)
set style fill transparent solid 0.35 noborder
tall = 110
array title_of[2] = ["Axial force (N)", "Spin torque (N·mm)"]
array peak_of[2] = ["Peak axial force (N)", "Peak spin torque (N·mm)"]
array band_of[2] = ["axial_force_n", "spin_torque_nmm"]
array color_of[2] = [dark_blue, dark_red]
from_top(mm) = 1 - mm / (1.0 * tall)
# Three to six tics: gnuplot's own would overlap on a panel of this width.
decade(span) = 10 ** floor(log10(span / 3))
tic(span) = span > 0 ? (span / decade(span) >= 20 ? 10 : span / decade(span) >= 10.5 ? 4 : span / decade(span) >= 5 ? 2 : 1) * decade(span) : 1

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, 180, tall)
  set termoption noenhanced  # names of keys have underscores
  set output "uq." . format
  set multiplot
  do for [panel = 1:2] {
    set tmargin at screen from_top(4 + 52 * (panel - 1))
    set bmargin at screen from_top(44 + 52 * (panel - 1))
    set lmargin at screen 0.09
    set rmargin at screen 0.42
    unset label
    set xrange [0:*]; set yrange [*:*]
    set xtics autofreq; set ytics autofreq
    set ylabel title_of[panel] offset 0.5
    set xlabel (panel == 2 ? "Time (s)" : "")
    if (panel == 2) { set key off } else { set key on top left }
    p = band_of[panel]
    plot "uq.csv" using "time_s":(column(p . "_p05")):(column(p . "_p95")) with filledcurves lc rgb color_of[panel] title "5–95 %", \
         "" using "time_s":(column(p . "_p50")) with lines lw 1.4 lc rgb color_of[panel] title "median"

    set key off
    set lmargin at screen 0.72
    set rmargin at screen 0.98
    set xrange [*:*]
    set yrange [rows[panel] + 0.5:0.5]
    unset ylabel
    set xlabel peak_of[panel] offset 0,0.3
    set xtics tic(span_of[panel])
    if (panel == 1) {
      set arrow 1 from mean_of[1], graph 0 to mean_of[1], graph 1 nohead lc rgb grey dt 2
      plot $axial using 2:1:2:3:($1 - 0.33):($1 + 0.33):ytic(4) with boxxyerror lc rgb color_of[1]
    } else {
      set arrow 1 from mean_of[2], graph 0 to mean_of[2], graph 1 nohead lc rgb grey dt 2
      plot $torque using 2:1:2:3:($1 - 0.33):($1 + 0.33):ytic(4) with boxxyerror lc rgb color_of[2]
    }
    unset arrow 1
  }
  unset multiplot
  unset output
}
