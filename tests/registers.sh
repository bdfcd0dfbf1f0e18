#!/bin/sh
# What the compiler of AMD cards makes of the kernels, on a machine without one: Mesa's driver RADV compiles for a
# card that is not there. Prints a table, and fails if a plain kernel or one with bodies of revolution spills or
# leaves too few subgroups room, or if any kernel takes too long to compile: examples/kernel_stats.rs has the bounds.
#
#   sh tests/registers.sh [CARD]      navi21 unless another is named
#
# Takes 25 seconds of one core. RADV names the driver's file (radeon_icd.x86_64.json) if that is not where Debian's
# mesa-vulkan-drivers has it.
set -eu
cd "$(dirname "$0")/.."

driver=${RADV:-}
for file in /usr/share/vulkan/icd.d/radeon_icd*.json; do
    [ -n "$driver" ] || driver=$file
done
if [ ! -f "$driver" ]; then
    echo "registers.sh: no RADV; run sh install.sh --tests, or name its radeon_icd.x86_64.json in RADV" >&2
    exit 1
fi
. tests/build.sh
cargo build --locked --workspace --example kernel_stats
export VK_DRIVER_FILES="$driver" VK_ICD_FILENAMES="$driver"
# Else kernels that were compiled before take no time.
export RADV_FORCE_FAMILY="${1:-navi21}" MESA_SHADER_CACHE_DISABLE=true
"${CARGO_TARGET_DIR:-target}/debug/examples/kernel_stats" --check
