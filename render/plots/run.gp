# ---- what the run holds
if (!exists("csv")) csv = "forces.csv"
if (!exists("bucket_rows")) bucket_rows = 1
do for [c in "time_s removed_mm3"] { stats csv using c nooutput name c }
step = bucket_rows > 1 ? 1 : int(ceil(time_s_records / 12000.0))
