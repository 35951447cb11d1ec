#include "run.gp"
t_min = time_s_min
t_max = time_s_max > time_s_min ? time_s_max : time_s_min + 1

# ---- the time axis: the time of contact with a margin, where the rest is more than a few per cent of the run
if (!exists("whole_run")) whole_run = 0  # 1: the whole run; also gnuplot -e "whole_run = 1"
if (!exists("passes")) passes = 0
gaps = whole_run ? 0 : passes
hidden_before(t) = gaps ? (sum [i = 1:gaps] (t >= hidden_to[i] ? hidden_to[i] - hidden_from[i] : 0)) : 0
in_gap(t) = gaps ? (sum [i = 1:gaps] (t > hidden_from[i] && t < hidden_to[i])) : 0
shown(t) = in_gap(t) ? NaN : t - hidden_before(t)  # place on the axis
# The same as the first part of `using` for $rows and $mean: a column where it serves, which is faster than a function.
at = gaps ? "(shown(column(time_s)))" : "time_s"
mean_at = gaps ? "(shown(column(1)))" : "1"
t_begin = t_min
t_end = t_max
if (!whole_run && removed_mm3_sum > 0) {
  stats $rows using (column(removed_mm3) > 0 ? column(time_s) : NaN) nooutput name "C"
  margin = 0.05 * (C_max > C_min ? shown(C_max) - shown(C_min) : t_max - t_min)
  worth_hiding = 0.05 * (t_max - t_min)
  t_begin = C_min - margin - t_min > worth_hiding ? C_min - margin : t_min
  t_end = t_max - C_max - margin > worth_hiding ? C_max + margin : t_max
}
hidden(from, to) = to > from ? sprintf(" %.3g–%.3g s", from, to) : ""
time_note = hidden(t_min, t_begin)
if (gaps) time_note = time_note . (time_note eq "" ? "" : ",") . " between passes"
time_note = time_note . (t_end < t_max && !(time_note eq "") ? " and" : "") . hidden(t_end, t_max)
if (!(time_note eq "")) time_note = "; without contact, not shown:" . time_note
in_view(y) = column(time_s) >= t_begin && column(time_s) <= t_end ? y : NaN
set xrange [shown(t_begin):shown(t_end)]
set mxtics 2
# With gaps the ticks have their times as labels, and a line parts the passes.
bare_tics = ""
labelled_tics = ""
pass_labels = ""
if (gaps) {
  rough = (shown(t_end) - shown(t_begin)) / 10
  power = 10.0**floor(log10(rough))
  tic = rough > 5 * power ? 10 * power : rough > 2 * power ? 5 * power : rough > power ? 2 * power : power
  between_tics = ""
  do for [k = int(ceil(t_begin / tic)):int(floor(t_end / tic))] {
    if (!in_gap(k * tic)) {
      bare_tics = bare_tics . between_tics . sprintf("\"\" %.9g", shown(k * tic))
      labelled_tics = labelled_tics . between_tics . sprintf("\"%g\" %.9g", k * tic, shown(k * tic))
      between_tics = ", "
    }
  }
  bare_tics = "set xtics (" . bare_tics . ")"
  labelled_tics = "set xtics (" . labelled_tics . ")"
  do for [i = 2:gaps] {
    set arrow (10 + i) from first shown(hidden_to[i]), graph 0 to first shown(hidden_to[i]), graph 1 nohead \
        dt (4, 3) lw 1 lc rgb "#666666" back
    pass_labels = pass_labels . sprintf("set label %d \"pass %d\" at first %.9g, graph 0.8 left offset 0.6, 0 front;", \
                                        10 + i, pass_number[i], shown(hidden_to[i]))
  }
}
