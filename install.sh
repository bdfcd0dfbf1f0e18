#!/bin/sh
# Installs what goblet needs besides Rust, on Debian and Ubuntu, without asking:
# a C++ compiler to build it, and the Vulkan loader and a driver to run it. The
# driver is lavapipe, which needs no GPU. What is there already is left alone.
#
#   sh install.sh            to build and render
#   sh install.sh --tests    for the tests too: the Vulkan validation layers, Xvfb, a browser that
#                            opens the reports of measurements, and the driver of AMD cards, whose
#                            compiler needs no card
set -eu

say() {
    echo "install.sh: $*" >&2
}

case "$*" in
    "") tests= ;;
    --tests) tests=yes ;;
    *)
        say "unknown arguments: $*; expected nothing or --tests"
        exit 2
        ;;
esac

# True if one of the paths exists.
found() {
    for path in "$@"; do
        if [ -e "$path" ]; then return 0; fi
    done
    return 1
}

missing=
need() {
    missing="$missing $1"
}

if ! command -v c++ >/dev/null || ! command -v cc >/dev/null; then
    need g++
fi
found /usr/lib/*/libvulkan.so.1 /usr/lib/libvulkan.so.1 /usr/lib64/libvulkan.so.1 \
    /usr/local/lib/libvulkan.so.1 /usr/local/lib/*/libvulkan.so.1 || need libvulkan1
# Any driver will do.
found "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-/nonexistent}}" /usr/share/vulkan/icd.d/*.json \
    /usr/local/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json || need mesa-vulkan-drivers
if [ "$tests" ]; then
    layer=explicit_layer.d/VkLayer_khronos_validation.json
    found "${VK_LAYER_PATH:-/nonexistent}/${layer#*/}" /usr/share/vulkan/$layer \
        /usr/local/share/vulkan/$layer /etc/vulkan/$layer || need vulkan-validationlayers
    found /usr/share/vulkan/icd.d/radeon_icd*.json "${RADV:-/nonexistent}" || need mesa-vulkan-drivers
    command -v chromium >/dev/null || command -v chromium-browser >/dev/null ||
        command -v google-chrome >/dev/null || need chromium
    # A display for the window's test, and what windows load when they open.
    command -v Xvfb >/dev/null || need xvfb
    for library in libX11.so.6:libx11-6 libX11-xcb.so.1:libx11-xcb1 libXcursor.so.1:libxcursor1 \
        libXi.so.6:libxi6 libxkbcommon-x11.so.0:libxkbcommon-x11-0; do
        found /usr/lib/*/"${library%:*}" /usr/lib/"${library%:*}" /usr/lib64/"${library%:*}" || need "${library#*:}"
    done
fi

if [ -z "$missing" ]; then exit 0; fi
if ! command -v apt-get >/dev/null; then
    say "this system has no apt-get; please install what these Debian packages hold:$missing"
    exit 1
fi

sudo=
if [ "$(id -u)" -ne 0 ]; then
    sudo=sudo
    if ! command -v sudo >/dev/null; then
        say "please run this as root, since there is no sudo: apt-get install --no-install-recommends$missing"
        exit 1
    fi
fi
apt() {
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get -q "$@" </dev/null
}
say "installing$missing"
# The lists may be old or absent. Without a network they may still be good enough.
apt update || say "apt-get update failed; going on with the package lists there are"
# shellcheck disable=SC2086 # a list of names
apt install -y --no-install-recommends $missing
