
# ---- the time axis: the time of contact with a margin, where the rest is more than a few per cent of the run
if (!exists("whole_run")) whole_run = 0  # 1: the whole run; also gnuplot -e "whole_run = 1"
t_begin = t_min
t_end = t_max
stats csv using "removed_mm3" nooutput name "V"
if (!whole_run && V_sum > 0) {
  stats csv using (column("removed_mm3") > 0 ? column("time_s") : NaN) nooutput name "C"
  margin = 0.05 * (C_max > C_min ? C_max - C_min : t_max - t_min)
  worth_hiding = 0.05 * (t_max - t_min)
  t_begin = C_min - margin - t_min > worth_hiding ? C_min - margin : t_min
  t_end = t_max - C_max - margin > worth_hiding ? C_max + margin : t_max
}
hidden(from, to) = to > from ? sprintf(" %.3g–%.3g s", from, to) : ""
between = t_begin > t_min && t_end < t_max ? " and" : ""
time_note = t_begin > t_min || t_end < t_max ? \
            "; without contact, not shown:" . hidden(t_min, t_begin) . between . hidden(t_end, t_max) : ""
in_view(y) = column("time_s") >= t_begin && column("time_s") <= t_end ? y : NaN
set xrange [t_begin:t_end]
set mxtics 2
