#!/usr/bin/env bash
# From nothing to a report: installs what is needed, builds, and measures the speeds in a sample clip.
# Safe to run again; the second time it only measures.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh
mkdir -p build
cmake --preset release >build/configure_release.log 2>&1 || { cat build/configure_release.log >&2; exit 1; }
cmake --build build/release

sample=data_samples/straight
out=demo_out
build/release/pipelines/vildar run "$sample/clip.mp4" --photodiode "$sample/photodiode.csv" \
  --site "$sample/site.yaml" --out "$out" --annotate

cat <<TEXT

the truth of this sample, to compare with:   $sample/truth_vehicles.csv
report, open it in a browser:                $PWD/$out/report.html
annotated video:                             $PWD/$out/annotated.mp4
TEXT
