# ---- main effects: a column of panels for each parameter, those that explain most first; a row for each result
set termoption noenhanced  # names of keys have underscores
panel_height = results > 6 ? 27.0 : 31.0
gap = 3.5
wide = 180.0
left_edge = 23.0
bottom_edge = label_mm + 9.0
step = (wide - left_edge - 3.0) / parameters
# A few parameters do not make panels wider than high enough to read.
step = step > 62 ? 62.0 : step
wide = left_edge + parameters * step + 3.0
wide = wide < 110 ? 110.0 : wide
narrow = wide < 165  # the heading takes two lines
heading = "Mean ± SD over all other parameters; grey: single runs" . (narrow ? "\n" : "; ") . "%: fraction of the variance explained"
top_edge = narrow ? 13.0 : 9.0
tall = top_edge + results * panel_height + (results - 1) * gap + bottom_edge
from_top(mm) = 1 - mm / tall
# Two to five tics.
decade(span) = 10 ** floor(log10(span / 3))
tic(span) = span > 0 ? (span / decade(span) >= 20 ? 10 : span / decade(span) >= 10.5 ? 5 : span / decade(span) >= 5 ? 2 : 1) * decade(span) : 1
percent(fraction) = fraction < 0.005 ? "< 1 %" : sprintf("%.0f %%", 100 * fraction)
explained = 0

do for [format in "png svg pdf"] {
  eval "set terminal " . terminal(format, wide, tall)
  set termoption noenhanced
  set output "effects." . format
  dot = format eq "png" ? 3.1 : 1  # pngcairo counts pixels
  set multiplot
  set key off
  do for [r = 1:results] {
    set tmargin at screen from_top(top_edge + (r - 1) * (panel_height + gap))
    set bmargin at screen from_top(top_edge + (r - 1) * (panel_height + gap) + panel_height)
    set yrange [y_low[r]:y_high[r]]
    set ytics tic(0.8 * (y_high[r] - y_low[r]))
    do for [p = 1:parameters] {
      panel = (p - 1) * results + r - 1
      set lmargin at screen (left_edge + (p - 1) * step) / wide
      set rmargin at screen (left_edge + p * step - 2.5) / wide
      set xrange [x_low[p]:x_high[p]]
      set format y (p == 1 ? "%g" : "")
      set format x (r == results ? "%g" : "")
      if (slanted[p]) { set xtics rotate by 40 right offset 0.6,0.1 } else { set xtics norotate center offset 0,0.2 }
      if (named[p]) { set xtics () } else { set xtics tic((step < 35 ? 1.2 : 0.8) * (x_high[p] - x_low[p])) }
      name_column = r == results ? 4 : 6  # the sixth is blank
      unset label
      stats $means index panel using (explained = column(5), column(2)) nooutput
      set label 1 percent(explained) at graph 0.97,0.92 right textcolor rgb grey
      if (p == 1) { set label 4 y_title[r] at screen 3.2 / wide, graph 0.5 center rotate by 90 }
      if (r == results) {
        set label 3 x_title[p] at screen (left_edge + (p - 0.5) * step - 1.2) / wide, screen 6.0 / tall center
      }
      if (r == 1 && p == 1) {
        set label 2 heading \
          at screen left_edge / wide, from_top(4.5) left textcolor rgb grey
      }
      if (named[p]) {
        plot $runs using p:parameters + r with points pt 7 ps 0.28 * dot lc rgb "#c4c9cf", \
             $means index panel using 1:(joined[p] ? column(2) : NaN) with lines lw 1.4 lc rgb dark_blue, \
             "" index panel using 1:2:3 with yerrorbars pt 7 ps 0.55 * dot lw 1.1 lc rgb dark_blue, \
             "" index panel using 1:2:xtic(name_column) with points pt 7 ps 0.55 * dot lc rgb dark_blue
      } else {
        plot $runs using p:parameters + r with points pt 7 ps 0.28 * dot lc rgb "#c4c9cf", \
             $means index panel using 1:(joined[p] ? column(2) : NaN) with lines lw 1.4 lc rgb dark_blue, \
             "" index panel using 1:2:3 with yerrorbars pt 7 ps 0.55 * dot lw 1.1 lc rgb dark_blue
      }
    }
  }
  unset multiplot
  unset label
  unset output
}
