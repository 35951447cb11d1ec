#!/usr/bin/env bash
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Makes docs/images/gallery again, the pictures of docs/gallery.md, and those of the guide: docs/make_gallery.sh [WORK FOLDER]. Takes a built reamsim
# (./run.sh), ffmpeg, and REAMSIM_DATA, the folder that holds the CT and the mesh. Some five minutes on two cores.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
reamsim=${REAMSIM:-$root/build/release/cli/reamsim}
work=${1:-$root/out/gallery}
to=$root/docs/images/gallery
: "${REAMSIM_DATA:?the folder that holds shoulder_ct and scapula_mesh}"
mkdir -p "$to" "$work"

# make SCENARIO [--set KEY=VALUE...]: runs it into $work/SCENARIO.
make() { "$reamsim" run "$root/trajectories/$1.yaml" -o "$work/$1" --overwrite --quiet "${@:2}"; }
# draw SCENARIO OPTION...: draws it again, in other ways.
draw() { "$reamsim" render "$work/$1" --quiet "${@:2}"; }
# keep FILE NAME [WIDTH]: shrinks a picture into the gallery.
keep() { ffmpeg -v error -y -i "$work/$1" -vf "scale=${3:-1200}:-1:flags=area" -q:v 4 "$to/$2.jpg"; }
# guide FILE NAME WIDTH: shrinks a picture into those of the guide, with a palette.
guide() {
  ffmpeg -v error -y -i "$work/$1" -vf "scale=$3:-1:flags=area,split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none" "$to/../guide/$2.png"
}
# frame SCENARIO N [SUFFIX]: the N-th picture along the run.
frame() { (cd "$work" && find "$1/frames" -regex '.*/[0-9]+'"${3-}"'\.png' | sort | sed -n "$2p"); }

make default
keep default/reamed.png default_oblique
keep default/contact_sheet.png default_contact_sheet
ffmpeg -v error -y -i "$work/default/reamed.png" -vf scale=1280:-1:flags=area "$root/docs/images/default.png"  # the README's
keep "$(frame default 7 _section)" default_section
draw default --only pictures --camera oblique --set render.tool_look=steel --set render.supersampling=2
keep "$(frame default 7)" default_steel
"$reamsim" run "$root/trajectories/default.yaml" -o "$work/deeper" --overwrite --quiet --set motion.plunge.depth_mm=2.5 --set render.enabled=false
"$reamsim" compare "$work/default" "$work/deeper" -o "$work/deeper_compare" --overwrite --quiet
guide deeper_compare/compare.png compare 1000                                                       # docs/guide/first-run.md
"$reamsim" init "$REAMSIM_DATA/shoulder_ct/shoulder_left.nrrd" -o "$work/glenoid.yaml" --overwrite --quiet
"$reamsim" check "$work/glenoid.yaml" --picture "$work/glenoid.png" --overwrite >"$work/glenoid.txt"  # docs/guide/ct.md
guide glenoid.png ct_check 1200
make ct_shoulder
keep "$(frame ct_shoulder 6 _section)" ct_section
keep ct_shoulder/before_after.png ct_before_after
keep ct_shoulder/depth_map.png ct_depth_map 900
keep ct_shoulder/forces.png ct_forces 900
draw ct_shoulder --only pictures --set render.background=white --set render.supersampling=2 \
  --camera '{name: hero, frame: glenoid, position_mm: [45, 25, 85], fov_deg: 32}'
keep ct_shoulder/reamed_hero.png ct_hero
make ct_shoulder_push --set render.film=mp4
keep ct_shoulder_push/plots/push.png ct_push 900
ffmpeg -v error -y -ss 3 -i "$work/ct_shoulder_push/reamed.mp4" -frames:v 1 "$work/push_film.png"
keep push_film.png ct_push_film
"$reamsim" compare "$work/ct_shoulder" "$work/ct_shoulder_push" -o "$work/push_compare" --overwrite --quiet
keep push_compare/compare.png ct_push_compare 900
make mesh_scapula --set 'render.cameras=[overview, section]'
keep mesh_scapula/reamed.png mesh_overview
for reamer in convex flat; do
  make study_biconcave_$reamer --set 'render.cameras=[section, glenoid]'
  keep study_biconcave_$reamer/before_after.png biconcave_${reamer}
done
"$reamsim" compare "$work/study_biconcave_convex" "$work/study_biconcave_flat" -o "$work/compare" --overwrite --quiet
keep compare/compare.png biconcave_compare 900
"$reamsim" sweep run "$root/trajectories/studies/reamers.yaml" -o "$work/reamers" --quiet
ffmpeg -v error -y -i "$work/reamers/effects.png" -vf scale=1063:-1:flags=area "$root/docs/images/study_effects.png"  # docs/studies.md
"$reamsim" sweep run "$root/trajectories/studies/shoulder_errors.yaml" -o "$work/shoulder_errors" --quiet
ffmpeg -v error -y -i "$work/shoulder_errors/effects.png" -vf scale=1063:-1:flags=area "$root/docs/images/study_shoulder.png"
