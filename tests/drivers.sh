#!/bin/sh
# What a driver can get wrong, on a second one: SwiftShader, a part of Chromium. Its subgroups have four lanes, and
# it has too few images for goblet's arrays.
#
#   sh tests/drivers.sh
#
# GOBLET_TESTS=full runs all tests of kernels and compares all references. SWIFTSHADER names its driver file
# (vk_swiftshader_icd.json), if that is not where Debian's chromium has it.
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
# Runs tests of a suite: all, or those that have one of the texts in their names. A text that no test has is an error.
suite() {
    name=$1
    shift
    listed=$(cargo test --locked --workspace --test "$name" -- --list)
    for text; do
        if ! echo "$listed" | grep -qF "$text"; then
            echo "drivers.sh: no test of $name has $text in its name" >&2
            exit 1
        fi
    done
    cargo test --locked --workspace --test "$name" -- "$@"
}

# shellcheck disable=SC2086 # lists of names
suite kernels $kernels
# shellcheck disable=SC2086
suite physics metamorphic::batches metamorphic::the_size_of_workgroups submission::an_iteration $references
