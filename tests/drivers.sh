#!/bin/sh
# What a driver can get wrong, on a second one: SwiftShader, a part of Chromium. Its subgroups have four lanes, and
# it has too few images for goblet's arrays.
#
#   sh tests/drivers.sh
#
# GOBLET_TESTS=full runs all tests of kernels and compares all references. SWIFTSHADER names its driver file (vk_swiftshader_icd.json), if that is
# not where Debian's chromium has it.
set -eu
cd "$(dirname "$0")/.."

driver=${SWIFTSHADER:-}
for folder in /usr/lib/chromium /usr/lib/chromium-browser /opt/google/chrome /snap/chromium/current/usr/lib/chromium-browser; do
    [ -n "$driver" ] || [ ! -f "$folder/vk_swiftshader_icd.json" ] || driver=$folder/vk_swiftshader_icd.json
done
if [ ! -f "$driver" ]; then
    echo "drivers.sh: no SwiftShader; install chromium, or name its vk_swiftshader_icd.json in SWIFTSHADER" >&2
    exit 1
fi
. tests/build.sh
export VK_DRIVER_FILES="$driver" VK_ICD_FILENAMES="$driver"

if [ "${GOBLET_TESTS:-}" = full ]; then
    kernels=
    references=reference::
else
    kernels="subgroup:: trace:: grid:: flux:: sum:: circle:: sampling::"
    references="reference::caustic_point reference::cornell reference::layered"
fi
# shellcheck disable=SC2086 # lists of names
cargo test --locked --workspace --test kernels -- $kernels
# shellcheck disable=SC2086
cargo test --locked --workspace --test physics -- \
    metamorphic::batches metamorphic::the_size_of_workgroups $references
