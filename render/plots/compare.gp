# ---- force, torque and removed volume of every run since first contact, against time (left) and depth (right)
csv = "curves.csv"
do for [c in "contact_time_s depth_mm axial_force_n spin_torque_nmm removed_mm3"] { stats csv using c nooutput name c }
# The time in which some run has contact.
t_last = 0
stats csv using (column("contact") > 0 && column("contact_time_s") > t_last ? (t_last = column("contact_time_s")) : 0) nooutput
t_max = t_last > 0 ? 1.04 * t_last : 1
array column_of[3] = ["axial_force_n", "spin_torque_nmm", "removed_mm3"]
array title_of[3] = ["Axial force (N)", "Spin torque (N·mm)", "Removed volume (mm³)"]
array least[3] = [min(axial_force_n_min, 0), min(spin_torque_nmm_min, 0), 0]
array most[3] = [axial_force_n_max, spin_torque_nmm_max, removed_mm3_max]

set dashtype 11 (14,5)
set dashtype 12 (3,4)
set dashtype 13 (14,4,2,4)
dash_type(d) = d == 1 ? 1 : 9 + d
ramp = colored_by ne ""
few = runs <= 20
# One pass over the file draws all runs of a dash type. The first row of a run is left out, which ends the line before it.
previous = 0
reached = 0
is_new(i) = i == previous ? 0 : (previous = i, reached = 0, 1)
drawn(d, y) = is_new(column("run")) || (few && column("run") == 1) || dash[int(column("run"))] != d ? NaN : y
of_first(y) = column("run") == 1 ? y : NaN
# From the first contact on, however small the force is at first; later only where the force is a hundredth of its maximum.
touching(y) = column("contact") > 0 ? (reached = 1, y) : reached || column("contact_time_s") < 0 ? NaN : y
begun(x) = (reached = (column(0) == 0 ? 0 : reached), few ? x : NaN)
since_contact(y) = column("contact_time_s") < 0 || column("contact_time_s") > t_max ? NaN : few ? y : touching(y)
color_of(i) = shade[int(i)]

# The legend has a strip of its own above the panels, mm.
rows_of_key = int(ceil(|entry| / (1.0 * columns_of_key)))
has_entries = entry[1] ne ""
strip = (has_entries ? 4.2 * rows_of_key : 0) + (ramp ? 13 : 0) + 3
panel_height = 42.0
panel_step = 46.5
tall = strip + 3 * panel_step + 9
from_top(mm) = 1 - mm / tall

do for [format in "png svg pdf"] {
  eval page("compare", format, 170, tall)
  set multiplot
  do for [panel = 1:3] {
    upper_edge = from_top(strip + panel_step * (panel - 1))
    set tmargin at screen upper_edge
    set bmargin at screen upper_edge - panel_height / tall
    set yrange [low(least[panel], most[panel]):high(least[panel], most[panel])]
    set format x (panel == 3 ? "%g" : "")

    set lmargin at screen 0.1
    set rmargin at screen 0.535
    set format y "%g"
    set ylabel title_of[panel] offset -0.4
    set xrange [0:t_max]
    if (panel == 3) { set xlabel "Time since first contact (s)" }
    unset key
    if (ramp && panel == 1) {
      do for [i = 1:|bar|] {
        set object i rectangle from screen 0.1 + 0.435 * (i - 1) / |bar|, screen from_top(4.5) \
          to screen 0.1 + 0.435 * (i + 0.15) / |bar|, screen from_top(1.5) fc rgb bar[i] fs solid 1.0 noborder front
      }
      do for [i = 0:4] {
        set label i + 1 sprintf("%.4g", ramp_low + (ramp_high - ramp_low) * i / 4) at screen 0.1 + 0.435 * i / 4, \
          screen from_top(6.7) center front
      }
      set label 6 colored_by at screen 0.565, screen from_top(3.2) left noenhanced front
    }
    if (panel == 1 && has_entries) {
      set key at screen 0.1, screen from_top(1.5 + (ramp ? 10 : 0)) left top vertical Left reverse samplen 4 \
        maxrows rows_of_key
    }
    plot for [i = 1:|entry|] NaN with lines lw 1.8 dt dash_type(entry_dash[i]) lc rgb entry_shade[i] \
           title entry[i] noenhanced, \
         csv using (begun(column("contact_time_s"))):(of_first(since_contact(column(column_of[panel])))) with lines \
           lw 2.4 dt dash_type(dash[1]) lc rgb shade[1] notitle, \
         for [d = 1:4] csv using (column("contact_time_s")):(drawn(d, since_contact(column(column_of[panel])))): \
           (color_of(column("run"))) with lines lw (few ? 1.2 : 1) dt dash_type(d) lc rgb variable notitle
    unset key
    if (panel == 1) {
      unset object
      unset label
    }

    set lmargin at screen 0.565
    set rmargin at screen 0.985
    set format y ""
    unset ylabel
    set xrange [0:high(0, depth_mm_max)]
    if (panel == 3) { set xlabel "Tool depth since first contact (mm)" }
    plot csv using (begun(column("depth_mm"))):(of_first(touching(column(column_of[panel])))) with lines lw 2.4 \
           dt dash_type(dash[1]) lc rgb shade[1] notitle, \
         for [d = 1:4] csv using (column("depth_mm")):(drawn(d, touching(column(column_of[panel])))): \
           (color_of(column("run"))) with lines lw (few ? 1.2 : 1) dt dash_type(d) lc rgb variable notitle
  }
  unset multiplot
  unset xlabel
  unset output
}
