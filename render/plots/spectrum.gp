csv = "plots/spectrum.csv"
do for [c in "frequency_hz spin_torque_nmm"] { stats csv using c nooutput name c }

set key off
set xrange [0:min(shown_hz, frequency_hz_max)]
set yrange [0:1.25 * (spin_torque_nmm_max > 0 ? spin_torque_nmm_max : 1)]
set xlabel "Frequency (Hz)"
set ylabel "Amplitude of the spin torque (N·mm)"
set mxtics 2
set lmargin 10
set rmargin 2
set tmargin 1
set bmargin 3.5

do for [format in "png svg pdf"] {
  eval page("plots/spectrum", format, 170, 85)
  plot csv using "frequency_hz":"spin_torque_nmm" with lines lw 1.2 lc rgb dark_red, \
       $peaks using 1:2 with points pt 7 ps 0.35 lc rgb dark_blue, \
       $peaks using 1:2:3 with labels offset 0, 1.7 center tc rgb "#202020"
  unset output
}
