# ---- what the run holds
if (!exists("csv")) csv = "forces.csv"
if (!exists("bucket_rows")) bucket_rows = 1
stats csv using "time_s" nooutput name "T"
step = bucket_rows > 1 ? 1 : int(ceil(T_records / 12000.0))
