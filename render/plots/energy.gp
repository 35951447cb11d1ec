#include "contact.gp"
do for [c in "energy_mj floor_energy_mj"] { stats $rows using value(c) nooutput name c }
stats $mean using 5 nooutput name "P"

# The balance divides by what has been cut so far, so that its first frames say little: its scale begins at 1 % of all.
cut = 0.0
worst = 0.0
do_balance(e, b) = (cut = cut + e, cut > 0.01 * energy_mj_sum && abs(b) > worst ? (worst = abs(b)) : 0, 0)
stats $rows using (do_balance(column(energy_mj), column(balance))) nooutput name "Z"
power_of_ten = worst > 0 ? int(floor(log10(worst))) : 0
unit = power_of_ten == 0 ? "" : sprintf(" (10^{%d})", power_of_ten)
worst_shown = worst > 0 ? worst / 10.0**power_of_ten : 1

set key top left reverse Left

do for [format in "png svg pdf"] {
  eval page("plots/energy", format, 170, 150)
  set multiplot layout 3,1 margins char 11, char 2, char 3.5, char 1 spacing char 1.8
  set format x ""
  eval bare_tics
  eval pass_labels
  unset xlabel

  set ylabel "Cutting power (W)" offset -0.4
  set yrange [low(0, P_max):high(0, P_max)]
  plot $mean using @mean_at:5 with lines lw 1.5 lc rgb orange notitle
  unset label  # the key is there

  set ylabel "Energy (J)"
  top = max(energy_mj_sum, floor_energy_mj_sum) / 1000
  set yrange [low(0, top):high(0, top)]
  taken = 0.0
  cut = 0.0
  slow = 0.0
  plot $rows using @at:(taken = taken + column(energy_mj), taken / 1000) with lines lw 3.5 lc rgb light_blue \
         title "cutting energy", \
       $rows using @at:(cut = cut + column(energy_mj), cut * (1 + column(balance)) / 1000) with lines \
         lw 1 lc rgb dark_blue title "work of the drive + speed-floor energy", \
       $rows using @at:(slow = slow + column(floor_energy_mj), slow / 1000) with lines lw 1 dt (6, 4) \
         lc rgb dark_red title "speed-floor energy"

  set format x "%g"
  eval labelled_tics
  set xlabel "Time (s)" . time_note
  set ylabel "Energy balance" . unit
  set yrange [-1.3 * worst_shown:1.3 * worst_shown]
  plot $rows using @at:(column(balance) / 10.0**power_of_ten) every step with lines lw 1 lc rgb purple notitle
  unset multiplot
  unset output
}
