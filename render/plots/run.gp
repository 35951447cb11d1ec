# ---- what the run holds
if (!exists("csv")) csv = "forces.csv"
if (!exists("bucket_rows")) bucket_rows = 1
# The columns that are drawn, read once.
set table $rows separator comma
plot csv using (sprintf("%.10g", column("time_s"))):"removed_mm3":"depth_mm":"axial_force_n":"spin_torque_nmm":"energy_mj":"floor_energy_mj":"balance" with table
unset table
time_s = 1; removed_mm3 = 2; depth_mm = 3; axial_force_n = 4; spin_torque_nmm = 5; energy_mj = 6; floor_energy_mj = 7; balance = 8
do for [c in "time_s removed_mm3"] { stats $rows using value(c) nooutput name c }
step = bucket_rows > 1 ? 1 : int(ceil(time_s_records / 12000.0))
