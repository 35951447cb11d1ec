# Figure of `reamsim bench`: makes bench.png and bench.svg. Change what you like and run it again here: gnuplot bench.gp

set encoding utf8
set datafile missing NaN
set border 3 lw 1.2 lc rgb "#404040"
set tics nomirror out textcolor rgb "#202020"
set grid xtics ytics lt 1 lw 0.8 lc rgb "#dcdcdc"

stats $severe using 4 nooutput name "M"
stats $severe using 5 nooutput name "P"
low = 10 ** floor(log10((exists("P_min") && P_min < M_min ? P_min : M_min) * 0.9))
high = 10 ** ceil(log10((exists("P_max") && P_max > M_max ? P_max : M_max) * 1.1))
only(i, v) = column(1) == i && column(2) == v
panels = words(voxmaps) + has_voi + 1

do for [format in "png svg"] {
  eval "set terminal " . (format eq "png" ? "pngcairo" : "svg dynamic") . \
       " size 1600,1000 background rgb 'white' font 'DejaVu Sans,15' linewidth 1.4"
  set output "bench." . format
  set multiplot layout (panels > 3 ? 2 : 1),3 title "Whole frame in severe contact on " . device . "; dashed: the paper, GTX 970" \
    noenhanced font ",17" margins char 9, char 3, char 4, char 4 spacing char 11, char 5.5

  set logscale xy
  set xrange [56:1170]
  set xtics ("64³" 64, "128³" 128, "256³" 256, "512³" 512, "1024³" 1024)
  set yrange [low:high]
  set format y "%g"
  set ylabel "ms" offset 1
  set xlabel "point shell" offset 0, 0.3
  unset key
  do for [w = 1:words(voxmaps)] {
    v = int(word(voxmaps, w))
    set title sprintf("voxmap %d³", v) font ",16"
    plot for [i = 1:programs] $severe using 3:(only(i, v) ? $4 : NaN) with linespoints pt 7 ps 0.9 lw 2 lc rgb color[i], \
         for [i = 1:programs] $severe using 3:(only(i, v) ? $5 : NaN) with linespoints pt 6 ps 0.7 lw 1.6 dt 2 lc rgb color[i]
  }

  if (has_voi) {
    unset logscale x
    set title "VOI, largest voxmap and shell" font ",16"
    set xrange [5:105]
    set xtics auto
    set xtics format "%g"
    set xlabel "VOI volume, % of the tool's box" offset 0, 0.3
    set yrange [*:*]
    set key bottom right samplen 2 textcolor rgb "#202020" font ",13"
    plot for [i = 1:programs] $voi using 2:(column(1) == i ? $3 : NaN) with linespoints pt 7 ps 0.8 lw 2 lc rgb color[i] notitle, \
         for [i = 1:programs] $voi using 2:(column(1) == i ? $4 : NaN) with lines lw 1.6 dt 3 lc rgb color[i] notitle, \
         NaN with lines lw 2 lc rgb "#606060" title "with VOI", NaN with lines lw 1.6 dt 3 lc rgb "#606060" title "without"
  }

  # The last panel is the key.
  unset title
  unset border
  unset xtics
  unset ytics
  unset grid
  unset xlabel
  unset ylabel
  unset logscale
  set xrange [0:1]
  set yrange [0:1]
  set key center left Left reverse samplen 3 spacing 1.4 textcolor rgb "#202020" font ",15"
  plot for [i = 1:programs] NaN with linespoints pt 7 lw 2 lc rgb color[i] title name[i] noenhanced, \
       NaN with linespoints pt 6 lw 1.6 dt 2 lc rgb "#606060" title "the paper, same method"
  unset multiplot
  unset output
  set border 3 lw 1.2 lc rgb "#404040"
  set xtics nomirror out
  set ytics nomirror out
  set grid xtics ytics lt 1 lw 0.8 lc rgb "#dcdcdc"
}
